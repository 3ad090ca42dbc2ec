"""A policy that was trained on images does the task in MuJoCo, and the program decides whether it is done.

    policy_rollout_images.py PROGRAM BUNDLE EXECUTION STARTS WEIGHTS DATASET [--every FRAMES] [--seconds S] [--only N]

As policy_rollout.py, but the policy sees MuJoCo's own images, with its own light, floor and sky. The cameras of each
start are those of the episode of the same number in DATASET, on which the policy was trained. Needs EGL.
"""

import json
import tempfile
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np

from policy_observation import Chain, observed
from policy_rollout import Policy, Rollout, arguments, environment
from tabletopgen.env import EnvironmentFolder, SceneEnv
from tabletopgen.env.folder import DESCRIPTION, STARTS, start_of
from tabletopgen.env.recorded_dataset import RecordedDataset


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
    """A rollout of a policy that sees images, and no objects."""

    def observed(self) -> tuple:
        positions, opening = self.measured()
        numbers = observed(self.chain, positions[None], np.array([opening]), np.empty((1, 0, 4, 4)))[0]
        images = [self.seen[f"observation.images.{name}"] for name in self.policy.cameras]
        return (numbers, images), positions


def with_cameras(files: EnvironmentFolder, dataset: RecordedDataset) -> None:
    """Gives the starts of an environment the cameras of another dataset, as many as have an episode there."""
    joints = len(files.robot.joints)
    own = [start_of(dataset, entry, joints).cameras for entry in dataset.entries[: len(files.starts)]]
    starts = [replace(start, cameras=cameras) for start, cameras in zip(files.starts, own)]
    (files.folder / STARTS).write_text("".join(json.dumps(start.to_json()) + "\n" for start in starts))
    described = json.loads((files.folder / DESCRIPTION).read_text())
    described["cameras"] = dataset.entries[0]["record"]["cameras"]
    (files.folder / DESCRIPTION).write_text(json.dumps(described))


def main() -> None:
    given = arguments(__doc__, "dataset", every=4)
    policy = ImagePolicy(given.weights)
    chain = Chain(given.execution / "mjcf" / "panda.xml", policy.joints)
    with tempfile.TemporaryDirectory() as folder:
        with_cameras(environment(folder, given, policy), RecordedDataset(given.dataset))
        with closing(SceneEnv(folder=folder, program=given.program)) as env:
            rollout = ImageRollout(env, policy, chain, given.every)
            for start in range(len(env.starts))[: given.only or None]:
                print(json.dumps(rollout.run(start, given.seconds)), flush=True)


if __name__ == "__main__":
    main()
