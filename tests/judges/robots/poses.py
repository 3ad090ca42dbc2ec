"""Differences between poses, and the samples of kinematics.json."""

import math

import numpy as np

# What the promise states, in meters; also for radians.
EXACT = 1e-9


class Largest:
    """The largest differences seen, and where."""

    def __init__(self):
        self.meters, self.radians, self.where = 0.0, 0.0, None

    def add(self, pose, expected, where):
        pose, expected = np.asarray(pose), np.asarray(expected)
        meters = float(np.linalg.norm(pose[:3, 3] - expected[:3, 3]))
        # The norm of R - S is 2 sqrt(2) sin(angle / 2), which is precise for small angles.
        chord = float(np.linalg.norm(pose[:3, :3] - expected[:3, :3])) / (2 * math.sqrt(2))
        radians = 2 * math.asin(min(chord, 1.0))
        if meters > self.meters or radians > self.radians:
            self.where = where
        self.meters, self.radians = max(self.meters, meters), max(self.radians, radians)

    def facts(self) -> dict:
        return {"largest_m": self.meters, "largest_rad": self.radians}

    def complaints(self, what: str, tolerance=EXACT) -> list:
        if self.meters <= tolerance and self.radians <= tolerance:
            return []
        return [f"{what}: {self.meters:.3g} m and {self.radians:.3g} rad at {self.where}"]


def pose_of(rotation, translation) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = np.reshape(rotation, (3, 3)), translation
    return pose
