"""The programs that check the dependencies: cargo-deny (licenses, sources, bans) and cargo-shear (what is not used).

    PYTHONPATH=python python3 -m tabletopgen_checks.tools advisories|pages [--target-dir target]

tools.txt pins them as wheels, which install in seconds. Where no wheel fits the machine cargo builds the same versions,
once, in minutes. They stay in `tools` of the target directory.

`advisories` asks the RustSec database about Cargo.lock. The database is on the network, so `make test` does without.
`pages` lists the age of the pages of results (`tabletopgen_checks.result_pages`).
"""

import argparse
import os
import re
import subprocess
import sys
from pathlib import Path

from tabletopgen_checks import result_pages
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import ROOT

# Of cargo-deny. `cargo deny check bans` also tells of crates in two versions, on many pages.
CHECKS = ["--allow", "duplicate", "bans", "licenses", "sources"]
PINS = Path(__file__).with_name("tools.txt")


def pinned(words: str) -> dict:
    """Program to version, of the lines of tools.txt."""
    return dict(re.findall(r"^astral-dev-toolchain-([a-z-]+)==([0-9.]+)", words, re.MULTILINE))


def installed(folder: Path) -> Path:
    """The folder that holds the pinned programs, which are installed where they are missing."""
    wanted = pinned(PINS.read_text(encoding="utf-8"))
    if missing(folder, wanted):
        from_wheels(folder)
    for program in missing(folder, wanted):
        build(folder, program, wanted[program])
    if lacking := missing(folder, wanted):
        raise Problem(f"{' and '.join(lacking)} could not be installed; see above")
    return folder / "bin"


def missing(folder: Path, wanted: dict) -> list:
    return [program for program, version in wanted.items() if version_of(folder / "bin" / program) != version]


def version_of(program: Path) -> str:
    """Empty where the program is not there or does not run."""
    try:
        words = subprocess.run([program, "--version"], capture_output=True, text=True).stdout
    except OSError:
        return ""
    found = re.search(r"\d+\.\d+\.\d+", words)
    return found[0] if found else ""


def from_wheels(folder: Path):
    """Whether it worked is seen from what is there afterwards."""
    subprocess.run([sys.executable, "-m", "venv", "--clear", folder], check=True)
    pip = [folder / "bin/python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "--only-binary", ":all:", "--require-hashes", "-r", PINS])


def build(folder: Path, program: str, version: str):
    print(f"   no wheel of {program} {version} for this machine; cargo builds it, once", flush=True)
    command = [os.environ.get("CARGO", "cargo"), "install", "--locked", "--force", "--root", folder]
    subprocess.run([*command, "--target-dir", folder / "build", f"{program}@{version}"], cwd=ROOT)


def check_advisories(folder: Path):
    command = [installed(folder) / "cargo-deny", "--locked", "check", "advisories"]
    if subprocess.run(command, cwd=ROOT).returncode != 0:
        raise Problem("an advisory is about a dependency, or the database could not be read; see above")


def main() -> int:
    parser = argparse.ArgumentParser(description="Advisories about the dependencies, or the age of the pages of results.")
    parser.add_argument("what", choices=["advisories", "pages"])
    parser.add_argument("--target-dir", type=Path, default=ROOT / "target")
    arguments = parser.parse_args()
    if arguments.what == "pages":
        print(result_pages.listing())
        return 0
    try:
        check_advisories(arguments.target_dir.resolve() / "tools")
        return 0
    except Problem as problem:
        print(problem, file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
