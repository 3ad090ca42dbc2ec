"""A fixed sample of the names, sentences and instructions, parsed only: what `make test` can measure within seconds.

`make bars BARS=words` measures all of them, and the finished scenes. The least shares of the sample are somewhat below
what the parser reaches today, so that nothing gets worse unnoticed; the bars of docs/results/words.md are higher.
"""

from dataclasses import dataclass
from pathlib import Path

import words
from server import Problem

SAMPLE = 40
LEAST = {
    "names that are exact": 0.80, "names that are exact or marked stand-ins": 0.85, "sentences understood": 0.75,
    "instructions whose start is before the goal": 0.80, "instructions with the right goal": 0.75,
}
# More failures than these are not listed.
FEW = 30


@dataclass
class Summary:
    # Share by line of LEAST.
    shares: dict
    # Words that are neither used nor reported, with their text.
    unaccounted: list
    failures: list

    def complaint(self) -> str:
        below = [f"{what}: {100 * self.shares[what]:.0f} %, not {100 * least:.0f} %"
                 for what, least in LEAST.items() if self.shares[what] < least]
        below += [f"no account of {', '.join(self.unaccounted[:10])}"] if self.unaccounted else []
        return "; ".join(below)


def summary(lab: Path) -> Summary:
    ignored = words.ignorable()
    failures, unaccounted = [], []
    names = words.sample(words.names(), SAMPLE)
    kinds = []
    for name, outcome in zip(names, words.parse(lab, [name.text for name in names])):
        kind, categories, silent = words.outcome_of(name, outcome, ignored)
        kinds.append(kind)
        unaccounted += [f"{word!r} of {name.text!r}" for word in silent]
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
        "sentences understood": understood / len(sentences),
        "instructions whose start is before the goal": before / len(tasks),
        "instructions with the right goal": right / len(tasks),
    }
    return Summary(shares, unaccounted, failures)


def check(lab: Path) -> str:
    """A line about the sample; a problem if it is below what is demanded."""
    found = summary(lab)
    for words_of_one in found.failures[:FEW]:
        print(f"   - {words_of_one}", flush=True)
    if complaint := found.complaint():
        raise Problem(complaint)
    return "; ".join(f"{what} {100 * share:.0f} %" for what, share in found.shares.items())
