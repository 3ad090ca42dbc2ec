"""MuJoCo repeats executions from their joint targets alone, and the program decides the tasks in its poses.

    replay.py PROGRAM BUNDLE FOLDER...

Each folder is what `PROGRAM execute --bundle BUNDLE --out FOLDER` wrote. The robot starts where the motion starts; its
servos get the recorded targets, interpolated; nothing else is replayed. Prints one line of JSON for each folder. The
exit code is 1 where MuJoCo's end does not satisfy the goal.
"""

import argparse
import json
import shutil
import sys
from contextlib import closing
from dataclasses import asdict
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "clients" / "python" / "src"))

from tabletopgen.env.engine import mujoco
from tabletopgen.env.folder import robot_names, scene_with_robot
from tabletopgen.env.judge import Judge
from tabletopgen.env.simulation import Simulation

# After the last target the scene comes to rest in this time.
REST_S = 1.0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=found)
    parser.add_argument("bundle", type=Path)
    parser.add_argument("folders", nargs="+", type=Path)
    given = parser.parse_args()
    failed = False
    for folder in given.folders:
        task = json.loads((folder / "task.json").read_text())
        with closing(Judge(given.bundle, task, given.program)) as judge:
            verdict = judge.verdict(replayed(folder))
        failed |= not verdict.reached
        print(json.dumps({"folder": str(folder), **asdict(verdict)}), flush=True)
    return int(failed)


def found(program: str) -> Path:
    """A program by its path, or by its name on PATH."""
    return Path(shutil.which(program) or program).resolve()


def replayed(folder: Path) -> dict:
    """The state of the scene after the motion, in MuJoCo."""
    recording = json.loads((folder / "trajectory.json").read_text())
    simulation = simulated(folder, scene_with_robot(folder / "mjcf"))
    first, *frames = recording["frames"]
    robot, data = simulation.robot, simulation.data
    robot.place(data, np.array(first["joint_positions"]), first["gripper_target"] * robot.names.opening_per_position)
    data.ctrl[robot.servos] = targets(first)
    mujoco.mj_forward(simulation.model, data)
    for frame in frames:
        simulation.move(targets(frame), frame["time_s"])
    simulation.move(data.ctrl[robot.servos].copy(), data.time + REST_S)
    return simulation.state()


def targets(frame: dict) -> np.ndarray:
    """Those of the servos."""
    return np.array([*frame["joint_targets"], frame["gripper_target"]])


def simulated(execution: Path, mjcf: Path) -> Simulation:
    """The robot and the objects of an execution in a file."""
    report = json.loads((execution / "execution.json").read_text())["execution"]
    recording = json.loads((execution / "trajectory.json").read_text())
    model = mujoco.MjModel.from_xml_path(str(mjcf))
    return Simulation(model, robot_names(report, recording), recording["objects"])


if __name__ == "__main__":
    sys.exit(main())
