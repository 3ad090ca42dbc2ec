"""MuJoCo repeats recorded episodes from their servo commands or actions alone, and the program decides the tasks in its
poses.

    replay_dataset.py PROGRAM BUNDLE EXECUTION DATASET [COLUMN]

EXECUTION is what `PROGRAM execute --bundle BUNDLE --out EXECUTION` wrote with the robot of the dataset: its MJCF is
used. DATASET has the format `parquet-png` or one for LeRobot. Base, objects, masses and frictions are those of the
episode's record; the servos get the recorded numbers of COLUMN (`servo_command`, or `action`), each reached straight
within a frame; nothing else is replayed. Prints one line of JSON for each episode, and ends with exit code 0 whatever
MuJoCo found.
"""

import json
import shutil
import sys
from contextlib import closing
from dataclasses import asdict
from pathlib import Path

import numpy as np

from replay import REST_S, found, simulated
from tabletopgen.env.folder import scene_with_robot, stand_at, start_of
from tabletopgen.env.judge import Judge
from tabletopgen.env.recorded_dataset import RecordedDataset
from tabletopgen.env.simulation import Simulation


def main(program: str, bundle: str, execution: Path, dataset: Path, column: str = "servo_command") -> int:
    recorded = RecordedDataset(dataset)
    original = scene_with_robot(execution / "mjcf")
    moved = original.with_name(f"moved_{original.name}")
    for entry in recorded.entries:
        record = entry["record"]
        shutil.copyfile(original, moved)
        stand_at(moved, record["world_from_base"])
        simulation = simulated(execution, moved)
        start = start_of(recorded, entry, len(simulation.robot.names.joints))
        simulation.begin(start)
        follow(simulation, recorded.frames(entry["episode_index"], [column])[column], record["fps"])
        with closing(Judge(Path(bundle), record["task"], found(program))) as judge:
            judge.begin(start)
            verdict = judge.verdict(simulation.state())
        print(json.dumps({"episode": entry["episode_index"], "success": entry["success"], **asdict(verdict)}), flush=True)
    return 0


def follow(simulation: Simulation, asked: np.ndarray, fps: int) -> None:
    """Moves the servos through the numbers of a column, the joints first, and waits."""
    robot = simulation.robot
    joints = len(robot.names.joints)
    # An action ends with the opening and its fraction, a servo command with the opening.
    opening = joints if asked.shape[1] == joints + 1 else -2
    for frame, numbers in enumerate(asked.astype(float), start=1):
        simulation.move(robot.servo_targets(numbers[:joints], numbers[opening]), frame / fps)
    simulation.move(simulation.data.ctrl[robot.servos].copy(), len(asked) / fps + REST_S)


if __name__ == "__main__":
    if len(sys.argv) not in (5, 6):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:3], *map(Path, sys.argv[3:5]), *sys.argv[5:]))
