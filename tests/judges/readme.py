"""The README's Python examples run from the bundle's folder, each in the program it is for.

SAPIEN and Drake do not bear the others in one process. Newton and Blender want versions of their own: `programs.sh`
makes an environment for each under `programs/` of this one, and what has none is told as not run. Isaac Sim and
Gazebo are no packages; PyBullet is one for some Pythons only.
"""

import contextlib
import io
import os
import re
import subprocess
import sys
from pathlib import Path

from left_out import LEFT_OUT
from overheard import Overheard
from verdict import Verdict

APPLICATIONS = ("Isaac Sim",)
ENVIRONMENTS = {"SAPIEN": ".", "Drake": ".", "Newton": "programs/newton", "Blender": "programs/blender"}


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("readme")
    text = (bundle / "README.md").read_text(encoding="utf-8")
    run, not_run, elsewhere, heading = 0, [], [], ""
    before = os.getcwd()
    os.chdir(bundle)
    try:
        for match in re.finditer(r"^## ([^\n]+)$|^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
            if match.group(1):
                heading = match.group(1)
                continue
            program, code = heading.split(" (")[0], match.group(2)
            python = Path(sys.prefix) / ENVIRONMENTS.get(program, ".") / "bin" / "python"
            absent = "bullet" in LEFT_OUT and "pybullet" in code
            if program in APPLICATIONS or absent or not python.is_file():
                not_run.append(program)
                continue
            run += 1
            if program in ENVIRONMENTS:
                elsewhere.append((heading, start(python, code)))
            elif failure := run_here(code, heading):
                verdict.complaints.append(f"the example for {heading} fails: {failure}")
        for heading, process in elsewhere:
            words, _ = process.communicate(timeout=900)
            if process.returncode != 0:
                verdict.complaints.append(f"the example for {heading} fails: {words.strip()[-500:]}")
    finally:
        os.chdir(before)
    if run < 6 - len(LEFT_OUT):
        verdict.complaints.append(f"only {run} examples were run")
    verdict.facts = {"examples": run, "not_run": ", ".join(not_run)}
    return verdict


def run_here(code, heading):
    try:
        with Overheard(), contextlib.redirect_stdout(io.StringIO()):
            exec(compile(code, f"README.md ({heading})", "exec"), {})
    except Exception as error:  # an example may fail in any way
        return repr(error)
    return None


def start(python, code):
    """The example in a process of its own, beside the others."""
    return subprocess.Popen([str(python), "-c", code], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
