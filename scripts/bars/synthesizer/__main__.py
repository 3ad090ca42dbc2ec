"""Ten objects on a table, placed by tabletopgen and by NVIDIA's scene-synthesizer; the same code judges both.

    PYTHONPATH=scripts python3 -m bars.synthesizer [--target-dir target] [--layouts 20]

The page is docs/results/synthesizer.md. `make bars BARS=editing` measures this, too. No layout begins after seven minutes.
"""

from bars.page import arguments
from bars.run import run
from bars.synthesizer.report import write_page
from bars.synthesizer.runs import LAYOUTS, placements


def main() -> bool:
    given = arguments(__doc__.splitlines()[0], layouts=LAYOUTS)
    return write_page(placements(given.binary, given.target_dir, given.work / "synthesizer", given.layouts))


if __name__ == "__main__":
    run(main)
