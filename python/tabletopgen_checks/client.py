"""The Python package in clients/python: its types and tests, what is generated in it, and its wheel.

    PYTHONPATH=python python3 -m tabletopgen_checks.client check|generate|wheel [--target-dir target]
        [--program target/release/tabletopgen] [--sentences 1000]

`check` wants a program that was built; `generate` is for after openapi.yaml or `_async` changed. `wheel` packs the
program with the package into TARGET/wheel. The environment is `client` of the target directory.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import ROOT
from tabletopgen_checks.virtual_environment import environment_of, pins_in

CLIENT = ROOT / "clients" / "python"


def check(target: Path, program: Path, sentences: int = 30) -> str:
    """Types by mypy and pyright, and the tests against the program, with the share of the package that they run."""
    python = environment_of(target, "client", CLIENT / "requirements.txt") / "bin/python"
    # Without the variable pyright asks on the network whether there is a later version.
    variables = os.environ | {"PYRIGHT_PYTHON_IGNORE_WARNINGS": "1", "TABLETOPGEN_PROGRAM": str(program.resolve())}
    run([python.with_name("mypy"), "--cache-dir", target / "client" / "mypy"])
    run([python.with_name("pyright"), "--pythonpath", python], variables)
    measured = variables | {"COVERAGE_FILE": str(target / "client" / "coverage" / "data")}
    shutil.rmtree(target / "client" / "coverage", ignore_errors=True)
    coverage = [python, "-m", "coverage"]
    tests = run([*coverage, "run", "-m", "pytest", "--quiet", "--sentences", sentences], measured).splitlines()[-1].strip("= ")
    run([*coverage, "combine", "--quiet"], measured)
    run([*coverage, "report", "--skip-covered", "--show-missing"], measured)
    return f"{tests}; {run([*coverage, 'report', '--format=total'], measured).strip()} % of lines and branches run"


def generate(target: Path) -> str:
    python = environment_of(target, "client", CLIENT / "requirements.txt") / "bin/python"
    run([python, "generate.py"])
    return "written"


def wheel(target: Path, program: Path) -> str:
    """The path of a wheel with the program."""
    pins = [pin for pin in pins_in(CLIENT / "requirements.txt") if pin.startswith("hatchling")]
    python, folder = environment_of(target, "hatchling", pins) / "bin/python", target / "wheel"
    shutil.rmtree(folder, ignore_errors=True)
    run([python, "-m", "hatchling", "build", "-t", "wheel", "-d", folder], os.environ | {"TABLETOPGEN_PROGRAM": str(program)})
    (made,) = folder.glob("*.whl")
    return f"{made} ({made.stat().st_size / 1e6:.1f} MB)"


def run(command: list, variables=None) -> str:
    """The output of a command in the folder of the client, which is shown as it comes."""
    words = [str(part) for part in command]
    lines = []
    with subprocess.Popen(words, cwd=CLIENT, env=variables, stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout or ():
            sys.stdout.write(line)
            sys.stdout.flush()
            lines.append(re.sub(r"\x1b\[[0-9;]*m", "", line))
    if process.returncode != 0:
        raise Problem(f"`{' '.join(words)}` ended with exit code {process.returncode}; see above")
    return "".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["check", "generate", "wheel"])
    parser.add_argument("--target-dir", type=Path, default=ROOT / "target")
    parser.add_argument("--program", type=Path)
    parser.add_argument("--sentences", type=int, default=30)
    given = parser.parse_args()
    target = given.target_dir.resolve()
    program = (given.program or target / "release" / "tabletopgen").resolve()
    if given.what == "check":
        print(check(target, program, given.sentences))
    else:
        print(generate(target) if given.what == "generate" else wheel(target, program))
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Problem as problem:
        sys.exit(str(problem))
