"""Names, sentences and task instructions: what the parser understands, and whether the finished scene holds it.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.words [--target-dir target] [--scenes 300] [--tasks 200] \\
        [--generated 1000]
        [--jobs 2]

All texts are parsed. `scenes`, `tasks` and `generated` are how many sentences, instructions and generated sentences
become scenes as well, `jobs` at once with one thread each; all of them take one to two hours on two cores. What is made
is kept under the target directory: the same program goes on where it was interrupted. Relations of a scene are measured
from scene.json (`tabletopgen_checks.language.measured`).
"""

import statistics
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor
from functools import partial

from tabletopgen_checks.bars.page import arguments, percent, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.language import words
from tabletopgen_checks.language.generated_sentences import SENTENCES, generated
from tabletopgen_checks.language.scene_maker import SceneMaker, SceneText
from tabletopgen_checks.language.words import EXACT_BAR, GOAL_BAR, SENSIBLE_BAR, SENTENCES_BAR, START_BAR, WRONG_BAR
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import lab_beside

DEPENDS_ON = (
    "config/catalog", "crates/base/catalog", "crates/models/embedded/src/layout",
    "crates/models/embedded/src/layout.rs", "crates/models/embedded/src/text_parser",
    "crates/models/embedded/src/text_parser.rs", "crates/method/physics", "crates/method/tasks",
    "python/tabletopgen_checks/language", "tests/words",
)
FIRST_BAR = 0.995
# A generated scene may take this many times the median of those with as many objects.
SLOW = 3.0
# Reasons that are listed of one entry that fails.
FEW = 4


def main() -> bool:
    given = arguments(__doc__, scenes=300, tasks=200, generated=SENTENCES, jobs=2)
    lab = lab_beside(given.binary)
    maker = SceneMaker(given.binary, given.work / "words", jobs=given.jobs)
    found = [
        names(lab),
        sentences(lab, maker, given.scenes),
        tasks(lab, maker, given.tasks),
        generated_scenes(lab, maker, given.generated),
    ]
    bars = [bar for part in found for bar in part.bars]
    rows = [[what, value, bar, "holds" if holds else "DOES NOT HOLD"] for what, value, bar, holds in bars]
    pages = [table(["", "found", "bar", ""], rows)] + [part.page for part in found]
    write("words", "Names, sentences and task instructions", "\n\n".join(pages), DEPENDS_ON)
    return all(holds for *_, holds in bars)


class Part:
    """One section of the page: bars as (what, found, bar, whether it holds), and its text."""

    def __init__(self, title, bars, body, failures):
        self.bars = bars
        reasons = "\n".join(f"- {name}: {reason}" for name, reason in failures)
        self.page = f"## {title}\n\n{body}" + (f"\n\nWhat fails:\n\n{reasons}" if failures else "")


def at_least(what, found, total, bar) -> tuple:
    """The bar of a share that has to be reached; of nothing, nothing is reached."""
    share = found / total if total else 0.0
    return what, f"{percent(share)} of {total}", f"{100 * bar:g} %", share >= bar


def none(what, found) -> tuple:
    return what, str(found), "0", not found


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
    rows = [
        [vocabulary, sum(found.values())] + [found[kind] for kind in words.OUTCOMES]
        for vocabulary, found in [*counts.items(), ("all", total)]
    ]
    sensible, wrong = total["exact"] + total["stand-in"], total["wrong"] / len(every)
    bars = [
        at_least("Names, exact", total["exact"], len(every), EXACT_BAR),
        at_least("Names, exact or marked stand-in", sensible, len(every), SENSIBLE_BAR),
        ("Names, wrong", f"{percent(wrong)} of {len(every)}", f"at most {100 * WRONG_BAR:g} %", wrong <= WRONG_BAR),
        none("Names, silent", total["silent"]),
    ]
    body = (
        "Each name is parsed as \"A table with a NAME\" and compared with `tests/words/vocabulary.tsv`. *Unmarked*: a "
        "plainer object of the kind that is not marked as a stand-in. *Silent*: a word of the name is neither used nor "
        "reported.\n\n"
        + table(["vocabulary", "names", *words.OUTCOMES], rows)
    )
    return Part("Names of five vocabularies", bars, body, failures)


