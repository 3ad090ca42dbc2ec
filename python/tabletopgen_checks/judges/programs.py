"""Makes an environment of its own for each program of the README's examples that cannot share the judges'.

    PYTHONPATH=python python3 -m tabletopgen_checks.judges.programs [--target-dir target] [NAME...]

Each wants versions of its own: tests/judges/programs/NAME.txt names its packages of PyPI, NAME.npm its package of npm.
All together take 12 gigabytes, most of it PyTorch for Genesis; `make test` does with MuJoCo 3.3.0 alone. Does nothing
for a program whose environment is there.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

from tabletopgen_checks.judges.judging import finish_setup, start_setup
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import JUDGES
from tabletopgen_checks.virtual_environment import environment_of, pins_in

REQUIREMENTS = JUDGES / "programs"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target-dir", type=Path, default=JUDGES.parent.parent / "target")
    parser.add_argument("names", nargs="*", metavar="NAME", default=known())
    given = parser.parse_args()
    judges = given.target_dir.resolve() / "judges"
    finish_setup(start_setup(judges))
    for name in given.names:
        make(judges, name)
    return 0


def known() -> list:
    return sorted(path.stem for path in REQUIREMENTS.iterdir())


def make(judges: Path, name: str) -> Path:
    """The environment of a program, in the judges' folder of the target directory."""
    pip, npm = (REQUIREMENTS / f"{name}.{kind}" for kind in ("txt", "npm"))
    if pip.is_file():
        return environment_of(judges / "programs", name, pip)
    if npm.is_file():
        return packages_of_npm(judges, name, pins_in(npm))
    raise Problem(f"no program is called {name!r}; there are {', '.join(known())}")


def packages_of_npm(judges: Path, name: str, pins: list) -> Path:
    """By the npm that came with the judges."""
    folder = judges / "programs" / name
    stamp = folder / "pins"
    if stamp.is_file() and stamp.read_text(encoding="utf-8") == "\n".join(pins):
        return folder
    folder.mkdir(parents=True, exist_ok=True)
    path = f"{judges / 'bin'}{os.pathsep}{os.environ.get('PATH', '')}"
    npm = [judges / "bin/npm", "install", "--silent", "--no-audit", "--no-fund", "--no-save", "--prefix", folder, *pins]
    run = subprocess.run([str(part) for part in npm], env=dict(os.environ, PATH=path))
    if run.returncode != 0:
        raise Problem(f"npm could not deliver {', '.join(pins)}; see above")
    stamp.write_text("\n".join(pins), encoding="utf-8")
    return folder


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Problem as problem:
        sys.exit(str(problem))
