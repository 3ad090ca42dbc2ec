"""A trained policy does the task in MuJoCo, and the program decides whether it is done.

    policy_rollout.py PROGRAM BUNDLE EXECUTION STARTS WEIGHTS [--every FRAMES] [--seconds S] [--only N]

EXECUTION is what `PROGRAM execute --bundle BUNDLE --out EXECUTION` wrote with the robot of the policy: its MJCF is
used. STARTS is a dataset of episodes of which only the beginnings are taken, objects with their masses and frictions
and the joints of the arm. The base stands where it stood in training. All of that is an environment of the package
`tabletopgen` (clients/python). Prints one line of JSON for each episode.
"""

import argparse
import json
import tempfile
from contextlib import closing
from dataclasses import asdict
from pathlib import Path

import numpy as np

from policy_observation import Chain, observed
from replay import found
from tabletopgen.env import EnvironmentFolder, SceneEnv
from tabletopgen.env.folder import scene_with_robot, stand_at, write_environment
from tabletopgen.env.poses import to_record
from tabletopgen.env.recorded_dataset import RecordedDataset

# An object that has risen by this, and still stands as it did, has been lifted: one that falls over may rise, too.
LIFTED_M = 0.03
# The largest angle of an upright object.
UPRIGHT_RAD = 0.5
# What the policy asked for last is held for this long: tasks want objects to rest.
HOLD_S = 2.0


class Policy:
    """What policy_training.py wrote, as functions of numpy."""

    def __init__(self, weights: Path):
        self.arrays = dict(np.load(weights))
        self.joints = [str(name) for name in self.arrays["joints"]]
        self.layers = sum(name.startswith("weight_") for name in self.arrays)

    def targets(self, seen: np.ndarray, positions_rad: np.ndarray) -> np.ndarray:
        """(frames, joints and opening) of the next frames."""
        a = self.arrays
        x = (seen - a["seen_mean"]) / a["seen_spread"]
        for k in range(self.layers):
            x = a[f"weight_{k}"] @ x + a[f"bias_{k}"]
            if k < self.layers - 1:
                x = a[f"gain_{k}"] * (x - x.mean()) / np.sqrt(x.var() + 1e-5) + a[f"shift_{k}"]
                x = np.maximum(x, 0.0)
        chunk = (x * a["wanted_spread"] + a["wanted_mean"]).reshape(-1, len(self.joints) + 1)
        chunk[:, :-1] += positions_rad
        return chunk


class Rollout:
    """A policy that drives the robot of an environment."""

    def __init__(self, env: SceneEnv, policy: Policy, chain: Chain, every: int):
        self.env, self.policy, self.chain, self.every = env, policy, chain, every
        self.goal = env.task["goal"][0]

    def run(self, start: int, seconds: float) -> dict:
        """What the policy achieves from a start in this time."""
        self.seen, self.info = self.env.reset(options={"start": start})
        self.begin()
        steps = round(seconds / self.env.step_s)
        while steps > 0 and not self.info["is_success"]:
            chunk = self.policy.targets(*self.observed())[: min(self.every, steps)]
            steps -= len(chunk)
            self.follow(chunk)
        self.follow(np.repeat(chunk[-1:], round(HOLD_S / self.env.step_s), axis=0))
        verdict = asdict(self.env.verdict())
        outcome = "success" if self.info["is_success"] else self.failure()
        return {"episode": self.info_at_start["episode"], "outcome": outcome, "risen_m": self.risen_m, **verdict}

    def begin(self) -> None:
        """Sees the objects of the task, once."""
        simulation = self.env.simulation
        base_from_world = np.linalg.inv(self.policy.arrays["world_from_base"])
        self.info_at_start, self.risen_m = self.info, 0.0
        self.seen_objects = np.array([[base_from_world @ simulation.matrix(self.goal[key]) for key in ("object", "target")]])
        self.start = simulation.matrix(self.goal["object"])

    def observed(self) -> tuple:
        """What the policy sees, and the positions of the joints."""
        positions, opening = self.measured()
        return observed(self.chain, positions[None], np.array([opening]), self.seen_objects)[0], positions

    def measured(self) -> tuple:
        """Positions of the joints, and the opening."""
        state = self.seen["observation.state"].astype(float)
        return state[: len(self.policy.joints)], state[self.env.state_names.index("gripper_opening_m")]

    def follow(self, chunk: np.ndarray) -> None:
        """Takes actions until the task is done."""
        for wanted in chunk:
            if self.info["is_success"]:
                return
            self.seen, _, _, _, self.info = self.env.step(wanted.astype(np.float32))
            if self.turned_rad() < UPRIGHT_RAD:
                self.risen_m = max(self.risen_m, float(self.moved()[2, 3] - self.start[2, 3]))

    def moved(self) -> np.ndarray:
        return self.env.simulation.matrix(self.goal["object"])

    def failure(self) -> str:
        """How a task that is not done went wrong."""
        is_upright = self.turned_rad() < UPRIGHT_RAD
        if self.risen_m < LIFTED_M:
            return "not lifted" if is_upright else "knocked over"
        return "lifted, but not at its place" if is_upright else "fell over after it was lifted"

    def turned_rad(self) -> float:
        """How far the object is turned from upright, about horizontal axes."""
        return float(np.arccos(np.clip(self.moved()[2, :3] @ self.start[2, :3], -1.0, 1.0)))


def arguments(described: str, *more: str, every: int) -> argparse.Namespace:
    """Those of the command line."""
    parser = argparse.ArgumentParser(description=described.splitlines()[0])
    parser.add_argument("program", type=found)
    for name in ("bundle", "execution", "starts", "weights", *more):
        parser.add_argument(name, type=Path)
    parser.add_argument("--every", type=int, default=every, help="frames until the policy is asked again")
    parser.add_argument("--seconds", type=float, default=9.0)
    parser.add_argument("--only", type=int, default=0, help="the first so many, or all")
    return parser.parse_args()


def environment(folder: str, given: argparse.Namespace, policy: Policy) -> EnvironmentFolder:
    """Writes the environment of the starts, with the base where it stood in training."""
    written = write_environment(Path(folder), given.bundle, given.execution, RecordedDataset(given.starts))
    stand_at(scene_with_robot(written.folder / "mjcf"), to_record(policy.arrays["world_from_base"]))
    return written


def main() -> None:
    given = arguments(__doc__, every=8)
    policy = Policy(given.weights)
    chain = Chain(given.execution / "mjcf" / "panda.xml", policy.joints)
    with tempfile.TemporaryDirectory() as folder:
        environment(folder, given, policy)
        with closing(SceneEnv(folder=folder, images=False, program=given.program)) as env:
            rollout = Rollout(env, policy, chain, given.every)
            for start in range(len(env.starts))[: given.only or None]:
                print(json.dumps(rollout.run(start, given.seconds)), flush=True)


if __name__ == "__main__":
    main()
