"""Runs tests/judges, in the environment that tests/judges/setup.sh makes."""

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import JUDGES

# Those of judge.py that `make test` and the bars ask.
JUDGE_NAMES = (
    "schema", "report", "usd", "robotics_prop", "mjcf", "urdf", "bullet", "sdf", "glb", "marks", "collisions", "readme"
)


def start_setup(environment: Path) -> subprocess.Popen:
    """Makes the environment, beside whatever else is going on; finish with `finish_setup`."""
    return subprocess.Popen(
        ["sh", str(JUDGES / "setup.sh")],
        env=dict(os.environ, JUDGES_VENV=str(environment), PYTHON=sys.executable),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def finish_setup(setup: subprocess.Popen):
    words, _ = setup.communicate()
    if setup.returncode != 0:
        raise Problem(words.strip() or f"tests/judges/setup.sh ended with exit code {setup.returncode}")


def judge(environment: Path, bundles, dss_bar=0.95, only=(), slow_seconds=None) -> dict:
    """The findings of judge.py, of all judges or only of those named; `accepted` says whether all accept. `left_out`
    are those that this Python has no packages for. Drake and PyBullet simulate half a second where nothing else is
    asked for."""
    command = [str(environment / "bin/python"), str(JUDGES / "judge.py"), "--json", "--dss-bar", str(dss_bar)]
    command += ["--only", ",".join(only)] if only else []
    command += ["--slow-seconds", str(slow_seconds)] if slow_seconds else []
    run = subprocess.run(command + [str(bundle) for bundle in bundles], capture_output=True, text=True)
    if run.returncode not in (0, 1):
        raise Problem(f"judge.py did not run:\n{run.stderr.strip()[-2000:]}")
    return json.loads(run.stdout)


def judge_beside(environment: Path, asked: list, dss_bar=0.95) -> dict:
    """The findings over several calls of `judge` beside each other; each is a dictionary of its arguments."""
    with ThreadPoolExecutor(len(asked)) as pool:
        found = list(pool.map(lambda one: judge(environment, dss_bar=0.0, **one), asked))
    return merged(found, dss_bar)


def merged(found: list, dss_bar: float) -> dict:
    """Findings over different bundles as one; the share of bodies at rest is that over all of them."""
    bundles = {name: verdicts for findings in found for name, verdicts in findings["bundles"].items()}
    facts = [verdicts["mjcf"]["facts"] for verdicts in bundles.values() if "mjcf" in verdicts]
    movable = sum(fact.get("movable", 0) for fact in facts)
    dss = sum(fact.get("stable", 0) for fact in facts) / movable if movable else 1.0
    return {
        "accepted": all(findings["accepted"] for findings in found) and dss >= dss_bar,
        "dss_mujoco": dss,
        "left_out": {name: why for findings in found for name, why in findings["left_out"].items()},
        "bundles": bundles,
    }


def complaints(findings: dict, bundle: Path) -> list:
    verdicts = findings["bundles"][str(bundle.resolve())]
    return [f"{judge}: {words}" for judge, verdict in verdicts.items() for words in verdict["complaints"]]