def sentences(lab, maker, count) -> Part:
    every, ignored = words.entries("sentences"), words.ignorable()
    outcomes = words.parse(lab, [entry["text"] for entry in every])
    scenes = made(maker, every, outcomes, count)
    rows, failures = defaultdict(Counter), []
    for entry, outcome in zip(every, outcomes):
        silent = words.sentence_unaccounted(entry, outcome, ignored)
        parsed = words.sentence_complaints(entry, outcome)
        scene, tells = parsed, is_reported(outcome) or is_a_goal(entry, outcome)
        if found := scenes.get(entry["id"]):
            scene = found.complaints(partial(words.sentence_complaints, entry, outcome))
            tells = tells or found.tells()
        # Where no scene can be made, the answer decides.
        tried = found is not None or is_chosen(entry, every, count)
        quiet = bool(scene) and not tells
        for kind in (entry["kind"], "all"):
            rows[kind].update(
                texts=1, parsed=not parsed, scenes=tried, held=tried and not scene, quiet=quiet, silent=len(silent)
            )
        if parsed or scene or silent:
            reasons = [f"parse: {w}" for w in parsed[:FEW]] + [f"scene: {w}" for w in scene[:FEW] if w not in parsed]
            reasons += [f"no account of {', '.join(silent)}"] if silent else []
            failures.append((f"{entry['id']}, {entry['text']!r}", "; ".join(reasons)))
    total = rows["all"] = rows.pop("all")
    bars = [
        at_least("Sentences understood", total["parsed"], len(every), SENTENCES_BAR),
        at_least("Sentences that hold in the finished scene", total["held"], total["scenes"], SENTENCES_BAR),
        none("Sentences that do not hold and report nothing", total["quiet"]),
        none("Unaccounted words of sentences", total["silent"]),
    ]
    body = (
        f"{len(scenes)} of {len(every)} sentences of `tests/words/sentences.jsonl` become scenes; one that is refused "
        "holds if it has to be refused. A scene in quarantine does not hold.\n\n"
        + table(
            ["kind", "sentences", "understood", "tried as scenes", "hold", "fail and report nothing",
             "unaccounted words"],
            [[kind, *map(c.__getitem__, ("texts", "parsed", "scenes", "held", "quiet", "silent"))]
             for kind, c in rows.items()],
        )
    )
    return Part("Sentences", bars, body, failures)


def made(maker, every, outcomes, count, prefix="") -> dict:
    """Id to finished scene of the entries that are chosen and not refused."""
    wanted = [
        SceneText(f"{prefix}{entry['id']}", entry["text"], words.SEED, outcome)
        for entry, outcome in zip(every, outcomes)
        if is_chosen(entry, every, count) and "description" in outcome and not entry.get("refused")
    ]
    return {name.removeprefix(prefix): found for name, found in maker.make(wanted).items()}


def is_chosen(entry, every, count) -> bool:
    return any(chosen is entry for chosen in words.sample(every, count))


def is_reported(outcome) -> bool:
    """Whether the answer says of anything that it was not done."""
    return "error" in outcome or bool(outcome["description"].get("unrecognized"))


def is_a_goal(entry, outcome) -> bool:
    """Whether the answer names what is expected of the scene as the goal of an instruction instead."""
    goal = (outcome.get("description", {}).get("goal") or {}).get("predicates", [])
    stated = {predicate["predicate"] for predicate in goal}
    asked = [one["relation"] for one in entry.get("relations", ())]
    return any(stated & set([words] if isinstance(words, str) else words) for words in asked)


def tasks(lab, maker, count) -> Part:
    every, ignored = words.entries("tasks"), words.ignorable()
    outcomes = words.parse(lab, [entry["text"] for entry in every])
    scenes = made(maker, every, outcomes, count, "task_")
    rows, failures = defaultdict(Counter), []
    for entry, outcome in zip(every, outcomes):
        silent = words.sentence_unaccounted(entry, outcome, ignored)
        score = words.task_score(entry, outcome)
        scene, solved = score.scene, score.solved
        if found := scenes.get(entry["id"]):
            scene = found.complaints(lambda view, entry=entry, outcome=outcome: words.task_score(entry, outcome, view).scene)
            solved = is_solved(entry, outcome, found)
        for kind in (entry["kind"], "all"):
            rows[kind].update(texts=1, before=not solved, goal=not score.goal, scene=not scene, silent=len(silent))
        if solved or score.goal or scene or silent:
            reasons = ["solved or without a goal"] if solved else []
            reasons += score.goal[:FEW] + [f"scene: {w}" for w in scene[:FEW]]
            reasons += [f"no account of {', '.join(silent)}"] if silent else []
            failures.append((f"{entry['id']}, {entry['text']!r}", "; ".join(reasons)))
    total = rows["all"] = rows.pop("all")
    bars = [
        at_least("Tasks whose start does not satisfy the goal", total["before"], len(every), START_BAR),
        at_least("Tasks with the right goal", total["goal"], len(every), GOAL_BAR),
        none("Unaccounted words of tasks", total["silent"]),
    ]
    body = (
        f"{len(scenes)} of {len(every)} instructions of `tests/words/tasks.jsonl` become scenes; of the others the "
        "start is that of the description.\n\n"
        + table(
            ["kind", "tasks", "start before the goal", "goal right", "start as stated", "unaccounted words"],
            [[kind, *map(c.__getitem__, ("texts", "before", "goal", "scene", "silent"))] for kind, c in rows.items()],
        )
    )
    return Part("Task instructions", bars, body, failures)


