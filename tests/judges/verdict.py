"""What a judge says about one bundle, and how a bundle's scene is read."""

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass
class Verdict:
    """Accepted unless there is a complaint; facts are numbers worth printing."""

    judge: str
    complaints: list = field(default_factory=list)
    facts: dict = field(default_factory=dict)

    @property
    def accepted(self):
        return not self.complaints


def read_scene(bundle: Path) -> dict:
    return json.loads((bundle / "scene.json").read_text(encoding="utf-8"))


def bodies(scene: dict) -> list:
    """The table (fixed) and the instances (movable), each with `world_from_object` as a 4x4 matrix."""
    table = dict(scene["table"], movable=False, world_from_object=np.eye(4))
    found = [table]
    for instance in scene["instances"]:
        pose = matrix(instance["translation_m"], instance["rotation_xyzw"])
        found.append(dict(instance, movable=True, world_from_object=pose))
    return found


def rotation(xyzw) -> np.ndarray:
    x, y, z, w = np.asarray(xyzw, dtype=float) / np.linalg.norm(xyzw)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def matrix(translation, xyzw) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = rotation(xyzw)
    pose[:3, 3] = translation
    return pose


def inertia_tensor(body: dict) -> np.ndarray:
    """About the center of mass, along the object's axes."""
    axes = rotation(body["principal_axes_xyzw"])
    return axes @ np.diag(body["inertia_diagonal_kg_m2"]) @ axes.T


def differs(a, b, relative=1e-4, absolute=1e-9) -> bool:
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    scale = max(np.abs(a).max(initial=0.0), np.abs(b).max(initial=0.0))
    return bool(np.abs(a - b).max(initial=0.0) > absolute + relative * scale)
