"""A fixed sample of the names, sentences and instructions, parsed, and a few of them as finished scenes.

`make bars BARS=words` measures all of them, and many more finished scenes. The bars are the same.
"""

from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from tabletopgen_checks.language import words
from tabletopgen_checks.language.scene_maker import SceneMaker, SceneText
from tabletopgen_checks.language.words import EXACT_BAR, GOAL_BAR, SENSIBLE_BAR, SENTENCES_BAR, START_BAR, WRONG_BAR
from tabletopgen_checks.problem import Problem

# Parsing takes milliseconds a text.
SAMPLE = 100
MIN_SHARES = {
    "names that are exact": EXACT_BAR,
    "names that are exact or marked stand-ins": SENSIBLE_BAR,
    "names that are no other object": 1 - WRONG_BAR,
    "sentences understood": SENTENCES_BAR,
    "instructions whose start is before the goal": START_BAR,
    "instructions with the right goal": GOAL_BAR,
}
# Sentences of several kinds and instructions whose finished scene has to hold what they ask for.
SCENES = ("distance_01", "place_01", "arrangement_01", "measure_01")
STARTS = ("pick_place_01", "stack_01")
# More failures than these are not listed.
FEW = 30


@dataclass
class Summary:
    # Share by line of MIN_SHARES.
    shares: dict
    # Words that are neither used nor reported, with their text.
    unaccounted: list
    failures: list
    # What the finished scenes do not hold.
    scenes: list = field(default_factory=list)

    def complaint(self) -> str:
        # A share of 98 of 100 reaches a bar of 0.98, whatever their difference is in floating point.
        below = [f"{what}: {100 * self.shares[what]:.1f} %, not {100 * min_share:g} %"
                 for what, min_share in MIN_SHARES.items() if self.shares[what] < min_share - 1e-9]
        below += [f"no account of {', '.join(self.unaccounted[:10])}"] if self.unaccounted else []
        return "; ".join(below + self.scenes)


def summary(lab: Path) -> Summary:
    ignored = words.ignorable()
    failures, unaccounted = [], []
    names = words.sample(words.names(), SAMPLE)
    kinds = []
    for name, outcome in zip(names, words.parse(lab, [name.text for name in names])):
        kind, categories, silent = words.outcome_of(name, outcome, ignored)
        kinds.append(kind)
        unaccounted += [f"{word!r} of {name.text!r}" for word in silent]
        if kind == "silent" and not silent:
            unaccounted.append(f"{name.text!r}")
        if kind not in ("exact", "stand-in"):
            failures.append(f"{name.text}: {kind} {', '.join(categories)}".rstrip())
    sentences = words.sample(words.entries("sentences"), SAMPLE)
    understood = 0
    for entry, outcome in zip(sentences, words.parse(lab, [entry["text"] for entry in sentences])):
        wrong = words.sentence_complaints(entry, outcome)
        understood += not wrong
        unaccounted += [f"{word!r} of {entry['id']}" for word in words.sentence_unaccounted(entry, outcome, ignored)]
        failures += [f"{entry['id']}: {'; '.join(wrong)}"] if wrong else []
    tasks = words.sample(words.entries("tasks"), SAMPLE)
    before = right = 0
    for entry, outcome in zip(tasks, words.parse(lab, [entry["text"] for entry in tasks])):
        score = words.task_score(entry, outcome)
        before, right = before + (not score.solved), right + (not score.goal)
        unaccounted += [f"{word!r} of {entry['id']}" for word in words.sentence_unaccounted(entry, outcome, ignored)]
        wrong = (["solved or without a goal"] if score.solved else []) + score.goal
        failures += [f"{entry['id']}: {'; '.join(wrong)}"] if wrong else []
    shares = {
        "names that are exact": kinds.count("exact") / len(kinds),
        "names that are exact or marked stand-ins": (kinds.count("exact") + kinds.count("stand-in")) / len(kinds),
        "names that are no other object": 1 - kinds.count("wrong") / len(kinds),
        "sentences understood": understood / len(sentences),
        "instructions whose start is before the goal": before / len(tasks),
        "instructions with the right goal": right / len(tasks),
    }
    return Summary(shares, unaccounted, failures)


def scene_complaints(lab: Path, binary: Path, folder: Path) -> list:
    """What the finished scenes of SCENES and STARTS do not hold, with the text's id."""
    asked = [(entry, False) for entry in words.entries("sentences") if entry["id"] in SCENES]
    asked += [(entry, True) for entry in words.entries("tasks") if entry["id"] in STARTS]
    outcomes = words.parse(lab, [entry["text"] for entry, _ in asked])
    refused = [f"{entry['id']}: no description" for (entry, _), o in zip(asked, outcomes) if "description" not in o]
    if refused:
        return refused
    wanted = [SceneText(entry["id"], entry["text"], words.SEED, o) for (entry, _), o in zip(asked, outcomes)]
    scenes = SceneMaker(binary, folder).make(wanted)
    wrong = []
    for (entry, is_task), outcome in zip(asked, outcomes):
        complaints = words.start_complaints if is_task else words.sentence_complaints
        found = scenes[entry["id"]].complaints(partial(complaints, entry, outcome))
        wrong += [f"scene of {entry['id']}: {'; '.join(found)}"] if found else []
    return wrong


def check(lab: Path, binary: Path, folder: Path) -> str:
    """A line about the sample; a problem if it is below what is demanded."""
    found = summary(lab)
    for words_of_one in found.failures[:FEW]:
        print(f"   - {words_of_one}", flush=True)
    found.scenes = scene_complaints(lab, binary, folder)
    if complaint := found.complaint():
        raise Problem(complaint)
    shares = [f"{what} {100 * share:.0f} %" for what, share in found.shares.items()]
    return "; ".join(shares + [f"{len(SCENES) + len(STARTS)} finished scenes hold"])
