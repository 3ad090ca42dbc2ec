"""Edits: two hundred on forty scenes do what they state, and nothing else; what is refused is impossible.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.editing [--target-dir target] [--scenes 40] [--edits 200] \\
        [--seed 34]
        [--only edits,cost,synthesizer] [--rounds 5] [--layouts 20]

Half of the scenes are of texts, half of synthetic images. `tabletopgen_checks.edits.comparison` judges the written
bundles from their poses and hulls, by code that shares nothing with the program; MuJoCo simulates every result for five
seconds; refusals are checked by a search for free space (`tabletopgen_checks.edits.room`). The part `synthesizer` has a
page and a bar of its own (`python/tabletopgen_checks/bars/synthesizer`).
"""

import json
import shutil
import statistics
import zipfile
from collections import Counter, defaultdict
from pathlib import Path

from tabletopgen_checks.bars.page import arguments, percent, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.bars.synthesizer.report import write_page
from tabletopgen_checks.bars.synthesizer.runs import LAYOUTS, placements
from tabletopgen_checks.edits.cases import cases
from tabletopgen_checks.edits.operations import PLANS
from tabletopgen_checks.edits.parents import TEXTS, image_parents, text_parents
from tabletopgen_checks.edits.refused import REFUSED as REFUSALS
from tabletopgen_checks.edits.runs import NO_ROOM, OUTCOMES, REFUSED, RIGHT, WRONG, called, edit, judged
from tabletopgen_checks.edits.simulation import simulate
from tabletopgen_checks.judges.judging import finish_setup, start_setup
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import lab_beside

DEPENDS_ON = (
    "crates/base/catalog", "crates/method/editing", "crates/base/geometry", "crates/method/physics",
    "python/tabletopgen_checks/edits", "src/pipeline/edit", "src/pipeline/edit.rs",
)
SCENES, EDITS, SEED, ROUNDS = 40, 200, 34, 5
PARTS = ("edits", "cost", "synthesizer")
COST_BAR = 0.25
# Who refuses everything does nothing wrong.
DONE_BAR = 0.5
# An operation is asked for this often where the number of edits allows for it.
PLANNED = 10
# Fifteen objects.
LARGE_SCENE = (
    "An office desk with a laptop, a mouse to the right of the laptop, a desk lamp, two mugs, three books, a notebook, "
    "a stapler, a pen holder, a potted plant, a water bottle, a calculator and a tissue box"
)
LARGE_OBJECTS, LARGE_SEED = 15, 15
SINGLE_EDITS = {
    "add": {"op": "add", "object": "an apple"},
    "replace": {"op": "replace", "target": "stapler_1", "object": "a candle"},
    "move": {"op": "move", "target": "mug_1", "where": {"relation": "at_front"}},
    "recolor": {"op": "recolor", "target": "mug_2", "color": "red"},
}
# MuJoCo simulates so many bundles in one call.
SIMULATED_AT_ONCE = 10


def main() -> bool:
    given = arguments(
        __doc__, scenes=SCENES, edits=EDITS, seed=SEED, only=",".join(PARTS), rounds=ROUNDS,
        layouts=LAYOUTS,
    )
    unknown = set(given.only.split(",")) - set(PARTS)
    if unknown:
        raise Problem(f"--only names {', '.join(PARTS)}, not {', '.join(sorted(unknown))}")
    pages, bars, holds_beside = [], [], True
    if "edits" in given.only:
        environment = given.target_dir / "judges"
        finish_setup(start_setup(environment))
        parents = scenes(given)
        asked = cases(parents, given.edits, given.seed)
        found = measured(given.binary, environment, parents, asked, given.work / "editing")
        pages.append(edits_page(found, parents))
        bars += edit_bars(found, given.edits)
    if "cost" in given.only:
        costs = measured_costs(given.binary, given.work / "editing", given.rounds)
        pages.append(costs_page(costs))
        bars.append(cost_bar(costs))
    if "synthesizer" in given.only:
        runs = placements(given.binary, given.target_dir, given.work / "synthesizer", given.layouts)
        holds_beside = write_page(runs)
    if pages:
        rows = [[what, value, bar, "holds" if holds else "DOES NOT HOLD"] for what, value, bar, holds in bars]
        write("editing", "Edits", "\n\n".join([table(["", "found", "bar", ""], rows), *pages]), DEPENDS_ON)
    return holds_beside and all(holds for *_, holds in bars)


