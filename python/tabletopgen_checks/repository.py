"""Folders of the repository."""

from pathlib import Path

# The folder that Python finds this package in.
PYTHON = Path(__file__).resolve().parent.parent
ROOT = PYTHON.parent
CATALOG = ROOT / "config" / "catalog"
JUDGES = ROOT / "tests" / "judges"
SCRIPTS = ROOT / "scripts"
WORDS = ROOT / "tests" / "words"
