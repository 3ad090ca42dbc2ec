"""Folders of the repository, its programs, and its history."""

import subprocess
from pathlib import Path

# The folder that Python finds this package in.
PYTHON = Path(__file__).resolve().parent.parent
ROOT = PYTHON.parent
CATALOG = ROOT / "config" / "catalog"
JUDGES = ROOT / "tests" / "judges"
RESULTS = ROOT / "docs" / "results"
SCRIPTS = ROOT / "scripts"
WORDS = ROOT / "tests" / "words"


def lab_beside(binary: Path) -> Path:
    """The program of the benchmarks, synthetic images and mock vendors, of the same build as `binary`."""
    return binary.with_name("tabletopgen-lab")


def git(*words) -> str:
    """The output of a git command in the repository; empty where it failed."""
    run = subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True)
    return run.stdout.strip() if run.returncode == 0 else ""
