"""Actions of an environment: what they ask the joints of the arm and the gripper for.

Each is absolute, and reached at the end of the step. Numbers, names and units are those of the datasets' `action`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from tabletopgen.env import poses
from tabletopgen.env.engine import mujoco
from tabletopgen.env.poses import Array
from tabletopgen.env.robot import joint_jacobian
from tabletopgen.env.simulation import Simulation
from tabletopgen.env.vectors import GRIPPER, POSITION, QUATERNION, ROTATION, Vector, action_names

# No point of a built-in arm is farther from its base.
REACH_M = 1.6
# Search for joints that put the tool at a pose: iterations, what is near enough, and damping against singular poses.
MAX_ITERATIONS, NEAR_M, NEAR_RAD, DAMPING = 20, 1e-5, 1e-4, 1e-3
# The joints of built-in arms are slower than this; a pose that is farther is approached over several steps.
MAX_RAD_S = 3.0


class Control(ABC):
    """A kind of actions: names, bounds, and the positions that an action stands for."""

    kind: ClassVar[str]

    def __init__(self, simulation: Simulation, step_s: float):
        self.simulation, self.step_s = simulation, step_s
        # Names of the numbers, with their units at the end.
        self.names = self._names()

    @abstractmethod
    def _names(self) -> list[str]: ...

    @abstractmethod
    def targets(self, action: Array, asked_rad: Array) -> tuple[Array, float]:
        """Positions of the joints and the opening in meters, from what the joints were asked for last."""

    def asked(self, action: Vector, asked_rad: Array) -> tuple[Array, float]:
        """The same within the limits of the robot. Raises `ValueError` for what is no action."""
        numbers = np.asarray(action, dtype=float)
        if numbers.shape != (len(self.names),) or not np.isfinite(numbers).all():
            raise ValueError(
                f"an action of mode {self.kind!r} is {len(self.names)} finite numbers ({', '.join(self.names)}), not {action!r}"
            )
        robot = self.simulation.robot
        positions_rad, opening_m = self.targets(numbers, asked_rad)
        return np.clip(positions_rad, robot.min_rad, robot.max_rad), min(max(opening_m, 0.0), robot.max_opening_m)

    def _joint_names(self) -> list[str]:
        return [f"{joint}_rad" for joint in self.simulation.robot.names.joints]

    def bounds(self) -> tuple[Vector, Vector]:
        """The smallest and the greatest numbers."""
        robot = self.simulation.robot
        known = {name: (low, high) for name, low, high in zip(self._joint_names(), robot.min_rad, robot.max_rad, strict=True)}
        known |= dict.fromkeys(POSITION, (-REACH_M, REACH_M)) | dict.fromkeys([*QUATERNION, *ROTATION], (-1.0, 1.0))
        known |= {GRIPPER[0]: (0.0, robot.max_opening_m), GRIPPER[1]: (0.0, 1.0)}
        low, high = zip(*(known[name] for name in self.names), strict=True)
        return np.array(low, dtype=np.float32), np.array(high, dtype=np.float32)


class JointControl(Control):
    """Positions of the joints and the opening of the gripper."""

    kind = "joint"

    def _names(self) -> list[str]:
        return [*self._joint_names(), GRIPPER[0]]

    def targets(self, action: Array, asked_rad: Array) -> tuple[Array, float]:
        return action[:-1], float(action[-1])


class RecordedControl(Control):
    """All numbers of the datasets' `action`, for policies that were trained on it as a whole. Joints and opening are
    followed; the pose of the tool and the fraction say the same again."""

    kind = "recorded"

    def _names(self) -> list[str]:
        return action_names(self.simulation.robot.names.joints)

    def targets(self, action: Array, asked_rad: Array) -> tuple[Array, float]:
        return action[: len(self.simulation.robot.names.joints)], float(action[self.names.index(GRIPPER[0])])


class ToolControl(Control):
    """Position of the tool in the frame of the base, the first two columns of its rotation, and the opening."""

    kind = "tool"

    def __init__(self, simulation: Simulation, step_s: float):
        super().__init__(simulation, step_s)
        # The search moves a robot of its own.
        self.searched = mujoco.MjData(simulation.model)

    def _names(self) -> list[str]:
        return [*POSITION, *ROTATION, GRIPPER[0]]

    def targets(self, action: Array, asked_rad: Array) -> tuple[Array, float]:
        base_from_tool = poses.with_rotation(action[:3], poses.rotation_of_columns(action[3:6], action[6:9]))
        return self._joints(base_from_tool, asked_rad), float(action[-1])

    def _joints(self, base_from_tool: Array, from_rad: Array) -> Array:
        """Joints near these that bring the tool to a pose, or as near as a step permits: damped least squares."""
        model, data, robot = self.simulation.model, self.searched, self.simulation.robot
        reach_rad, at_rad = MAX_RAD_S * self.step_s, from_rad.copy()
        for _ in range(MAX_ITERATIONS):
            data.qpos[robot.arm_qpos] = at_rad
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            target = robot.world_from_base @ base_from_tool
            off_m = target[:3, 3] - data.site_xpos[robot.tool_site]
            off_rad = rotation_vector(target[:3, :3] @ data.site_xmat[robot.tool_site].reshape(3, 3).T)
            if np.linalg.norm(off_m) < NEAR_M and np.linalg.norm(off_rad) < NEAR_RAD:
                break
            jacobian = np.concatenate(joint_jacobian(model, data, robot))
            damped = jacobian @ jacobian.T + DAMPING**2 * np.eye(6)
            way = jacobian.T @ np.linalg.solve(damped, np.concatenate([off_m, off_rad]))
            at_rad = np.clip(at_rad + way, from_rad - reach_rad, from_rad + reach_rad)
            at_rad = np.clip(at_rad, robot.min_rad, robot.max_rad)
        return at_rad


def rotation_vector(rotation: Array) -> Array:
    """Axis times angle of a rotation's matrix."""
    vector = np.zeros(3)
    mujoco.mju_quat2Vel(vector, poses.quaternion_wxyz(rotation), 1.0)
    return vector


CONTROLS: dict[str, type[Control]] = {control.kind: control for control in (JointControl, ToolControl, RecordedControl)}
