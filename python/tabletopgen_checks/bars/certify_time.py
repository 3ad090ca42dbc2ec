"""Twenty-five objects: how long it takes from meshes to a certified scene at rest.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.certify_time [--target-dir target] [--runs 5]

`decompose` and `rotate` run side by side, so each scene is made twice on one data directory: the second time settings
of `decompose` and `resolve` differ in their last digits, so that what comes before and `rotate` are found, and each of
the three stages is computed and has the processors alone.
"""

import statistics
import tempfile
from pathlib import Path

from tabletopgen_checks.bars.page import arguments, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.scene.generation import generate

DEPENDS_ON = (
    "config/default.toml", "crates/data/export", "crates/base/geometry", "crates/base/mesh_io", "crates/method/physics",
    "crates/method/render", "src/pipeline/certify", "src/pipeline/certify.rs", "src/pipeline/decompose.rs",
    "src/pipeline/resolve", "src/pipeline/resolve.rs",
)
BAR_SECONDS = 3.0
STAGES = ("decompose", "resolve", "certify")
OBJECTS = 25
SEED = 25
# Hollow, thin-walled, with handles, stacked and contained: nothing here is a plain block.
TEXT = (
    "A large dining table with four plates, a bowl with two apples in it, two bowls, three mugs, two teacups, a teapot, a pitcher, "
    "a basket, three forks, two spoons, a saucepan, a salt shaker and a pepper mill"
)
NO_WAITING = {"TABLETOPGEN__STORE__FSYNC": "false"}
# Too little to change an answer: the hulls come out the same, and then only its own setting has `resolve` computed.
COMPUTED_ANEW = {
    "TABLETOPGEN__DECOMPOSE__EXCESS_SPACING_M": "0.0040000001",
    "TABLETOPGEN__RESOLVE__OUTLINE_MARGIN_M": "0.0020000001",
}


def main() -> bool:
    given = arguments(__doc__, runs=5)
    # Nothing is removed before the end: ext4 is slow in creating files where many were deleted a moment ago.
    with tempfile.TemporaryDirectory(dir=given.work) as work:
        runs = [one_run(given.binary, Path(work) / str(k)) for k in range(given.runs)]
    sums = sorted(sum(times.values()) / 1000 for times in runs)
    median = statistics.median(sums)
    rows = []
    for name in STAGES:
        wall = [times[name] for times in runs]
        rows.append([name, f"{statistics.median(wall):.0f}", f"{min(wall)} to {max(wall)}"])
    body = (
        f"`decompose`, `resolve` (which settles) and `certify` together: median {median:.2f} s over {len(runs)} runs (fastest "
        f"{sums[0]:.2f} s, slowest {sums[-1]:.2f} s) with two threads; the bar is {BAR_SECONDS:.0f} s on two cores.\n\n"
        f"Sentence ({OBJECTS} objects, seed {SEED}): {TEXT}\n\n"
        "Each stage has the processors alone: the scene is made twice, and the second time all stages before these are found.\n\n"
        + table(["stage", "wall ms, median", "wall ms, range"], rows)
    )
    write("certify_time", "Time from meshes to a certified scene", body, DEPENDS_ON)
    return median <= BAR_SECONDS


def one_run(binary: Path, work: Path) -> dict[str, int]:
    """Milliseconds each of the stages took."""
    data = work / "data"
    generate(binary, work / "first", TEXT, SEED, threads=2, environment=NO_WAITING, data=data)
    made = generate(binary, work / "second", TEXT, SEED, threads=2, environment=NO_WAITING | COMPUTED_ANEW, data=data)
    if made.printed["summary"]["objects"] != OBJECTS or made.printed["verdict"] != "pass":
        raise Problem(f"{made.printed['summary']['objects']} objects and {made.printed['verdict']} instead of {OBJECTS} and pass")
    stages = {stage["stage"]: stage for stage in made.printed["stages"]}
    if stages["rotate"]["found"] != OBJECTS or any(stages[name]["found"] for name in STAGES):
        raise Problem("the second time rotate was not found, or a stage that is timed was")
    times = {name: stages[name]["wall_ms"] for name in STAGES}
    print(", ".join(f"{name} {ms} ms" for name, ms in times.items()), flush=True)
    return times


if __name__ == "__main__":
    run(main)
