"""What is generated is what generate.py writes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
PACKAGE = HERE.parent / "src" / "tabletopgen"


def test_generated_files_are_those_of_the_contract_and_of_the_asynchronous_client(tmp_path: Path) -> None:
    subprocess.run([sys.executable, HERE.parent / "generate.py", "--out", tmp_path], check=True)
    written = sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*.py"))
    assert len(written) >= 8
    differing = [str(path) for path in written if (tmp_path / path).read_bytes() != (PACKAGE / path).read_bytes()]
    assert not differing, f"run generate.py and commit what it writes: {', '.join(differing)}"
