"""Names, sentences and task instructions: what the parser understands, and whether the finished scene holds it.

    PYTHONPATH=scripts python3 -m bars.words [--target-dir target] [--scenes 300] [--tasks 200] [--generated 1000]

Names are parsed only. `scenes`, `tasks` and `generated` are how many sentences, instructions and generated sentences
become scenes as well; all of them are parsed. Relations of a scene are measured from scene.json (`scripts/measured.py`).
"""

import json
import shutil
import statistics
from collections import Counter, defaultdict

import words
from bars.page import arguments, lab_beside, percent, table, write
from bars.run import run
from described import Described
from generated_sentences import generated
from generating import generate
from measured import Measured
from server import Problem

EXACT_BAR, SENSIBLE_BAR, WRONG_BAR = 0.75, 0.95, 0.02
SENTENCES_BAR, START_BAR, GOAL_BAR, FIRST_BAR = 0.92, 0.98, 0.90, 0.995
# A generated scene may take this many times the median of those with as many objects.
SLOW = 3.0
# What is told of one entry that fails.
FEW = 4


def main() -> bool:
    given = arguments(__doc__.splitlines()[0], scenes=300, tasks=200, generated=words_generated())
    lab = lab_beside(given.binary)
    found = [
        names(lab),
        sentences(lab, given),
        tasks(lab, given),
        generated_scenes(lab, given),
    ]
    bars = [bar for part in found for bar in part.bars]
    rows = [[what, value, bar, "holds" if holds else "DOES NOT HOLD"] for what, value, bar, holds in bars]
    pages = [table(["", "found", "bar", ""], rows)] + [part.page for part in found]
    write("words", "Names, sentences and task instructions", "\n\n".join(pages))
    return all(holds for *_, holds in bars)


def words_generated() -> int:
    return len(generated())


class Part:
    """One section of the page: bars as (what, found, bar, whether it holds), and its text."""

    def __init__(self, title, bars, body, failures):
        self.bars = bars
        told = "\n".join(f"- {name}: {reason}" for name, reason in failures)
        self.page = f"## {title}\n\n{body}" + (f"\n\nWhat fails:\n\n{told}" if failures else "")


def names(lab) -> Part:
    every, ignored = words.names(), words.ignorable()
    counts, failures = defaultdict(Counter), []
    for name, outcome in zip(every, words.parse(lab, [name.text for name in every])):
        kind, categories, silent = words.outcome_of(name, outcome, ignored)
        counts[name.vocabulary][kind] += 1
        if kind not in ("exact", "stand-in") or (kind == "stand-in" and name.expected == "exact"):
            words_left = f" (no word on {', '.join(silent)})" if silent else ""
            read_as = f" as {', '.join(categories)}" if categories else ""
            failures.append((f"{name.vocabulary}, {name.name}", kind + read_as + words_left))
    total = sum(counts.values(), Counter())
    share = lambda *kinds: sum(total[kind] for kind in kinds) / len(every)
    rows = [
        [vocabulary, sum(found.values())] + [found[kind] for kind in words.OUTCOMES]
        for vocabulary, found in [*counts.items(), ("all", total)]
    ]
    exact, sensible, wrong = share("exact"), share("exact", "stand-in"), share("wrong")
    bars = [
        ("Names, exact", percent(exact), "75 %", exact >= EXACT_BAR),
        ("Names, exact or marked stand-in", percent(sensible), "95 %", sensible >= SENSIBLE_BAR),
        ("Names, wrong", percent(wrong), "at most 2 %", wrong <= WRONG_BAR),
        ("Names, silent", str(total["silent"]), "0", not total["silent"]),
    ]
    body = (
        "Each name is parsed as \"A table with a NAME\" and compared with `tests/words/vocabulary.tsv`. *Unmarked*: a "
        "plainer object of the kind that is not marked as a stand-in. *Silent*: a word of the name is neither used nor "
        "reported.\n\n"
        + table(["vocabulary", "names", *words.OUTCOMES], rows)
    )
    return Part("Names of five vocabularies", bars, body, failures)


