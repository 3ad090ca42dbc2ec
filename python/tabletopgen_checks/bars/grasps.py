"""Grasps of the objects of generated scenes, tried again by MuJoCo, and of the categories of the catalog.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.grasps [--target-dir target] [--scenes 30] [--robot panda] \\
        [--only categories]

`tabletopgen-lab grasp-trials` tries grasps of every object of the scenes that the bar `robot` uses, until three are
stable or eight were tried; MuJoCo repeats each trial with the exported gripper and object
(tests/judges/robots/replay_grasps.py). `tabletopgen-lab grasp-categories` tries the typical object of each category
that is for grippers.
"""

import json
import subprocess
from collections import Counter

from tabletopgen_checks.bars.page import arguments, percent, table, write, write_section
from tabletopgen_checks.bars.robot import ROBOTS, Bench, scene_sentences
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.processes import run_alone
from tabletopgen_checks.repository import JUDGES, lab_beside

DEPENDS_ON = (
    "config/catalog", "config/robots", "crates/base/catalog", "crates/base/geometry", "crates/method/manipulation",
    "crates/method/physics", "crates/method/robot", "tests/judges/robots/replay_grasps.py",
)
# The bars.
STABLE, UNSTABLE = 0.95, 0.80
GRASPED, MAX_SLIP_M = 0.95, 0.001
TRIALS = ("--set", "grasps.wanted_stable=3", "--set", "grasps.max_trials=8")
SCENE_S = 900
HEADING = "Categories"
CATEGORIES_S = 3600
VERDICTS = ("stable", "slipped", "dropped")


def main() -> bool:
    given = arguments(__doc__, scenes=30, robot="panda", readers="no", minutes=0.0, jobs=1, only="")
    by_robot = {robot: categories(lab_beside(given.binary), robot) for robot in ROBOTS}
    category_bars, category_body = category_summary(by_robot)
    if given.only == "categories":
        write_section("grasps", HEADING, category_body, DEPENDS_ON)
        return all(holds for *_, holds in category_bars)
    bench, trials, objects = Bench(given), [], 0
    for number, sentence in enumerate(scene_sentences()[: given.scenes]):
        bundle = bench.scene(f"scene_{number:03}", sentence.text, sentence.seed)
        found = repeated(bench, lab_beside(given.binary), bundle, number, given.robot)
        objects += len(found)
        trials += [trial for record in found for trial in record["trials"]]
        print(f"[{number + 1}/{given.scenes}] {len(trials)} trials", flush=True)
    bars, body = summary(trials, objects, given)
    write("grasps", "Grasps, tried again", f"{body}\n\n## {HEADING}\n\n{category_body}", DEPENDS_ON)
    return all(holds for *_, holds in bars + category_bars)


def repeated(bench: Bench, lab, bundle, seed: int, robot: str) -> list:
    """What both simulators say of each trial in a scene."""
    out = bench.folder / "grasps" / f"{bundle.name}_{robot}"
    words = ["grasp-trials", "--bundle", bundle, "--robot", robot, "--seed", seed, "--out", out, *TRIALS]
    tried = run_alone([str(lab), *map(str, words)], SCENE_S, {"RAYON_NUM_THREADS": "1", "PATH": "/usr/bin:/bin"})
    if tried.exit_code != 0:
        raise Problem(f"grasps in {bundle}: {tried.stderr[-500:]}")
    (out / "lines").write_text(tried.stdout, encoding="utf-8")
    command = [bench.python, JUDGES / "robots" / "replay_grasps.py", out / "robot.xml", bundle / "mjcf" / "scene.xml", out / "lines"]
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        raise Problem(f"MuJoCo did not repeat the grasps in {bundle}: {done.stderr[-500:]}")
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]


def summary(trials: list, objects: int, given) -> tuple:
    """Bars and text. A grasp is stable for MuJoCo by the same limits of slip and turn."""
    counts = Counter((trial["recorded"], trial["found"]) for trial in trials)
    of = {word: sum(count for (recorded, _), count in counts.items() if recorded == word) for word in VERDICTS}
    stable, unstable = of["stable"], of["slipped"] + of["dropped"]
    agreed = unstable - sum(counts[word, "stable"] for word in ("slipped", "dropped"))
    bars = [
        bar("MuJoCo agrees on grasps judged stable", counts["stable", "stable"], stable, STABLE),
        bar("MuJoCo agrees on grasps judged unstable", agreed, unstable, UNSTABLE),
    ]
    rows = [[word, of[word], *(counts[word, found] for found in VERDICTS)] for word in VERDICTS]
    body = [
        table(["", "found", "bar", ""], [[*one[:2], f"{100 * one[2]:g} %", verdict(one[3])] for one in bars]),
        f"{len(trials)} trials with {objects} objects of {given.scenes} generated scenes by the {given.robot}.",
        table(["judged", "trials", *(f"MuJoCo: {word}" for word in VERDICTS)], rows),
    ]
    return bars, "\n\n".join(body)


def categories(lab, robot: str) -> list:
    """What became of each category of the catalog that is for grippers."""
    tried = run_alone([str(lab), "grasp-categories", "--robot", robot], CATEGORIES_S, {"PATH": "/usr/bin:/bin"})
    if tried.exit_code != 0:
        raise Problem(f"grasps of categories by the {robot}: {tried.stderr[-500:]}")
    return [json.loads(line) for line in tried.stdout.splitlines()]


def category_summary(by_robot: dict) -> tuple:
    """Bars and text. A category fits the gripper if its typical object has a candidate for a grasp."""
    bars, without = [], []
    for robot, outcomes in by_robot.items():
        fitting = [one for one in outcomes if one["candidates"]]
        slips = [one["stable_slip_m"] for one in fitting if one["stable_slip_m"] is not None]
        worst_m = max(slips, default=0.0)
        bars += [
            bar(f"{robot}: categories that fit the gripper with a stable grasp", len(slips), len(fitting), GRASPED),
            (f"{robot}: largest slip of these while shaken", f"{1e3 * worst_m:.2f} mm", MAX_SLIP_M, worst_m < MAX_SLIP_M),
        ]
        names = [category_finding(one) for one in fitting if one["stable_slip_m"] is None]
        kinds = f"{len(outcomes)} categories for grippers, {len(fitting)} fit"
        without.append(f"{robot.capitalize()}: {kinds}; without a stable grasp: {', '.join(names) or 'none'}.")
    wanted = {GRASPED: f"{100 * GRASPED:g} %", MAX_SLIP_M: f"{1e3 * MAX_SLIP_M:g} mm"}
    rows = [[what, found, wanted[limit], verdict(holds)] for what, found, limit, holds in bars]
    return bars, "\n\n".join([table(["", "found", "bar", ""], rows), *without])


def category_finding(outcome: dict) -> str:
    """With the slip of the best grasp, where any held on to it at all."""
    slip_m = outcome["unstable_slip_m"]
    return outcome["category"] + (f" ({1e3 * slip_m:.1f} mm)" if slip_m else "")


def bar(what: str, found: int, total: int, wanted: float) -> tuple:
    share = found / total if total else 0.0
    return what, f"{percent(share)} of {total}", wanted, share >= wanted


def verdict(holds: bool) -> str:
    return "holds" if holds else "DOES NOT HOLD"


if __name__ == "__main__":
    run(main)
