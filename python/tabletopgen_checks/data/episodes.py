"""Independent programs judge synthetic episodes in every format: LeRobot, h5py, PyAV and pyarrow.

    PYTHONPATH=python python3 -m tabletopgen_checks.data.episodes [--target-dir target]

Writes TARGET/episodes with the example `synthetic`, makes the environment TARGET/episode-judges from
tests/judges/episodes/requirements.txt, and runs tests/judges/episodes/check.py. The environment has PyTorch and takes
about 8 GB.
"""

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import JUDGES, ROOT
from tabletopgen_checks.virtual_environment import environment_of


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target-dir", type=Path, default=ROOT / "target")
    target = parser.parse_args().target_dir.resolve()
    environment = environment_of(target, "episode-judges", JUDGES / "episodes" / "requirements.txt")
    folder = write(target)
    command = [environment / "bin/python", JUDGES / "episodes" / "check.py", folder]
    return subprocess.run([str(part) for part in command]).returncode


def write(target: Path) -> Path:
    folder = target / "episodes"
    shutil.rmtree(folder, ignore_errors=True)
    cargo = [os.environ.get("CARGO", "cargo"), "run", "--quiet", "--locked", "--package", "tabletopgen-episodes"]
    cargo += ["--target-dir", str(target), "--example", "synthetic", "--", str(folder)]
    if subprocess.run(cargo, cwd=ROOT).returncode != 0:
        raise Problem("the example synthetic did not write episodes; see above")
    return folder


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Problem as problem:
        sys.exit(str(problem))
