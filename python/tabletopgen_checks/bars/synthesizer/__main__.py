"""Ten objects on a table, placed by tabletopgen and by NVIDIA's scene-synthesizer; the same code judges both.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.synthesizer [--target-dir target] [--layouts 20]

The page is docs/results/synthesizer.md. `make bars BARS=editing` measures this, too. No layout begins after seven
minutes.
"""

from tabletopgen_checks.bars.page import arguments
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.bars.synthesizer.report import write_page
from tabletopgen_checks.bars.synthesizer.runs import LAYOUTS, placements


def main() -> bool:
    given = arguments(__doc__, layouts=LAYOUTS)
    return write_page(placements(given.binary, given.target_dir, given.work / "synthesizer", given.layouts))


if __name__ == "__main__":
    run(main)
