"""Twelve objects: how long `generate` takes from an empty data directory, and where the time goes.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.generate_time [--target-dir target] [--runs 9]
"""

import statistics

from tabletopgen_checks.bars.page import SCENES_OF_TEXTS, arguments, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.language.sentences import sentences
from tabletopgen_checks.scene.generation import generate

DEPENDS_ON = (*SCENES_OF_TEXTS, "crates/base/mesh_io")
BAR_SECONDS = 5.0
SENTENCE = "kitchen_prep"


def main() -> bool:
    given = arguments(__doc__, runs=9)
    sentence = next(s for s in sentences() if s.name == SENTENCE)
    runs = []
    for k in range(given.runs):
        # A folder each: replacing files costs a file system more than making them.
        folder = given.work / f"generate_time_{k + 1}"
        made = generate(given.binary, folder, sentence.text, sentence.seed)
        print(f"run {k + 1}: {made.seconds:.2f} s", flush=True)
        runs.append(made)
    seconds = sorted(made.seconds for made in runs)
    median = statistics.median(seconds)
    rows = []
    for k, stage in enumerate(runs[0].printed["stages"]):
        wall, work = ([made.printed["stages"][k][what] for made in runs] for what in ("wall_ms", "work_ms"))
        rows.append([
            stage["stage"],
            stage["instances"] or "the scene",
            f"{statistics.median(wall):.0f}",
            f"{min(wall)} to {max(wall)}",
            f"{statistics.median(work):.0f}",
        ])
    body = (
        f"Median {median:.2f} s over {len(runs)} runs (fastest {seconds[0]:.2f} s, slowest {seconds[-1]:.2f} s), whole "
        f"process, from an empty data directory; the bar is {BAR_SECONDS:.0f} s on two cores.\n\n"
        f"Sentence ({sentence.objects} objects, seed {sentence.seed}): {sentence.text}\n\n"
        "*Wall* is from a stage's first event to its last; *work* is summed over its instances, which run side by "
        "side.\n\n"
        + table(["stage", "works on", "wall ms, median", "wall ms, range", "work ms, median"], rows)
    )
    write("generate_time", "Time of one scene", body, DEPENDS_ON)
    return median <= BAR_SECONDS


if __name__ == "__main__":
    run(main)
