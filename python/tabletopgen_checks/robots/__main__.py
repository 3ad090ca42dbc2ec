"""Independent programs judge the robots of config/robots/: Pinocchio, MuJoCo, PyBullet and usd-core.

    PYTHONPATH=python python3 -m tabletopgen_checks.robots [--target-dir target]

Writes each robot and variant below TARGET/robots with the example `write_robot`, makes the environment
TARGET/robot-judges from tests/judges/robots/requirements.txt, and runs tests/judges/robots/judge.py. The published
model of the Panda that its kinematics are compared with is fetched from PyPI with the other packages.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import JUDGES, ROOT
from tabletopgen_checks.virtual_environment import environment_of

ROBOTS = (("panda", None), ("piper", None), ("piper", "old_zero"))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target-dir", type=Path, default=ROOT / "target")
    target = parser.parse_args().target_dir.resolve()
    environment = environment_of(target, "robot-judges", JUDGES / "robots" / "requirements.txt")
    folders = [write(target, name, variant) for name, variant in ROBOTS]
    command = [environment / "bin/python", JUDGES / "robots" / "judge.py", *folders]
    return subprocess.run([str(part) for part in command]).returncode


def write(target: Path, name: str, variant) -> Path:
    folder = target / "robots" / "_".join(filter(None, (name, variant)))
    cargo = [os.environ.get("CARGO", "cargo"), "run", "--quiet", "--locked", "--package", "tabletopgen-robot"]
    cargo += ["--target-dir", str(target), "--example", "write_robot", "--", name, str(folder)]
    if subprocess.run(cargo + ([variant] if variant else []), cwd=ROOT).returncode != 0:
        raise Problem(f"the example write_robot did not write {name}; see above")
    return folder


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Problem as problem:
        sys.exit(str(problem))
