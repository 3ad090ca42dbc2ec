"""The robot in a compiled scene: where MuJoCo has its joints, servos, hand and tool."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tabletopgen.env import poses
from tabletopgen.env.engine import mujoco
from tabletopgen.env.poses import Array


@dataclass(frozen=True)
class RobotNames:
    """What the files of a robot call its parts. `opening_per_position` is the opening of the gripper for each unit of
    its joint."""

    name: str
    prefix: str
    joints: tuple[str, ...]
    gripper_joint: str
    opening_per_position: float


class Robot:
    """Places of the robot in a model. Positions of joints are radians, openings of the gripper meters."""

    def __init__(self, model: Any, names: RobotNames):
        self.names = names
        arm = [model.joint(names.prefix + joint) for joint in names.joints]
        self.arm_qpos = np.array([joint.qposadr[0] for joint in arm])
        self.arm_dof = np.array([joint.dofadr[0] for joint in arm])
        self.min_rad, self.max_rad = (np.array([joint.range[side] for joint in arm]) for side in (0, 1))
        arm_ids = {joint.id for joint in arm}
        own = [model.joint(number) for number in range(model.njnt) if model.joint(number).name.startswith(names.prefix)]
        self.fingers = [joint for joint in own if joint.id not in arm_ids]
        self.finger_qpos = np.array([joint.qposadr[0] for joint in self.fingers])
        # A finger goes away from closed to the farther end of its range.
        self.finger_sign = np.array([1.0 if joint.range[1] > -joint.range[0] else -1.0 for joint in self.fingers])
        self.gripper_qpos = int(model.joint(names.prefix + names.gripper_joint).qposadr[0])
        widest = max(abs(float(side)) for side in model.joint(names.prefix + names.gripper_joint).range)
        self.max_opening_m = names.opening_per_position * widest
        servos = [*names.joints, names.gripper_joint]
        self.servos = np.array([model.actuator(names.prefix + servo).id for servo in servos])
        self.stiffness_nm_rad = model.actuator_gainprm[self.servos[:-1], 0].copy()
        self.friction_nm = model.dof_frictionloss[self.arm_dof].copy()
        # Damping holds a servo back by its speed times this.
        self.lag_s = -model.actuator_biasprm[self.servos[:-1], 2] / self.stiffness_nm_rad
        sites = [number for number in range(model.nsite) if model.site(number).name.startswith(names.prefix)]
        (self.tool_site,) = sites
        self.base_body = own_root(model, int(model.site_bodyid[self.tool_site]))
        self.hand_bodies = below(model, int(model.site_bodyid[self.tool_site]))
        self.bodies = below(model, self.base_body)

        # The base is fixed to the world.
        self.world_from_base = poses.transform(model.body_pos[self.base_body], model.body_quat[self.base_body])
        self.base_from_world = poses.inverse(self.world_from_base)

    def base_from_tool(self, data: Any) -> Array:
        """Pose of the tool in the frame of the base, as kinematics were computed last."""
        return self.base_from_world @ poses.with_rotation(data.site_xpos[self.tool_site], data.site_xmat[self.tool_site])

    def positions_rad(self, data: Any) -> Array:
        positions: Array = data.qpos[self.arm_qpos]
        return positions

    def opening_m(self, data: Any) -> float:
        return float(abs(data.qpos[self.gripper_qpos])) * self.names.opening_per_position

    def place(self, data: Any, positions_rad: Array, opening_m: float) -> None:
        """Puts arm and fingers where they are to start, with servos that hold them there."""
        data.qpos[self.arm_qpos] = positions_rad
        # Targets that press a thin object are below 0, where no finger is.
        data.qpos[self.finger_qpos] = self.finger_sign * max(opening_m, 0.0) / self.names.opening_per_position
        data.ctrl[self.servos] = self.servo_targets(positions_rad, opening_m)

    def servo_targets(self, positions_rad: Array, opening_m: float) -> Array:
        """What the servos are given for these positions of the joints and this opening."""
        return np.append(positions_rad, opening_m / self.names.opening_per_position)


def below(model: Any, body: int) -> NDArray[np.int64]:
    """A body and all that it carries."""
    found = {body}
    # Bodies come after what carries them.
    for number in range(body + 1, model.nbody):
        if int(model.body_parentid[number]) in found:
            found.add(number)
    return np.array(sorted(found))


def own_root(model: Any, body: int) -> int:
    """The body at the root of the tree of a body, which the world carries."""
    while int(model.body_parentid[body]) != 0:
        body = int(model.body_parentid[body])
    return body


def joint_jacobian(model: Any, data: Any, robot: Robot) -> tuple[Array, Array]:
    """How the tool moves with the joints of the arm, in the frame of the world: (3, joints) in m/rad and in rad/rad."""
    linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    mujoco.mj_jacSite(model, data, linear, angular, robot.tool_site)
    return linear[:, robot.arm_dof], angular[:, robot.arm_dof]
