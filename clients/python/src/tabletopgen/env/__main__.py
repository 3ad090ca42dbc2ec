"""Environments of tasks on the command line.

    python -m tabletopgen.env prepare FOLDER --scene BUNDLE --task TEXT [--dataset DATASET]
    python -m tabletopgen.env check FOLDER
    python -m tabletopgen.env repeat FOLDER DATASET
    python -m tabletopgen.env envhub FOLDER --repository ME/NAME --out PACKAGE

`prepare` writes the folder of an environment. `check` moves the objects by script from each start, and ends with exit
code 1 where the task is broken. `repeat` repeats the recorded actions. Both print one line of JSON for each start.
`envhub` writes the files of a repository for LeRobot's EnvHub.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tabletopgen.env.control import CONTROLS
from tabletopgen.env.envhub import write_package
from tabletopgen.env.expert import Expert
from tabletopgen.env.folder import EnvironmentFolder
from tabletopgen.env.preparation import prepare
from tabletopgen.env.recorded_dataset import RecordedDataset
from tabletopgen.env.scene_env import SceneEnv
from tabletopgen.env.task_check import TaskCheck
from tabletopgen.errors import TabletopgenError


def parser() -> argparse.ArgumentParser:
    described = argparse.ArgumentParser(prog="python -m tabletopgen.env", description=(__doc__ or "").splitlines()[0])
    commands = described.add_subparsers(dest="command", required=True)
    made = commands.add_parser("prepare", help="write the folder of an environment")
    made.add_argument("folder", type=Path)
    made.add_argument("--scene", type=Path, required=True, help="the folder of a bundle")
    made.add_argument("--task", help="an instruction, or the file of a task; the first of the dataset if absent")
    made.add_argument("--robot", default="panda")
    made.add_argument("--dataset", type=Path, help="episodes whose starts, cameras and rate are taken; recorded if absent")
    made.add_argument("--starts", type=int, default=20, help="episodes that are recorded without a dataset")
    made.add_argument("--seed", type=int, default=0)
    made.add_argument("--cameras", default="", help="names with commas between, such as front,wrist; without a dataset")
    made.add_argument("--size", type=int, default=224, dest="size_px", help="pixels; without a dataset")
    made.add_argument("--fps", type=int, default=15, help="steps per second; without a dataset")
    checked = commands.add_parser("check", help="check the task by objects that a script moves")
    checked.add_argument("folder", type=Path)
    checked.add_argument("--count", type=int, help="the first so many starts")
    repeated = commands.add_parser("repeat", help="repeat recorded actions")
    repeated.add_argument("folder", type=Path)
    repeated.add_argument("dataset", type=Path)
    repeated.add_argument("--count", type=int, help="the first so many starts")
    repeated.add_argument("--action-mode", choices=CONTROLS, default="joint")
    repeated.add_argument("--images", action="store_true", help="draw what the cameras see in every step")
    published = commands.add_parser("envhub", help="write a package for LeRobot's EnvHub")
    published.add_argument("folder", type=Path)
    published.add_argument("--repository", required=True, help="the name that it is to have on the Hub")
    published.add_argument("--out", type=Path, required=True)
    return described


def main(words: Sequence[str] | None = None) -> int:
    given = vars(parser().parse_args(words))
    run: dict[str, Callable[..., int]] = {"prepare": prepared, "check": check, "repeat": repeat, "envhub": envhub}
    try:
        return run[given.pop("command")](**given)
    except (TabletopgenError, ValueError) as error:
        print(error, file=sys.stderr)
        return 2


def prepared(cameras: str, **given: Any) -> int:
    files = prepare(cameras=[name for name in cameras.split(",") if name], **given)
    print(json.dumps({"folder": str(files.folder), "task": files.task["instruction"], "starts": len(files.starts)}))
    return 0


def check(folder: Path, count: int | None) -> int:
    files = EnvironmentFolder.read(folder)
    checks = TaskCheck(files)
    broken = 0
    for found in checks.starts(range(len(files.starts))[:count]):
        print(json.dumps({**asdict(found), "is_sound": found.is_sound}), flush=True)
        broken += not found.is_sound
    checks.close()
    return int(broken > 0)


def repeat(folder: Path, dataset: Path, count: int | None, action_mode: str, images: bool) -> int:
    env = SceneEnv(folder=folder, action_mode=action_mode, images=images)
    found, began_s = [], cpu_s()
    for one in Expert(env, RecordedDataset(dataset)).repeats(range(len(env.starts))[:count]):
        print(json.dumps(asdict(one)), flush=True)
        found.append(one)
    used_s = cpu_s() - began_s
    env.close()
    steps, wall_s = sum(one.steps for one in found), sum(one.wall_s for one in found)
    rates = {"steps_per_s": round(steps / wall_s, 1), "steps_per_cpu_s": round(steps / used_s, 1)}
    print(json.dumps({"successes": sum(one.is_success for one in found), "of": len(found), "steps": steps, **rates}))
    return 0


def cpu_s() -> float:
    """CPU time of this process and of the judges that it called."""
    return sum(os.times()[:4])


def envhub(folder: Path, repository: str, out: Path) -> int:
    print(json.dumps({"package": str(write_package(EnvironmentFolder.read(folder), out, repository))}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