def scenes(given) -> list:
    """Half of texts, half of images, in turn."""
    lab, folder = lab_beside(given.binary), given.work / "editing"
    texts = text_parents(lab, given.binary, folder, min(len(TEXTS), (given.scenes + 1) // 2))
    images = image_parents(lab, given.binary, folder, given.scenes - len(texts))
    mixed = [parent for pair in zip(texts, images) for parent in pair]
    return mixed + texts[len(images) :] + images[len(texts) :]


def measured(binary, environment, parents, asked, folder) -> list:
    """Every case with its outcome; those that moved in the simulation are wrong, too."""
    by_name = {parent.name: parent for parent in parents}
    found, waiting = [], []
    for number, case in enumerate(asked):
        one = judged(binary, by_name[case.parent], case, folder / "edits")
        shown = f"{case.name} {case.kind()} of {case.parent}: {one.outcome}"
        shown += f": {'; '.join(one.words)[:300]}" if one.outcome in (WRONG, NO_ROOM) else ""
        print(f"[{number + 1}/{len(asked)}] {shown}", flush=True)
        found.append(one)
        waiting += [one] if one.bundle else []
        if len(waiting) >= SIMULATED_AT_ONCE:
            simulate(environment, waiting)
            waiting = []
    simulate(environment, waiting)
    return found


def edit_bars(found, edits) -> list:
    wrong = sum(one.outcome == WRONG for one in found)
    done = sum(one.outcome == RIGHT for one in found)
    planned = Counter(operation.name for one in found if not one.case.refused for operation in one.case.operations)
    rarest = min(planned[name] for name in PLANS)
    possible = sum(not one.case.refused for one in found)
    bars = [
        (f"Wrong edits of {len(found)}", str(wrong), "0", wrong == 0),
        (f"Done of {possible} that seem possible", str(done), percent(DONE_BAR, 0), done >= DONE_BAR * possible),
    ]
    if edits >= EDITS:
        bars.append(("Uses of the rarest operation", str(rarest), str(PLANNED), rarest >= PLANNED))
    return bars


def edits_page(found, parents) -> str:
    rows, kinds = defaultdict(Counter), [*PLANS, "chain"]
    for one in found:
        kind = f"must be refused: {one.case.refused}" if one.case.refused else one.case.kind()
        rows[kind][one.outcome] += 1
        rows["all"][one.outcome] += 1
    order = [kind for kind in kinds + [f"must be refused: {name}" for name in REFUSALS] + ["all"] if kind in rows]
    columns = ["operation", "edits", *OUTCOMES]
    lines = [[kind, sum(rows[kind].values()), *(rows[kind][outcome] for outcome in OUTCOMES)] for kind in order]
    chained = Counter(op.name for one in found if one.case.kind() == "chain" for op in one.case.operations)
    inside = ", ".join(f"{name} {chained[name]}" for name in PLANS if chained[name])
    images = sum(parent.is_image for parent in parents)
    page = (
        f"## Generated edits\n\n{len(found)} edits of {len(parents)} scenes, {images} of them from synthetic images. "
        f"*{REFUSED}*: the generator knows that it is impossible. *{NO_ROOM}*: the search of every centimeter and "
        "sixteen yaws finds no place with 1 cm around it; it takes hulls for prisms, so that a place it finds is free. "
        f"Operations inside chains: {inside or 'none'}.\n\n{table(columns, lines)}"
    )
    titles = {WRONG: "Wrong edits", NO_ROOM: "Refused, and no room is found", REFUSED: "Reasons of refusals"}
    for outcome, title in titles.items():
        matching = [one for one in found if one.outcome == outcome]
        if matching:
            page += f"\n\n### {title}\n\n" + "\n".join(line(one) for one in matching)
    return page


def line(one) -> str:
    what = "; ".join(one.words).replace("\n", " ")
    operations = ", ".join(str(wire).replace("'", '"') for wire in one.case.wire())
    kept = f" (bundle kept: {one.bundle.name})" if one.bundle and one.outcome == WRONG else ""
    return f"- {one.case.name}, {one.case.parent}, seed {one.case.seed}, `{operations}`: {what}{kept}"


def measured_costs(binary, folder, rounds) -> dict:
    """CPU seconds of the full run and of single edits, in alternating rounds."""
    costs, bundle = defaultdict(list), folder / "large"
    for number in range(rounds):
        shutil.rmtree(bundle, ignore_errors=True)
        asked = ["--text", LARGE_SCENE, "--seed", str(LARGE_SEED), "--out", str(bundle), "--json"]
        costs["full run"].append(cpu_s(called([str(binary), "generate", *asked])))
        archive = packed(bundle)
        for name, wire in SINGLE_EDITS.items():
            costs[name].append(cpu_s(edit(binary, archive, [wire], LARGE_SEED, folder / f"large_{name}")))
        shown = ", ".join(f"{name} {values[-1]:.2f} s" for name, values in costs.items())
        print(f"round {number + 1} of {rounds}: {shown}", flush=True)
    return costs


def packed(bundle) -> Path:
    """The archive of a bundle, which is what a server edits."""
    folder = f"scene-{json.loads((bundle / 'scene.json').read_text(encoding='utf-8'))['id']}"
    path = bundle.with_suffix(".zip")
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(file for file in bundle.rglob("*") if file.is_file()):
            packing = zipfile.ZIP_STORED if file.suffix == ".png" else zipfile.ZIP_DEFLATED
            archive.write(file, f"{folder}/{file.relative_to(bundle)}", packing)
    return path


def cpu_s(done) -> float:
    if done.exit_code != 0:
        reason = done.message() or done.errors
        raise Problem(f"`{' '.join(done.command)}` ended with {done.exit_code}: {reason}")
    return done.cpu_s


def ratio(costs, name) -> float:
    return statistics.median(costs[name]) / statistics.median(costs["full run"])


def cost_bar(costs) -> tuple:
    worst = max(SINGLE_EDITS, key=lambda name: ratio(costs, name))
    share = ratio(costs, worst)
    words = f"CPU time of an edit of {LARGE_OBJECTS} objects over that of the full run ({worst})"
    return words, percent(share), f"under {percent(COST_BAR, 0)}", share < COST_BAR


def costs_page(costs) -> str:
    rows = [
        [name, f"{statistics.median(runs):.2f}", f"{min(runs):.2f} to {max(runs):.2f}", percent(ratio(costs, name))]
        for name, runs in costs.items()
    ]
    return (
        f"## Cost of one edit\n\nUser and system time of the process, {len(costs['full run'])} alternating rounds: a "
        f"scene of {LARGE_OBJECTS} objects is made, then its archive is edited.\n\n"
        + table(["", "median CPU s", "range", "of the full run"], rows)
    )


if __name__ == "__main__":
    run(main)
