"""What the policy sees, from joint positions, the opening of the gripper, and the first poses of the task's objects.

All is in the frame of the robot's base, meters and radians. The tool's pose is computed from the joints by the chain of
the robot's MJCF, in training and in MuJoCo alike. Objects are seen once, before the robot moves.
"""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

TOOL_SITE = "hand_tcp"


def rotations(quaternions_wxyz) -> np.ndarray:
    """Matrices of unit quaternions, (..., 4) to (..., 3, 3)."""
    w, x, y, z = np.moveaxis(np.asarray(quaternions_wxyz, dtype=float), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def transform(position_m, quaternion_wxyz) -> np.ndarray:
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = rotations(quaternion_wxyz), position_m
    return whole


def pose_of(record: dict) -> np.ndarray:
    """A pose of an episode's record as a matrix."""
    x, y, z, w = record["rotation_xyzw"]
    return transform(record["translation_m"], [w, x, y, z])


class Chain:
    """The tool's pose by the positions of the arm's joints, all of which turn about z."""

    def __init__(self, mjcf: Path, joints: list):
        root = ElementTree.parse(mjcf).getroot()
        parents = {child: parent for parent in root.iter() for child in parent}
        site = next(site for site in root.iter("site") if site.get("name") == TOOL_SITE)
        # From each joint's body to the next one's; what comes after the last joint is the last.
        self.fixed = [numbers_of(site)]
        body, left = parents[site], list(joints)
        while left:
            joint = body.find("joint")
            if joint is not None and joint.get("name") == left[-1]:
                left.pop()
                self.fixed.insert(0, numbers_of(body))
            else:
                self.fixed[0] = numbers_of(body) @ self.fixed[0]
            body = parents[body]
        while body.tag == "body":
            self.fixed[0] = numbers_of(body) @ self.fixed[0]
            body = parents[body]

    def base_from_tool(self, positions_rad: np.ndarray) -> np.ndarray:
        """(frames, joints) to (frames, 4, 4)."""
        whole = np.broadcast_to(self.fixed[0], (len(positions_rad), 4, 4))
        for position, fixed in zip(positions_rad.T, self.fixed[1:], strict=True):
            turn = np.zeros((len(position), 4, 4))
            turn[:, 0, 0] = turn[:, 1, 1] = np.cos(position)
            turn[:, 1, 0], turn[:, 0, 1] = np.sin(position), -np.sin(position)
            turn[:, 2, 2] = turn[:, 3, 3] = 1.0
            whole = whole @ turn @ fixed
        return whole


def numbers_of(element) -> np.ndarray:
    numbers = lambda key, default: [float(value) for value in element.get(key, default).split()]  # noqa: E731
    return transform(numbers("pos", "0 0 0"), numbers("quat", "1 0 0 0"))


def base_from_objects(record: dict, world_from_base: np.ndarray) -> np.ndarray:
    """The first poses of the objects that the task names, in the order of its goal."""
    goal = record["task"]["goal"][0]
    poses = dict(record["initial_poses"])
    return np.array([np.linalg.inv(world_from_base) @ pose_of(poses[goal[key]]) for key in ("object", "target")])


def observed(chain: Chain, positions_rad: np.ndarray, opening_m: np.ndarray, objects: np.ndarray) -> np.ndarray:
    """(frames, numbers) from joints (frames, joints), openings (frames,) and poses (frames, objects, 4, 4)."""
    tool = chain.base_from_tool(positions_rad)
    parts = [positions_rad, opening_m[:, None], tool[:, :3, 3], tool[:, :3, 0], tool[:, :3, 2]]
    for index in range(objects.shape[1]):
        base_from_object = objects[:, index]
        tool_from_object = np.linalg.inv(tool) @ base_from_object
        parts += [base_from_object[:, :3, 3], base_from_object[:, :2, 0]]
        parts += [tool_from_object[:, :3, 3], tool_from_object[:, :3, 0]]
    return np.concatenate(parts, axis=1)
