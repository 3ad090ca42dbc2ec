"""Numbers of a state and of an action, as datasets name and order them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tabletopgen.env import poses
from tabletopgen.env.poses import Array

POSITION = ["end_effector_x_m", "end_effector_y_m", "end_effector_z_m"]
QUATERNION = ["end_effector_qw", "end_effector_qx", "end_effector_qy", "end_effector_qz"]
ROTATION = [f"end_effector_row{row}_column{column}" for column in (0, 1) for row in (0, 1, 2)]
GRIPPER = ["gripper_opening_m", "gripper_0_closed_1_open"]

Vector = NDArray[np.float32]


def state_names(joints: Sequence[str]) -> list[str]:
    """Names of `observation.state`."""
    positions = [f"{joint}_rad" for joint in joints]
    return [*positions, *(f"{joint}_rad_per_s" for joint in joints), *POSITION, *QUATERNION, *ROTATION, *GRIPPER]


def action_names(joints: Sequence[str]) -> list[str]:
    """Names of `action`."""
    return [*(f"{joint}_rad" for joint in joints), *POSITION, *QUATERNION, *ROTATION, *GRIPPER]


class StateVector:
    """States of one episode. The pose of the tool is in the frame of the base; of its two quaternions each state has
    the one that is nearer to that of the state before."""

    def __init__(self, max_opening_m: float, first_quaternion_wxyz: Sequence[float]):
        self.max_opening_m = max_opening_m
        self.near = np.array(first_quaternion_wxyz, dtype=float)

    def numbers(self, positions_rad: Array, velocities_rad_s: Array, base_from_tool: Array, opening_m: float) -> Vector:
        """The numbers of one state."""
        quaternion = poses.quaternion_wxyz(base_from_tool[:3, :3])
        self.near = quaternion if quaternion @ self.near >= 0.0 else -quaternion
        pose = [base_from_tool[:3, 3], self.near, base_from_tool[:3, 0], base_from_tool[:3, 1]]
        gripper = [opening_m, min(max(opening_m / self.max_opening_m, 0.0), 1.0)]
        return np.concatenate([positions_rad, velocities_rad_s, *pose, gripper]).astype(np.float32)
