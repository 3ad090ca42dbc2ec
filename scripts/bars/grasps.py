"""Grasps of the objects of generated scenes, tried again by MuJoCo.

    PYTHONPATH=scripts python3 -m bars.grasps [--target-dir target] [--scenes 30] [--robot panda]

`tabletopgen-lab grasp-trials` tries grasps of every object of the scenes that the bar `robot` uses, until three are stable
or eight were tried; MuJoCo repeats each trial with the exported gripper and object (tests/judges/robots/replay_grasps.py).
"""

import json
import subprocess
from collections import Counter

from bars.page import arguments, lab_beside, percent, table, write
from bars.robot import JUDGES, Bench, scene_sentences
from bars.run import run
from generating import run_alone
from server import Problem

# The bars.
STABLE, UNSTABLE = 0.95, 0.80
TRIALS = ("--set", "grasps.wanted_stable=3", "--set", "grasps.max_trials=8")
SCENE_S = 900
VERDICTS = ("stable", "slipped", "dropped")


def main() -> bool:
    given = arguments(__doc__.splitlines()[0], scenes=30, robot="panda", readers="no", minutes=0.0, jobs=1)
    bench, trials, objects = Bench(given), [], 0
    for number, sentence in enumerate(scene_sentences()[: given.scenes]):
        bundle = bench.scene(f"scene_{number:03}", sentence.text, sentence.seed)
        found = repeated(bench, lab_beside(given.binary), bundle, number, given.robot)
        objects += len(found)
        trials += [trial for record in found for trial in record["trials"]]
        print(f"[{number + 1}/{given.scenes}] {len(trials)} trials", flush=True)
    bars, body = summary(trials, objects, given)
    write("grasps", "Grasps, tried again", body)
    return all(holds for *_, holds in bars)


def repeated(bench: Bench, lab, bundle, seed: int, robot: str) -> list:
    """What both simulators say of each trial in a scene."""
    out = bench.folder / "grasps" / f"{bundle.name}_{robot}"
    words = ["grasp-trials", "--bundle", bundle, "--robot", robot, "--seed", seed, "--out", out, *TRIALS]
    tried = run_alone([str(lab), *map(str, words)], SCENE_S, {"RAYON_NUM_THREADS": "1", "PATH": "/usr/bin:/bin"})
    if tried.exit_code != 0:
        raise Problem(f"grasps in {bundle}: {tried.stderr[-500:]}")
    (out / "lines").write_text(tried.stdout, encoding="utf-8")
    command = [bench.python, JUDGES / "replay_grasps.py", out / "robot.xml", bundle / "mjcf" / "scene.xml", out / "lines"]
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
        table(["", "found", "bar", ""], [[*one[:2], f"{100 * one[2]:g} %", told(one[3])] for one in bars]),
        f"{len(trials)} trials with {objects} objects of {given.scenes} generated scenes by the {given.robot}.",
        table(["judged", "trials", *(f"MuJoCo: {word}" for word in VERDICTS)], rows),
    ]
    return bars, "\n\n".join(body)


def bar(what: str, found: int, total: int, wanted: float) -> tuple:
    share = found / total if total else 0.0
    return what, f"{percent(share)} of {total}", wanted, share >= wanted


def told(holds: bool) -> str:
    return "holds" if holds else "DOES NOT HOLD"


if __name__ == "__main__":
    run(main)
