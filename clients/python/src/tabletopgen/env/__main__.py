"""Environments of tasks on the command line.

    python -m tabletopgen.env prepare FOLDER --scene BUNDLE --task TEXT [--dataset DATASET]
    python -m tabletopgen.env check FOLDER
    python -m tabletopgen.env repeat FOLDER DATASET
    python -m tabletopgen.env envhub FOLDER --repository ME/NAME --out PACKAGE
    python -m tabletopgen.env rollout FOLDER [FOLDER ...] --policy POLICY --out ROLLOUT
    python -m tabletopgen.env replay ROLLOUT EPISODE
    python -m tabletopgen.env sensitivity ROLLOUT [ROLLOUT ...] --out FOLDER
    python -m tabletopgen.env counterexamples FOLDER --scene BUNDLE --policy POLICY --out SEARCH
    python -m tabletopgen.env suite build FILE --out SUITE
    python -m tabletopgen.env suite run SUITE --policy POLICY --trained-on TEXT --out RESULT
    python -m tabletopgen.env suite leaderboard SUITE RESULT [RESULT ...] --out FILE

`prepare` writes the folder of an environment. `check` moves the objects by script from each start, and ends with exit
code 1 where the task is broken. `repeat` repeats the recorded actions. Both print one line of JSON for each start.
`envhub` writes the files of a repository for LeRobot's EnvHub. `rollout` runs a policy for many episodes and counts
its successes; it prints a line of JSON for each, and then the count. `replay` runs one of them again, and ends with
exit code 1 where it is not the same. `sensitivity` names the factors that explain failures.
`counterexamples` searches for the smallest changes of a scene that make a policy fail, and prints a line of JSON for
each scene that it makes. `suite` freezes many environments as a benchmark, runs policies in it, and orders results.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tabletopgen.env.control import CONTROLS
from tabletopgen.env.counterexample_axes import AXES
from tabletopgen.env.counterexamples import counterexamples
from tabletopgen.env.envhub import write_package
from tabletopgen.env.expert import Expert
from tabletopgen.env.folder import EnvironmentFolder
from tabletopgen.env.interrupts import interruptible, raise_lost
from tabletopgen.env.preparation import prepare
from tabletopgen.env.recorded_dataset import RecordedDataset
from tabletopgen.env.rollout import rollout
from tabletopgen.env.rollout_replay import replay
from tabletopgen.env.scene_env import SceneEnv
from tabletopgen.env.sensitivity import sensitivity
from tabletopgen.env.suite_commands import add_suite, suite
from tabletopgen.env.task_check import TaskCheck
from tabletopgen.errors import TabletopgenError

# The exit code of a program that Ctrl-C stopped.
STOPPED = 130


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
    add_rollout(commands)
    add_search(commands)
    add_suite(commands, add_running)
    replayed = commands.add_parser("replay", help="run an episode of a rollout again by its recorded actions")
    replayed.add_argument("rollout", type=Path, help="the folder of --out of `rollout`")
    replayed.add_argument("episode", type=int)
    replayed.add_argument("--environment", type=Path, help="where the episode's environment lies now, if it was moved")
    explained = commands.add_parser("sensitivity", help="which factors explain where rollouts fail")
    explained.add_argument("rollouts", type=Path, nargs="+", metavar="rollout", help="folders of --out of `rollout`, of one policy")
    explained.add_argument("--out", type=Path, required=True, help="a folder for the report; earlier ones are written over")
    explained.add_argument("--seed", type=int, default=0, help="of shuffles and of the parts that models leave out")
    return described


def add_rollout(commands: Any) -> None:
    """The arguments of `rollout`."""
    rolled = commands.add_parser("rollout", help="run episodes of a policy")
    rolled.add_argument("environments", type=Path, nargs="+", metavar="folder", help="folders that `prepare` wrote")
    rolled.add_argument("--episodes", type=int, help="in all environments together; each start once if absent")
    add_running(rolled)


def add_running(command: Any) -> None:
    """The arguments of what runs a policy in given environments."""
    command.add_argument("--workers", type=int, default=1, help="processes")
    command.add_argument("--videos", type=int, default=0, help="the first so many episodes as animated images")
    command.add_argument("--seed", type=int, default=0, help="of the order of starts, and of what policies draw by chance")
    add_policy(command)


def add_search(commands: Any) -> None:
    """The arguments of `counterexamples`."""
    searched = commands.add_parser("counterexamples", help="search for scenes in which a policy fails")
    searched.add_argument("environment", type=Path, metavar="folder", help="a folder that `prepare` wrote of the scene")
    searched.add_argument("--scene", type=Path, required=True, help="the folder of the bundle that is changed")
    searched.add_argument("--scenes", type=int, default=100, help="scenes that are made, refused ones among them")
    searched.add_argument("--draws", type=int, default=0, help="new starts in the scene as it is, before scenes are made")
    searched.add_argument("--randomize", default="wide", help="of these starts: usual, wide, or a file with amplitudes")
    searched.add_argument("--vary", default="", help=f"axes with commas between, all if absent: {', '.join(AXES)}")
    searched.add_argument("--episodes", type=int, default=1, help="in each scene; the policy fails where less than half succeed")
    searched.add_argument("--seed", type=int, default=0, help="of edits, recordings, the search, and what policies draw by chance")
    add_policy(searched)


def add_policy(command: Any) -> None:
    """The arguments of a policy, and of how it acts."""
    command.add_argument(
        "--policy",
        required=True,
        help="random, recorded:DATASET, lerobot:FOLDER, ws://HOST:PORT, MODULE:FUNCTION or path/file.py:FUNCTION",
    )
    command.add_argument("--out", type=Path, required=True, help="a folder; the same command continues what is in it")
    command.add_argument("--action-mode", choices=CONTROLS, help="joint; for LeRobot recorded")
    command.add_argument("--no-images", dest="images", action="store_false", help="leave cameras out of observations")
    command.add_argument("--object-poses", action="store_true", help="observe the poses of objects")
    command.add_argument("--chunk", type=int, help="actions that are carried out of each answer of a server; all if absent")
    command.add_argument("--max-duration", type=float, dest="max_duration_s", help="seconds after which an episode ends")
    command.add_argument("--rename", action="append", default=[], metavar="NAME=OTHER", help="give an observation another name")


def main(words: Sequence[str] | None = None) -> int:
    given = vars(parser().parse_args(words))
    run: dict[str, Callable[..., int]] = {
        "prepare": prepared,
        "check": check,
        "repeat": repeat,
        "envhub": envhub,
        "rollout": rolled_out,
        "replay": replayed,
        "sensitivity": explained,
        "counterexamples": searched,
        "suite": suite_step,
    }
    try:
        with interruptible():
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


def rolled_out(environments: list[Path], rename: list[str], out: Path, **given: Any) -> int:
    try:
        found = rollout(environments, out=out, rename=renamed(rename), finished=print_finished, **given)
    except KeyboardInterrupt:
        print(f"stopped; finished episodes are kept in {out}, and the same command continues", file=sys.stderr)
        return STOPPED
    print(json.dumps({**found["overall"], "out": str(out)}))
    return 0


def renamed(pairs: Sequence[str]) -> dict[str, str]:
    """Names of observations and what they are called instead."""
    names = dict(pair.split("=", 1) for pair in pairs if "=" in pair)
    if len(names) < len(pairs):
        raise ValueError(f"--rename takes NAME=OTHER, each NAME once, not {' '.join(pairs)}")
    return names


def print_finished(record: Mapping[str, Any]) -> None:
    """Prints what an episode came to. An interrupt that was lost ends the work here."""
    names = ("episode", "environment", "start", "success", "reason", "steps", "error")
    print(json.dumps({name: record[name] for name in names if record[name] is not None}), flush=True)
    raise_lost()


def replayed(**given: Any) -> int:
    found = replay(**given)
    print(json.dumps(found))
    return int(not found["equal"])


def explained(out: Path, **given: Any) -> int:
    found = sensitivity(out=out, **given)
    print(json.dumps({"named": found["named"], "episodes": found["overall"]["episodes"], "out": str(out)}))
    return 0


def searched(vary: str, rename: list[str], out: Path, **given: Any) -> int:
    axes = [name for name in vary.split(",") if name]
    try:
        found = counterexamples(out=out, vary=axes, rename=renamed(rename), finished=print_scene, **given)
    except KeyboardInterrupt:
        print(f"stopped; finished scenes are kept in {out}, and the same command continues", file=sys.stderr)
        return STOPPED
    print(json.dumps({"scenes": found["scenes"], **found["outcomes"], "out": str(out)}))
    return 0


def print_scene(record: Mapping[str, Any]) -> None:
    """Prints what a scene came to. An interrupt that was lost ends the work here."""
    names = ("scene", "outcome", "change", "distance", "reason")
    print(json.dumps({name: record[name] for name in names if name in record}), flush=True)
    raise_lost()


def suite_step(out: Path, **given: Any) -> int:
    if "rename" in given:
        given |= {"rename": renamed(given["rename"]), "finished": print_finished}
    try:
        suite(out=out, **given)
    except KeyboardInterrupt:
        print(f"stopped; what is finished is kept in {out}, and the same command continues", file=sys.stderr)
        return STOPPED
    return 0


if __name__ == "__main__":
    sys.exit(main())
