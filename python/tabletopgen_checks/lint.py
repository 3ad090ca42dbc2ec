"""Lints of every Python file of the repository, and types of this package.

    PYTHONPATH=python python3 -m tabletopgen_checks.lint [--target-dir target]

python/pyproject.toml has the rules and versions of ruff and pyright, which are installed below TARGET/lint.
"""

import argparse
import os
import subprocess
import sys
import tomllib
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import PYTHON, ROOT
from tabletopgen_checks.virtual_environment import environment_of

FOLDERS = ("python", "benches", "clients", "docker", "tests", "training")


def check(target: Path) -> str:
    """A line about the findings, of which there are none; else a problem, after they were printed."""
    project = tomllib.loads((PYTHON / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    environment = environment_of(target, "lint", project["optional-dependencies"]["lint"])
    folders = [ROOT / folder for folder in FOLDERS]
    ruff = ["ruff", "check", "--cache-dir", environment / "cache", "--config", "pyproject.toml", *folders]
    # Without the variable pyright asks on the network whether there is a later version.
    variables = os.environ | {"PYRIGHT_PYTHON_IGNORE_WARNINGS": "1"}
    for program, *arguments in (ruff, ["pyright", "--project", "pyproject.toml"]):
        command = [str(part) for part in (environment / "bin" / program, *arguments)]
        # Paths in pyproject.toml are relative to the folder that the programs run in.
        if subprocess.run(command, cwd=PYTHON, env=variables).returncode != 0:
            raise Problem(f"{program} has findings in Python files; see above")
    return "clean"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target-dir", type=Path, default=ROOT / "target")
    print(check(parser.parse_args().target_dir.resolve()))
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Problem as problem:
        sys.exit(str(problem))
