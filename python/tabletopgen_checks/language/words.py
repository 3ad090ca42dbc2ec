"""The expectations of tests/words: names, sentences and task instructions, and what the parser makes of them."""

import csv
import json
import re
import subprocess
import tempfile
import tomllib
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from tabletopgen_checks.language.description import Described, unaccounted
from tabletopgen_checks.language.expectations import Cast, complaints
from tabletopgen_checks.language.goals import goal_complaints, is_satisfied
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import CATALOG, WORDS

GRAMMAR = CATALOG / "words.toml"
SEED = 32
# What is demanded of the names, the sentences and the instructions, as shares; nothing may be silent or unaccounted.
EXACT_BAR, SENSIBLE_BAR, WRONG_BAR = 0.75, 0.95, 0.02
SENTENCES_BAR, START_BAR, GOAL_BAR = 0.92, 0.98, 0.90
# The outcomes of a name, best first.
OUTCOMES = ("exact", "stand-in", "unmarked", "refused", "wrong", "silent")


@dataclass
class Name:
    """A name of a vocabulary and what it should become; see tests/words/README.md."""

    vocabulary: str
    name: str
    expected: str
    exact: list
    sensible: list
    text: str = field(init=False)

    def __post_init__(self):
        self.text = f"A table with {'an' if self.name[0] in 'aeiou' else 'a'} {self.name}"


def names() -> list:
    with (WORDS / "vocabulary.tsv").open(encoding="utf-8", newline="") as table:
        return [
            Name(row["vocabulary"], row["name"], row["expected"], split(row["exact"]), split(row["sensible"]))
            for row in csv.DictReader(table, delimiter="\t")
        ]


def split(cell: str) -> list:
    return cell.split("|") if cell else []


def entries(table: str) -> list:
    """The entries of `sentences` or `tasks`."""
    lines = (WORDS / f"{table}.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines if line.strip()]


def sample(every: list, count: int) -> list:
    """`count` of them, spread evenly, always the same."""
    count = min(count, len(every))
    return [every[k * len(every) // count] for k in range(count)]


def ignorable() -> frozenset:
    """Words that need no place in the account of a text: the closed list of the grammar."""
    return frozenset(tomllib.loads(GRAMMAR.read_text(encoding="utf-8"))["grammar"].get("ignorable", ()))


def parse(lab: Path, texts, seed: int = SEED) -> list:
    """What the parser makes of the texts: a `description` or an `error` each."""
    with tempfile.NamedTemporaryFile("w", suffix=".jsonl", encoding="utf-8") as file:
        file.writelines(json.dumps(text) + "\n" for text in texts)
        file.flush()
        command = [str(lab), "parse", "--texts", file.name, "--seed", str(seed)]
        try:
            run = subprocess.run(command, capture_output=True, text=True, timeout=600)
        except OSError as error:
            raise Problem(f"{lab} does not start: {error.strerror}; build it with `make lab`") from error
        except subprocess.TimeoutExpired:
            raise Problem(f"{len(texts)} texts were not parsed within 600 s") from None
    outcomes = [json.loads(line) for line in run.stdout.splitlines()]
    if run.returncode != 0 or len(outcomes) != len(texts):
        raise Problem(f"`{' '.join(command)}` gave {len(outcomes)} answers: {run.stderr.strip()[-1000:]}")
    return outcomes


def outcome_of(name: Name, outcome: dict, ignored) -> tuple:
    """(one of OUTCOMES, the categories found, the words of the name without account)."""
    if "error" in outcome:
        return ("exact" if name.expected == "refuse" else "refused"), [], []
    description = outcome["description"]
    silent = [word for word in unaccounted(name.text, description, ignored) if word in re.findall(r"\w+", name.name)]
    objects = [item for item in Described(description).objects if item.requested]
    found = sorted({item.category for item in objects})
    if silent:
        return "silent", found, silent
    if not objects:
        reported = bool(description.get("unrecognized"))
        refused = "exact" if name.expected == "refuse" else "refused"
        return (refused if reported else "silent"), found, silent
    if all(item.category in name.exact and not item.stand_in for item in objects):
        return "exact", found, silent
    if all(item.category in name.exact or item.stand_in for item in objects):
        return "stand-in", found, silent
    if all(item.category in (*name.exact, *name.sensible) or item.stand_in for item in objects):
        return "unmarked", found, silent
    return "wrong", found, silent


def sentence_complaints(entry: dict, outcome: dict, view=None) -> list:
    """What is not as the sentence asks for, in the description or in another view of it."""
    if "error" in outcome:
        return rejected_complaints(entry, outcome["error"])
    if entry.get("refused"):
        found = Counter(item["category"] for item in outcome["description"]["objects"])
        return [f"not refused, but {', '.join(f'{n} {category}' for category, n in found.items()) or 'an empty table'}"]
    view = view or Described(outcome["description"])
    wrong = complaints(entry, view)
    if "goal" in entry:
        cast = Cast(entry["objects"], [item for item in view.objects if item.requested])
        wrong += goal_complaints(entry["goal"], cast, view)
        wrong += ["the start satisfies the goal"] if is_satisfied(view.goal, view) else []
    return wrong


def rejected_complaints(entry: dict, error: dict) -> list:
    words = entry.get("message", "")
    if entry.get("refused"):
        said = words.lower() in error["message"].lower()
        return [] if said else [f"the message does not say {words}: {error['message']}"]
    # A contradiction that leaves nothing may be refused altogether.
    if entry.get("reported") and all(isinstance(o["count"], list) and o["count"][0] == 0 for o in entry["objects"]):
        return []
    return [f"refused: {error['message']}"]


def sentence_unaccounted(entry: dict, outcome: dict, ignored) -> list:
    return unaccounted(entry["text"], outcome["description"], ignored) if "description" in outcome else []


@dataclass
class TaskScore:
    scene: list
    goal: list
    # Whether the start satisfies the goal already, or there is no goal.
    solved: bool


def task_score(entry: dict, outcome: dict, view=None) -> TaskScore:
    if "error" in outcome:
        words = [f"refused: {outcome['error']['message']}"]
        return TaskScore(words, words, True)
    view = view or Described(outcome["description"])
    cast = Cast(entry["objects"], [item for item in view.objects if item.requested])
    solved = not view.goal or is_satisfied(view.goal, view)
    return TaskScore(complaints(entry, view), goal_complaints(entry["goal"], cast, view), solved)


def start_complaints(entry: dict, outcome: dict, view) -> list:
    """What a finished start of an instruction is not as stated, and whether it satisfies the goal already."""
    score = task_score(entry, outcome, view)
    return score.scene + (["the start satisfies the goal"] if score.solved else [])