def is_solved(entry, outcome, found) -> bool:
    """Whether the finished scene satisfies the goal; without a scene there is no start."""
    try:
        return found.view is None or words.task_score(entry, outcome, found.view).solved
    except Exception:  # `complaints` tells what cannot be measured
        return True


def generated_scenes(lab, maker, count) -> Part:
    every, ignored = generated(), words.ignorable()
    # The parser takes one seed for all texts; each of these has its own.
    with ThreadPoolExecutor(maker.jobs) as pool:
        outcomes = list(pool.map(lambda text: parsed_alone(lab, text), every))
    tried = min(len(every), count)
    wanted = {
        text.name: SceneText(text.name, text.text, text.seed, outcome)
        for text, outcome in zip(every[:tried], outcomes)
        if "description" in outcome
    }
    scenes = maker.make(list(wanted.values()))
    objects = {text.name: text.objects for text in every}
    slow = slow_scenes(maker, wanted, scenes, objects)
    failures, total = [], Counter()
    for number, (text, outcome) in enumerate(zip(every, outcomes)):
        wrong = words.sentence_complaints(text.expectation, outcome)
        silent = words.sentence_unaccounted(text.expectation, outcome, ignored)
        reasons = [f"parse: {w}" for w in wrong[:FEW]] + ([f"no account of {', '.join(silent)}"] if silent else [])
        total.update(parsed=not wrong, silent=len(silent))
        if found := scenes.get(text.name):
            scene = found.complaints(partial(words.sentence_complaints, text.expectation, outcome))
            total.update(certified=found.certified, held=not scene)
            reasons += [f"scene: {w}" for w in scene[:FEW] if w not in wrong]
        elif number < tried and not reasons:
            reasons = ["no scene"]
        if reasons:
            failures.append((f"{text.name} (seed {text.seed}), {text.text!r}", "; ".join(reasons)))
    bars = [
        at_least("Generated sentences, certified at the first attempt", total["certified"], tried, FIRST_BAR),
        none("Generated scenes over three times the median time", len(slow)),
    ]
    rows = [
        [number, len(runs), f"{statistics.median(runs):.1f}", f"{max(runs):.1f}"]
        for number, runs in sorted(times(scenes, objects).items())
    ]
    body = (
        f"{total['parsed']} of {len(every)} sentences of `python/tabletopgen_checks/language/generated_sentences.py` are understood; "
        f"{total['silent']} words have no account. {total['held']} of {tried} scenes hold what their sentence asks "
        "for. Times are processor time of scenes with one thread.\n\n"
        + table(["objects", "scenes", "median CPU s", "slowest CPU s"], rows)
    )
    return Part("Generated sentences", bars, body, failures + slow)


def parsed_alone(lab, text) -> dict:
    """A text that the parser breaks off at is one that fails."""
    try:
        return words.parse(lab, [text.text], text.seed)[0]
    except Problem as problem:
        return {"error": {"code": "no_answer", "message": str(problem), "terms": []}}


def times(scenes, objects) -> dict:
    """Number of objects to the processor time of the scenes with so many, seconds."""
    seconds = defaultdict(list)
    for name, found in scenes.items():
        if found.cpu_s is not None:
            seconds[objects[name]].append(found.cpu_s)
    return seconds


def slow_scenes(maker, wanted, scenes, objects) -> list:
    """(name, words) of those over the limit, also when made once more alone: other work on the machine slows a scene
    through caches, and nothing makes it faster than it is."""
    medians = {number: statistics.median(runs) for number, runs in times(scenes, objects).items()}
    slow = []
    for name, found in sorted(scenes.items()):
        limit = SLOW * medians.get(objects[name], 0.0)
        if found.cpu_s is not None and found.cpu_s > limit:
            print(f"{name} took {found.cpu_s:.1f} CPU s, once more ...", flush=True)
            found = maker.again(wanted[name])
            if found.cpu_s > limit:
                median = medians[objects[name]]
                slow.append((name, f"{found.cpu_s:.1f} CPU s, the median of {objects[name]} objects is {median:.1f}"))
    return slow


if __name__ == "__main__":
    run(main)