def sentences(lab, given) -> Part:
    every, ignored = words.entries("sentences"), words.ignorable()
    chosen = {entry["id"] for entry in words.sample(every, given.scenes)}
    rows, failures, unaccounted = defaultdict(Counter), [], 0
    for entry, outcome in zip(every, words.parse(lab, [entry["text"] for entry in every])):
        silent = words.sentence_unaccounted(entry, outcome, ignored)
        unaccounted += len(silent)
        parsed = words.sentence_complaints(entry, outcome)
        scene, tells = parsed, is_reported(outcome)
        if entry["id"] in chosen and "description" in outcome and not entry.get("refused"):
            made = finished(given, "words", entry["id"], entry["text"], words.SEED, outcome)
            scene = made.complaints(lambda view: words.sentence_complaints(entry, outcome, view))
            tells = tells or bool(made.reasons)
        quiet = bool(scene) and not tells
        for kind in (entry["kind"], "all"):
            rows[kind].update(texts=1, parsed=not parsed, held=not scene, quiet=quiet, silent=len(silent))
        if parsed or scene or silent:
            told = [f"parse: {w}" for w in parsed[:FEW]] + [f"scene: {w}" for w in scene[:FEW] if w not in parsed]
            told += [f"no account of {', '.join(silent)}"] if silent else []
            failures.append((f"{entry['id']}, {entry['text']!r}", "; ".join(told)))
    share, quiet = rows["all"]["held"] / len(every), rows["all"]["quiet"]
    where = f"{len(chosen)} of {len(every)} in the finished scene" if len(chosen) < len(every) else "in the finished scene"
    bars = [
        (f"Sentences that hold, {where}", percent(share), "92 %", share >= SENTENCES_BAR),
        ("Sentences that do not hold and report nothing", str(quiet), "0", not quiet),
        ("Unaccounted words of sentences", str(unaccounted), "0", not unaccounted),
    ]
    rows["all"] = rows.pop("all")
    body = (
        f"{len(chosen)} of {len(every)} sentences of `tests/words/sentences.jsonl` become scenes.\n\n"
        + table(
            ["kind", "sentences", "understood", "hold", "fail and report nothing", "unaccounted words"],
            [[kind, c["texts"], c["parsed"], c["held"], c["quiet"], c["silent"]] for kind, c in rows.items()],
        )
    )
    return Part("Sentences", bars, body, failures)


def is_reported(outcome) -> bool:
    """Whether the answer says of anything that it was not done."""
    return "error" in outcome or bool(outcome["description"].get("unrecognized"))


def tasks(lab, given) -> Part:
    every, ignored = words.entries("tasks"), words.ignorable()
    chosen = {entry["id"] for entry in words.sample(every, given.tasks)}
    rows, failures = defaultdict(Counter), []
    for entry, outcome in zip(every, words.parse(lab, [entry["text"] for entry in every])):
        silent = words.sentence_unaccounted(entry, outcome, ignored)
        score = words.task_score(entry, outcome)
        scene, solved = score.scene, score.solved
        if entry["id"] in chosen and "description" in outcome:
            made = finished(given, "words", f"task_{entry['id']}", entry["text"], words.SEED, outcome)
            scene = made.complaints(lambda view: words.task_score(entry, outcome, view).scene)
            solved = made.view is None or words.task_score(entry, outcome, made.view).solved
        for kind in (entry["kind"], "all"):
            rows[kind].update(texts=1, before=not solved, goal=not score.goal, scene=not scene, silent=len(silent))
        if solved or score.goal or scene or silent:
            told = ["solved or without a goal"] if solved else []
            told += score.goal[:FEW] + [f"scene: {w}" for w in scene[:FEW]]
            told += [f"no account of {', '.join(silent)}"] if silent else []
            failures.append((f"{entry['id']}, {entry['text']!r}", "; ".join(told)))
    before, right = rows["all"]["before"] / len(every), rows["all"]["goal"] / len(every)
    bars = [
        ("Tasks whose start does not satisfy the goal", percent(before), "98 %", before >= START_BAR),
        ("Tasks with the right goal", percent(right), "90 %", right >= GOAL_BAR),
    ]
    rows["all"] = rows.pop("all")
    body = (
        f"{len(chosen)} of {len(every)} instructions of `tests/words/tasks.jsonl` become scenes.\n\n"
        + table(
            ["kind", "tasks", "start before the goal", "goal right", "start as told", "unaccounted words"],
            [[kind, c["texts"], c["before"], c["goal"], c["scene"], c["silent"]] for kind, c in rows.items()],
        )
    )
    return Part("Task instructions", bars, body, failures)


