"""A robot at work in one small scene: a task, its execution, and two episodes of it, which MuJoCo repeats.

`make bars BARS=robot` and `make bars BARS=episodes` measure many more of each; this takes a minute or two.
"""

import json
import subprocess
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.processes import output_of
from tabletopgen_checks.repository import JUDGES
from tabletopgen_checks.scene.generation import generate
from tabletopgen_checks.virtual_environment import environment_of

SENTENCE, SEED = "A table with a block and a plate", 3
TASK = "put the block on the plate"
EPISODES = 2


def check(program: Path, folder: Path, target: Path) -> str:
    """A line about the sample; a problem if one of the programs complains. `folder` is removed before."""
    subprocess.run(["rm", "-rf", str(folder)], check=True)
    scene = folder / "scene"
    generate(program, scene, SENTENCE, SEED, threads=1)
    python = environment_of(target, "robot-judges", JUDGES / "robots" / "requirements.txt") / "bin/python"

    proposed = folder / "tasks"
    output_of(program, "tasks", "--bundle", scene, "--count", "3", "--out", proposed)
    output_of(python, JUDGES / "tasks" / "check_bddl.py", proposed)

    execution = folder / "execution"
    output_of(program, "execute", "--bundle", scene, "--task", TASK, "--out", execution)
    replay = json.loads(output_of(python, JUDGES / "robots" / "replay.py", program, scene, execution))
    if not replay["reached"]:
        raise Problem(f"MuJoCo does not reach the goal of {TASK!r} from the joint targets: {replay['predicates']}")

    dataset = folder / "episodes"
    words = ["--bundle", scene, "--task", TASK, "--count", EPISODES, "--out", dataset, "--seed", SEED]
    output_of(program, "episodes", *words, "--format", "parquet-png,lerobot-v3.0", "--cameras", "side,wrist", "--size", "64")
    repeated = output_of(python, JUDGES / "robots" / "replay_dataset.py", program, scene, execution, dataset)
    repeated = [json.loads(line) for line in repeated.splitlines() if line.startswith("{")]
    apart = [one["episode"] for one in repeated if not one["reached"]]
    if len(repeated) != EPISODES or apart:
        raise Problem(f"of {len(repeated)} episodes MuJoCo does not reach the goal in {apart} from the actions")
    output_of(program, "regenerate-episode", "--dataset", dataset, "--scene", scene, "--episode", EPISODES - 1)
    return f"MuJoCo repeats an execution and {EPISODES} episodes, of which one was made again to the byte"


