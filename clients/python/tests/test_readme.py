"""The fences of the README: Python runs as it is printed, and prints what the fence after it says."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

README = Path(__file__).resolve().parent.parent / "README.md"
IMAGE = Path(__file__).resolve().parents[3] / "docs" / "demo_table.png"
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def fences() -> list[tuple[str, str]]:
    """Language and text of each."""
    return FENCE.findall(README.read_text(encoding="utf-8"))


def test_the_examples_print_what_they_say(program: Path, tmp_path: Path) -> None:
    script = "".join(text for language, text in fences() if language == "python")
    expected = "".join(text for language, text in fences() if language == "output")
    shutil.copy(IMAGE, tmp_path / "table.png")
    run = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    assert run.stdout == expected
    assert run.stderr == "", "progress is shown where no one sees it"


def test_every_fence_is_run_by_a_test() -> None:
    # Those of the shell run in test_wheel.py.
    assert {language for language, _ in fences()} == {"sh", "python", "output"}
    assert [language for language, _ in fences()].count("sh") == 1
