"""Folders of the repository, and its programs."""

from pathlib import Path

# The folder that Python finds this package in.
PYTHON = Path(__file__).resolve().parent.parent
ROOT = PYTHON.parent
CATALOG = ROOT / "config" / "catalog"
JUDGES = ROOT / "tests" / "judges"
SCRIPTS = ROOT / "scripts"
WORDS = ROOT / "tests" / "words"


def lab_beside(binary: Path) -> Path:
    """The program of the benchmarks, synthetic images and mock vendors, of the same build as `binary`."""
    return binary.with_name("tabletopgen-lab")