def generated_scenes(lab, given) -> Part:
    every, ignored = generated(), words.ignorable()
    failures, seconds, passed = [], defaultdict(list), 0
    parsed_right = silent_words = tried = 0
    # The parser takes one seed for all texts; each of these has its own.
    for text in every:
        tried += 1
        (outcome,) = words.parse(lab, [text.text], text.seed)
        wrong = words.sentence_complaints(text.expectation, outcome)
        silent = words.sentence_unaccounted(text.expectation, outcome, ignored)
        parsed_right, silent_words = parsed_right + (not wrong), silent_words + len(silent)
        told = [f"parse: {w}" for w in wrong[:FEW]] + ([f"no account of {', '.join(silent)}"] if silent else [])
        if tried <= given.generated and "description" in outcome:
            made = finished(given, "words", text.name, text.text, text.seed, outcome)
            passed += made.certified
            if made.seconds is not None:
                seconds[text.objects].append((made.seconds, text.name))
            told += [] if made.certified else made.reasons[:FEW] or ["not certified"]
        if told:
            failures.append((f"{text.name} (seed {text.seed}), {text.text!r}", "; ".join(told)))
    medians = {objects: statistics.median(s for s, _ in runs) for objects, runs in seconds.items()}
    slow = [(name, f"{s:.1f} s, the median of {objects} objects is {medians[objects]:.1f} s")
            for objects, runs in seconds.items() for s, name in runs if s > SLOW * medians[objects]]
    scenes = min(len(every), given.generated)
    first = passed / scenes if scenes else 0.0
    bars = [
        (f"{scenes} generated sentences, certified at the first attempt", percent(first), "99.5 %", first >= FIRST_BAR),
        ("Generated scenes over three times the median time", str(len(slow)), "0", not slow),
    ]
    rows = [
        [objects, len(runs), f"{medians[objects]:.1f}", f"{max(runs)[0]:.1f}"]
        for objects, runs in sorted(seconds.items())
    ]
    body = (
        f"{parsed_right} of {len(every)} sentences of `scripts/generated_sentences.py` are understood; {silent_words} "
        "words have no account.\n\n" + table(["objects", "scenes", "median s", "slowest s"], rows)
    )
    return Part("Generated sentences", bars, body, failures + slow)


class Finished:
    """One scene, or why there is none."""

    def __init__(self, view, reasons, certified, seconds):
        self.view, self.reasons, self.certified, self.seconds = view, reasons, certified, seconds

    def complaints(self, of_view) -> list:
        if self.view is None:
            return self.reasons
        return self.view.differences() + (of_view(self.view) if not self.view.differences() else [])


def finished(given, folder, name, text, seed, outcome) -> Finished:
    print(f"{name} ...", flush=True)
    out = given.work / folder / name
    try:
        made = generate(given.binary, out, text, seed)
    except Problem as problem:
        return Finished(None, [str(problem).splitlines()[-1].strip()], False, None)
    scene = json.loads((out / "scene.json").read_text(encoding="utf-8"))
    view = Measured(scene, Described(outcome["description"]))
    certified = made.told["verdict"] == "pass"
    # A bundle with nothing to look into is not needed any more, and a thousand would fill the disk.
    if certified:
        shutil.rmtree(out, ignore_errors=True)
    return Finished(view, made.told["reasons"], certified, made.seconds)


if __name__ == "__main__":
    run(main)
