"""The README's Python examples run from the bundle's folder, except those that need an application."""

import contextlib
import io
import os
import re
from pathlib import Path

from overheard import Overheard
from verdict import Verdict

# Isaac Sim and Blender run Python of their own.
NEEDS_APPLICATION = ("Isaac Sim", "Blender")


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("readme")
    text = (bundle / "README.md").read_text(encoding="utf-8")
    run, heading = 0, ""
    before = os.getcwd()
    os.chdir(bundle)
    try:
        for match in re.finditer(r"^## ([^\n]+)$|^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
            if match.group(1):
                heading = match.group(1)
            elif not heading.startswith(NEEDS_APPLICATION):
                try:
                    with Overheard(), contextlib.redirect_stdout(io.StringIO()):
                        exec(compile(match.group(2), f"README.md ({heading})", "exec"), {})
                    run += 1
                except Exception as error:  # an example may fail in any way
                    verdict.complaints.append(f"the example for {heading} fails: {error!r}")
    finally:
        os.chdir(before)
    if run + len(verdict.complaints) < 3:
        verdict.complaints.append(f"only {run} examples were found")
    verdict.facts = {"examples": run}
    return verdict
