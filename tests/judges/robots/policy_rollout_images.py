"""A policy that was trained on images does the task in MuJoCo, and the program decides whether it is done.

    policy_rollout_images.py PROGRAM BUNDLE EXECUTION STARTS WEIGHTS DATASET [--every FRAMES] [--seconds S] [--only N]

As policy_rollout.py, but the policy sees MuJoCo's own images, with its own light, floor and sky. The cameras of each
start are those of the episode of the same number in DATASET, on which the policy was trained. Needs EGL.
"""

import argparse
import json
import os
from pathlib import Path

os.environ.setdefault("MUJOCO_GL", "egl")

import mujoco
import numpy as np
import pyarrow.parquet as parquet

from policy_observation import Chain, observed
from policy_rollout import Policy, Rollout, pose_record
from replay import judged

# Axes of OpenCV to those of MuJoCo.
TURNED = np.diag([1.0, -1.0, -1.0])


class ImagePolicy(Policy):
    """What policy_training_images.py wrote, as functions of numpy."""

    def __init__(self, weights: Path):
        super().__init__(weights)
        self.cameras = [str(name) for name in self.arrays["cameras"]]

    def targets(self, seen: tuple, positions_rad: np.ndarray) -> np.ndarray:
        a, (numbers, images) = self.arrays, seen
        features = np.concatenate([self.encoded(name, image) for name, image in zip(self.cameras, images, strict=True)])
        features = np.maximum(self.normed(features, "norm"), 0.0)
        x = np.concatenate([features, (numbers - a["seen_mean"]) / a["seen_spread"]])
        for k in (0, 3):
            x = np.maximum(self.normed(a[f"head_{k}_weight"] @ x + a[f"head_{k}_bias"], f"head_{k + 1}"), 0.0)
        x = a["head_6_weight"] @ x + a["head_6_bias"]
        chunk = (x * a["wanted_spread"] + a["wanted_mean"]).reshape(-1, len(self.joints) + 1)
        chunk[:, :-1] += positions_rad
        return chunk

    def normed(self, x: np.ndarray, name: str) -> np.ndarray:
        return self.arrays[f"{name}_weight"] * (x - x.mean()) / np.sqrt(x.var() + 1e-5) + self.arrays[f"{name}_bias"]

    def encoded(self, camera: str, image: np.ndarray) -> np.ndarray:
        a, x = self.arrays, image.transpose(2, 0, 1).astype(float) / 255.0 - 0.5
        k = 0
        while a[f"encoders_{camera}_{k}_weight"].ndim == 4:
            kernel = a[f"encoders_{camera}_{k}_weight"]
            side = kernel.shape[-1]
            stride = int(a["strides"][k // 2])
            windows = np.lib.stride_tricks.sliding_window_view(np.pad(x, ((0, 0), (1, 1), (1, 1))), (side, side), (1, 2))
            x = np.tensordot(kernel, windows[:, ::stride, ::stride], ((1, 2, 3), (0, 3, 4)))
            x = np.maximum(x + a[f"encoders_{camera}_{k}_bias"][:, None, None], 0.0)
            k += 2
            if f"encoders_{camera}_{k}_weight" not in a:
                k += 1
        return a[f"encoders_{camera}_{k}_weight"] @ x.ravel() + a[f"encoders_{camera}_{k}_bias"]


class ImageRollout(Rollout):
    """A rollout that renders what the cameras of a recorded episode see."""

    def __init__(self, cameras: dict, size_px: int, **more):
        super().__init__(**more)
        self.cameras, self.size_px = cameras, size_px
        self.renderer = mujoco.Renderer(self.model, size_px, size_px)

    def observed(self) -> tuple:
        positions = np.array([self.data.joint(self.prefix + name).qpos[0] for name in self.joints])
        opening = abs(self.data.joint(self.prefix + self.gripper).qpos[0]) * self.opening_per_position
        numbers = observed(self.chain, positions[None], np.array([opening]), np.empty((1, 0, 4, 4)))[0]
        world_from_tool = self.policy.arrays["world_from_base"] @ self.chain.base_from_tool(positions[None])[0]
        images = []
        for world_from_camera, tool_from_camera, focal_px in (self.cameras[name] for name in self.policy.cameras):
            images.append(self.image(world_from_camera if tool_from_camera is None else world_from_tool @ tool_from_camera, focal_px))
        return (numbers, images), positions

    def image(self, world_from_camera: np.ndarray, focal_px: float) -> np.ndarray:
        # The scene has one camera, whose pose is set; the renderer reads it from the data.
        self.model.cam_fovy[0] = np.degrees(2.0 * np.arctan(0.5 * self.size_px / focal_px))
        self.data.cam_xpos[0] = world_from_camera[:3, 3]
        self.data.cam_xmat[0] = (world_from_camera[:3, :3] @ TURNED).ravel()
        self.renderer.update_scene(self.data, camera=0)
        return self.renderer.render()


def cameras_of(folder: Path, record: dict, policy: ImagePolicy, chain: Chain) -> dict:
    """Of each camera: its pose in the world, that on the tool if it is mounted there, and the focal length in
    pixels."""
    frames = parquet.read_table(folder / "frames.parquet")
    state = np.array(frames["observation.state"][0].as_py())
    tool = policy.arrays["world_from_base"] @ chain.base_from_tool(state[None, : len(policy.joints)])[0]
    found = {}
    for spec in record["cameras"]:
        pose = np.array(frames[f"camera.{spec['name']}.world_from_camera"][0].as_py()).reshape(4, 4)
        focal_px = frames[f"camera.{spec['name']}.intrinsics"][0].as_py()[4]
        found[spec["name"]] = (pose, np.linalg.inv(tool) @ pose if spec["mount"] == "tool" else None, focal_px)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("bundle")
    for name in ("execution", "starts", "weights", "dataset"):
        parser.add_argument(name, type=Path)
    parser.add_argument("--every", type=int, default=4, help="frames until the policy is asked again")
    parser.add_argument("--seconds", type=float, default=9.0)
    parser.add_argument("--only", type=int, default=0, help="the first so many, or all")
    given = parser.parse_args()
    policy = ImagePolicy(given.weights)
    chain = Chain(given.execution / "mjcf" / "panda.xml", policy.joints)
    seen = [json.loads(line) for line in (given.dataset / "parquet-png" / "records.jsonl").read_text().splitlines()]
    lines = (given.starts / "parquet-png" / "records.jsonl").read_text().splitlines()
    for line, other in zip(lines[: given.only or None], seen):
        entry = json.loads(line)
        index, record = entry["episode_index"], entry["record"]
        frames = parquet.read_table(given.starts / "parquet-png" / "episodes" / f"episode_{index:06d}" / "frames.parquet")
        record["world_from_base"] = pose_record(policy.arrays["world_from_base"])
        folder = given.dataset / "parquet-png" / "episodes" / f"episode_{other['episode_index']:06d}"
        cameras = cameras_of(folder, other["record"], policy, chain)
        state = np.array(frames["observation.state"][0].as_py())
        rollout = ImageRollout(
            cameras, other["record"]["cameras"][0]["width_px"], execution=given.execution, record=record, state=state,
            policy=policy, chain=chain, every=given.every,
        )
        rollout.run(given.seconds)
        verdict = judged(given.program, given.bundle, given.execution, rollout.state())
        outcome = "success" if verdict["reached"] else rollout.failure()
        print(json.dumps({"episode": index, "outcome": outcome, "risen_m": rollout.risen_m, **verdict}), flush=True)


if __name__ == "__main__":
    main()
