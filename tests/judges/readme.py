"""The README's Python examples run from the bundle's folder, each in a process of its own as for a reader, two at once.

Some programs want versions of their own: `tabletopgen_checks.judges.programs` makes an environment for each under
`programs/` of this one, and what has none is reported as not run. Isaac Sim and Gazebo are no packages; PyBullet is one
for some Pythons only.
"""

import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from left_out import LEFT_OUT
from verdict import Verdict

APPLICATIONS = ("Isaac Sim",)
ENVIRONMENTS = {
    "Newton": "programs/newton", "Blender": "programs/blender", "MuJoCo Warp": "programs/mujoco_warp",
    "robosuite": "programs/robosuite", "Genesis": "programs/genesis", "Pinocchio": "programs/pinocchio",
}
AT_ONCE = 2
LIMIT_S = 900


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("readme")
    asked, not_run = [], []
    for heading, code in examples((bundle / "README.md").read_text(encoding="utf-8")):
        program = heading.split(" (")[0]
        python = Path(sys.prefix) / ENVIRONMENTS.get(program, ".") / "bin" / "python"
        absent = "bullet" in LEFT_OUT and "pybullet" in code
        if program in APPLICATIONS or absent or not python.is_file():
            not_run.append(program)
        else:
            asked.append((heading, python, code))
    with ThreadPoolExecutor(AT_ONCE) as pool:
        failures = list(pool.map(lambda example: failure(bundle, *example[1:]), asked))
    for (heading, *_), words in zip(asked, failures):
        if words:
            verdict.complaints.append(f"the example for {heading} fails: {words}")
    if len(asked) < 6 - len(LEFT_OUT):
        verdict.complaints.append(f"only {len(asked)} examples were run")
    verdict.facts = {"examples": len(asked), "not_run": ", ".join(not_run)}
    return verdict


def examples(text, language="python"):
    """(heading, code) of every example in a language."""
    heading = ""
    for match in re.finditer(rf"^## ([^\n]+)$|^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        if match.group(1):
            heading = match.group(1)
        else:
            yield heading, match.group(2)


def failure(bundle, python, code) -> str:
    """The last words of an example that fails."""
    command = [str(python), "-c", code]
    try:
        run = subprocess.run(
            command, cwd=bundle, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, errors="replace", timeout=LIMIT_S,
        )
    except subprocess.TimeoutExpired:
        return f"it is not done within {LIMIT_S} s"
    if run.returncode == 0:
        return ""
    return run.stdout.strip()[-500:] or f"exit code {run.returncode}"
