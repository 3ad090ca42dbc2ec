"""A trained policy does the task in MuJoCo, and the program decides whether it is done.

    policy_rollout.py PROGRAM BUNDLE EXECUTION STARTS WEIGHTS [--every FRAMES] [--seconds S] [--only N]

EXECUTION is what `PROGRAM execute --bundle BUNDLE --out EXECUTION` wrote with the robot of the policy: its MJCF is
used. STARTS is a dataset of the format `parquet-png`: of its episodes only the beginnings are taken, objects with their
masses and frictions and the joints of the arm. The base stands where it stood in training. What the policy asks for in
a frame is reached straight within it. Prints one line of JSON for each episode.
"""

import argparse
import json
from pathlib import Path

import mujoco
import numpy as np
import pyarrow.parquet as parquet

from policy_observation import Chain, base_from_objects, observed
from replay import REST_S, judged
from replay_dataset import Episode, opening_per_position

# An object that has risen by this, and still stands as it did, has been lifted: one that falls over may rise, too.
LIFTED_M = 0.03
# The largest angle of an upright object.
UPRIGHT_RAD = 0.5


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


class Rollout(Episode):
    """The robot at the start of an episode, driven by a policy."""

    def __init__(self, execution: Path, record: dict, state: np.ndarray, policy: Policy, chain: Chain, every: int):
        at_start = np.concatenate([state[: len(policy.joints)], [state[-2]]])[None]
        super().__init__(execution, record, state[None], at_start, [*policy.joints, "gripper_opening"])
        motion = json.loads((execution / "trajectory.json").read_text())
        self.opening_per_position = opening_per_position(motion)
        self.policy, self.chain, self.every, self.frame_s = policy, chain, every, 1.0 / record["fps"]
        self.seen_objects = base_from_objects(record, policy.arrays["world_from_base"])[None]
        self.moved = record["task"]["goal"][0]["object"]
        self.start_m = self.data.body(self.moved).xpos.copy()
        self.up = self.data.body(self.moved).xmat.reshape(3, 3)[2].copy()
        self.last, self.frames, self.risen_m = at_start[0], 0, 0.0

    def observed(self) -> tuple:
        positions = np.array([self.data.joint(self.prefix + name).qpos[0] for name in self.joints])
        finger = abs(self.data.joint(self.prefix + self.gripper).qpos[0])
        opening = np.array([finger * self.opening_per_position])
        return observed(self.chain, positions[None], opening, self.seen_objects)[0], positions

    def run(self, seconds: float) -> None:
        while self.frames * self.frame_s < seconds:
            chunk = self.policy.targets(*self.observed())
            for wanted in chunk[: self.every]:
                self.follow(wanted)
        self.hold(REST_S)

    def follow(self, wanted: np.ndarray) -> None:
        began_s = self.data.time
        self.frames += 1
        while self.data.time < self.frames * self.frame_s - 1e-9:
            share = (self.data.time - began_s) / self.frame_s
            self.send(self.last + share * (wanted - self.last))
        self.last = wanted
        if self.turned_rad() < UPRIGHT_RAD:
            self.risen_m = max(self.risen_m, float(self.data.body(self.moved).xpos[2] - self.start_m[2]))

    def hold(self, seconds: float) -> None:
        until_s = self.data.time + seconds
        while self.data.time < until_s:
            self.send(self.last)

    def send(self, wanted: np.ndarray) -> None:
        for name, target in zip(self.joints, wanted[:-1], strict=True):
            self.data.actuator(self.prefix + name).ctrl[0] = target
        self.data.actuator(self.prefix + self.gripper).ctrl[0] = wanted[-1] / self.opening_per_position
        mujoco.mj_step(self.model, self.data)

    def failure(self) -> str:
        """How a task that is not done went wrong."""
        is_upright = self.turned_rad() < UPRIGHT_RAD
        if self.risen_m < LIFTED_M:
            return "not lifted" if is_upright else "knocked over"
        return "lifted, but not at its place" if is_upright else "fell over after it was lifted"

    def turned_rad(self) -> float:
        """How far the object is turned from upright."""
        return float(np.arccos(np.clip(self.data.body(self.moved).xmat.reshape(3, 3)[2] @ self.up, -1.0, 1.0)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("bundle")
    for name in ("execution", "starts", "weights"):
        parser.add_argument(name, type=Path)
    parser.add_argument("--every", type=int, default=8, help="frames until the policy is asked again")
    parser.add_argument("--seconds", type=float, default=9.0)
    parser.add_argument("--only", type=int, default=0, help="the first so many, or all")
    given = parser.parse_args()
    policy = Policy(given.weights)
    chain = Chain(given.execution / "mjcf" / "panda.xml", policy.joints)
    root = given.starts / "parquet-png"
    for line in (root / "records.jsonl").read_text().splitlines()[: given.only or None]:
        entry = json.loads(line)
        index, record = entry["episode_index"], entry["record"]
        frames = parquet.read_table(root / "episodes" / f"episode_{index:06d}" / "frames.parquet")
        state = np.array(frames["observation.state"][0].as_py())
        record["world_from_base"] = pose_record(policy.arrays["world_from_base"])
        rollout = Rollout(given.execution, record, state, policy, chain, given.every)
        rollout.run(given.seconds)
        verdict = judged(given.program, given.bundle, given.execution, rollout.state())
        outcome = "success" if verdict["reached"] else rollout.failure()
        print(json.dumps({"episode": index, "outcome": outcome, "risen_m": rollout.risen_m, **verdict}), flush=True)


def pose_record(matrix: np.ndarray) -> dict:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, matrix[:3, :3].ravel())
    w, x, y, z = map(float, quaternion)
    return {"translation_m": matrix[:3, 3].tolist(), "rotation_xyzw": [x, y, z, w]}


if __name__ == "__main__":
    main()
