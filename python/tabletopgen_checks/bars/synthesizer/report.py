"""The page of the comparison, and what it asks of tabletopgen."""

import statistics

from tabletopgen_checks.bars.page import percent, table, write
from tabletopgen_checks.bars.synthesizer import DEPENDS_ON
from tabletopgen_checks.bars.synthesizer.runs import EDIT, GENERATE, OBJECTS, PINS, STABLE, UPRIGHT, WAYS

EXPLANATION = """\
One seed after the other: `tabletopgen generate` makes ten objects and their table from a text (three texts in turn); then
both programs place these objects on this table, in turn, each on one thread.

| program | *place* is | *process* is |
| --- | --- | --- |
| {UPRIGHT} | inside the process, without imports and reading: support surface, then `place_objects` with turns about the vertical | start of Python, imports, reading of the hulls, *place* |
| {STABLE} | the same, with the package's stable poses and their computation | the same |
| {EDIT} | the whole process of `edit --dry-run` with ten operations `move ... on table`: start, check of the bundle, reading of visual meshes and hulls, search for a free place per object, rest under gravity | the whole process of `edit`: the same, then certificate, previews, five formats, read back and packed |
| {GENERATE} | not apart from making the objects | the whole process: text to certified bundle |

scene-synthesizer gets the collision hulls, one mesh per object, its defaults, and a solid of the table's outline as support;
it starts from an empty table. Its default leaves 2 mm below every object. It neither simulates nor measures nor exports here.
`edit` starts from the layout of `generate` and moves every object, so that nine others are in the way of each.

*Colliding pairs* are those of visual meshes, table included, that are deeper than min(1 mm, a quarter of the wall), by
Manifold, Embree and FCL. *Contact* is the deepest that MuJoCo finds between hulls before its first step. *At rest* are
objects that MuJoCo moves by less than 3 cm and turns by less than 30 degrees in 5 s, over objects asked for; *moved* is that
distance. The MuJoCo model is made by `tests/judges/layouts.py` from hulls, masses, inertias and friction of the bundle, the
same for both programs, with MuJoCo's default contacts.
"""


def write_page(runs: list) -> bool:
    bars = bars_of(runs)
    rows = [[what, value, bar, "holds" if holds else "DOES NOT HOLD"] for what, value, bar, holds in bars]
    columns = ["", "place, CPU s", "range", "process, CPU s", "range", "placed", "colliding pairs", "contact mm", "at rest",
               "moved mm, median", "largest"]
    explanation = EXPLANATION.format(UPRIGHT=UPRIGHT, STABLE=STABLE, EDIT=EDIT, GENERATE=GENERATE)
    layouts = len({run.seed for run in runs})
    body = (
        f"{layouts} layouts of {OBJECTS} objects by each program; times are medians. {', '.join(PINS[:3])}.\n\n"
        + table(columns, [row(way, of(runs, way)) for way in WAYS])
        + "\n\n" + table(["tabletopgen", "found", "bar", ""], rows) + "\n\n## What is compared\n\n" + explanation
    )
    write("synthesizer", "Side by side with scene-synthesizer", body, DEPENDS_ON)
    return all(holds for *_, holds in bars)


def of(runs: list, way: str) -> list:
    return [run for run in runs if run.way == way]


def row(way: str, runs: list) -> list:
    moved = [distance for run in runs for distance in run.findings["moved_mm"].values()]
    depth_mm = max(run.findings["hull_depth_mm"] for run in runs)
    return [
        way,
        *seconds([run.place_s for run in runs]),
        *seconds([run.process_s for run in runs]),
        f"{placed(runs)} of {OBJECTS * len(runs)}",
        colliding(runs),
        f"{depth_mm:.2f}",
        percent(at_rest(runs)),
        f"{statistics.median(moved):.2f}" if moved else "-",
        f"{max(moved):.2f}" if moved else "-",
    ]


def seconds(values: list) -> tuple:
    """Median and range."""
    if None in values:
        return "-", "-"
    return f"{statistics.median(values):.2f}", f"{min(values):.2f} to {max(values):.2f}"


def placed(runs: list) -> int:
    return sum(len(run.poses) for run in runs)


def colliding(runs: list) -> int:
    return sum(len(run.findings["colliding"]) for run in runs)


def at_rest(runs: list) -> float:
    """Of the objects that were asked for: what was not placed does not rest."""
    return sum(len(run.findings["at_rest"]) for run in runs) / (OBJECTS * len(runs))


def bars_of(runs: list) -> list:
    """(what, found, bar, whether it holds) of our program."""
    bars = []
    peer = max(at_rest(of(runs, way)) for way in (UPRIGHT, STABLE))
    for way in (EDIT, GENERATE):
        ours = of(runs, way)
        asked, found, rest = OBJECTS * len(ours), placed(ours), at_rest(ours)
        bars += [
            (f"{way}: objects placed", str(found), str(asked), found == asked),
            (f"{way}: colliding pairs", str(colliding(ours)), "0", colliding(ours) == 0),
            (f"{way}: at rest", percent(rest), f"{percent(peer)}, as scene-synthesizer", rest >= peer),
        ]
    return bars
