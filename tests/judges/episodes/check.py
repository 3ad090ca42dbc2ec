"""Independent programs judge the synthetic episodes in every format.

    cargo run -p tabletopgen-episodes --example synthetic -- FOLDER
    check.py FOLDER [JUDGE...]

Prints one line of JSON for each judge; exit code 1 where one has a complaint or does not run.
`tabletopgen_checks.data.episodes` makes the environment and the folder. The judge `v21_lerobot` needs LeRobot 0.3.3,
which cannot be installed beside the other; it runs only where it is named.
"""

import importlib
import json
import os
import sys
import tempfile
import traceback
from pathlib import Path

JUDGES = ("v30", "v21", "hdf5", "plain")


def main(folder: Path, judges: list) -> int:
    failed = False
    for name in judges or JUDGES:
        try:
            facts, complaints = importlib.import_module(f"judge_{name}").judge(folder)
        except Exception as error:  # A judge that does not get through is a complaint.
            traceback.print_exc()
            facts, complaints = {}, [f"{type(error).__name__}: {error}"]
        failed |= bool(complaints)
        print(json.dumps({"judge": name, **facts, "complaints": complaints}), flush=True)
    return int(failed)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as cache:
        # Nothing is fetched, and nothing outlives the run.
        os.environ.update(HF_HUB_OFFLINE="1", HF_HOME=cache, HF_DATASETS_CACHE=cache, HF_LEROBOT_HOME=cache)
        sys.exit(main(Path(sys.argv[1]).resolve(), sys.argv[2:]))
