"""Lints of every Python file of the repository.

    PYTHONPATH=python python3 -m tabletopgen_checks.lint [--target-dir target]

python/pyproject.toml has the rules and the version of ruff, which is installed below TARGET/lint.
"""

import argparse
import subprocess
import sys
import tomllib
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import PYTHON, ROOT
from tabletopgen_checks.virtual_environment import environment_of

FOLDERS = ("python", "benches", "docker", "tests", "training")


def check(target: Path) -> str:
    """A line about the findings, of which there are none; else a problem, after they were printed."""
    project = tomllib.loads((PYTHON / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    environment = environment_of(target, "lint", project["optional-dependencies"]["lint"])
    # The paths of the rules are relative to the folder that ruff runs in.
    command = [environment / "bin/ruff", "check", "--cache-dir", environment / "cache", "--config", "pyproject.toml"]
    command += [ROOT / folder for folder in FOLDERS]
    if subprocess.run([str(part) for part in command], cwd=PYTHON).returncode != 0:
        raise Problem("ruff has findings in Python files; see above, and add `--fix` to its command for some of them")
    return "clean"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--target-dir", type=Path, default=ROOT / "target")
    print(check(parser.parse_args().target_dir.resolve()))
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Problem as problem:
        sys.exit(str(problem))
