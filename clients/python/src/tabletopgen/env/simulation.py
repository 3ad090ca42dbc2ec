"""A robot in a scene, simulated by MuJoCo from the starts of recorded episodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tabletopgen.env import poses
from tabletopgen.env.engine import mujoco
from tabletopgen.env.poses import Array
from tabletopgen.env.robot import Robot, RobotNames, below
from tabletopgen.env.start import Start

# Contacts with less force carry nothing.
TOUCH_N = 1e-3
# Times that differ by less are the same.
SAME_S = 1e-9
# An absent object hangs far below the floor, each at a place of its own, where it touches nothing and is not drawn.
ABSENT_M, APART_M, HIDDEN_GROUP = -100.0, 10.0, 5
# What an object's turn counts as speed at its surface, m/rad: as in the program's own test of rest.
ROTATION_RADIUS_M = 0.05


class Simulation:
    """The model and its state. Objects are the bodies of the scene that can move, by their names; the frame of poses is
    that of the scene: its origin is the center of the table's top."""

    def __init__(self, model: Any, names: RobotNames, objects: Sequence[str], *, sleeps: bool = False):
        self.model, self.data = model, mujoco.MjData(model)
        self.robot, self.objects = Robot(model, names), tuple(objects)
        self.body = {name: int(model.body(name).id) for name in self.objects}
        joints = {name: int(model.body_jntadr[body]) for name, body in self.body.items()}
        self.qpos = {name: int(model.jnt_qposadr[joint]) for name, joint in joints.items()}
        self.dof = {name: int(model.jnt_dofadr[joint]) for name, joint in joints.items()}
        self.geoms = {name: np.flatnonzero(np.isin(model.geom_bodyid, below(model, body))) for name, body in self.body.items()}
        self.hand_geoms = np.flatnonzero(np.isin(model.geom_bodyid, self.robot.hand_bodies) & (model.geom_contype > 0))
        self._set_present(self.objects)
        self._as_compiled = {name: getattr(model, name).copy() for name in VARIED}
        self._for_contacts: Any = None
        sleep = getattr(mujoco.mjtEnableBit, "mjENBL_SLEEP", None)
        # Objects at rest that nothing touches are not computed, by versions of MuJoCo that can leave them out.
        self._sleep = int(sleep) if sleep is not None and sleeps else 0
        model.opt.enableflags |= self._sleep

    def begin(self, start: Start) -> None:
        """The objects and the robot as an episode starts, with its masses and frictions."""
        model, data = self.model, self.data
        for name, values in self._as_compiled.items():
            getattr(model, name)[:] = values
        for name, drawn in start.objects.items():
            body, geoms = self.body[name], self.geoms[name]
            model.body_mass[body] *= drawn.mass_factor
            model.body_inertia[body] *= drawn.mass_factor
            model.geom_friction[geoms, 0] *= drawn.friction_factor
        self._set_present([name for name in self.objects if start.objects[name].world_from_object is not None])
        for name in set(self.objects) - set(self.present):
            self._take_away(name)
        mujoco.mj_setConst(model, data)
        mujoco.mj_resetData(model, data)
        for place, name in enumerate(self.objects):
            pose = start.objects[name].world_from_object
            away = {"translation_m": [0.0, 0.0, ABSENT_M - APART_M * place], "rotation_xyzw": [0.0, 0.0, 0.0, 1.0]}
            self.put(name, pose if pose is not None else away)
        self.robot.place(data, np.array(start.positions_rad), start.opening_m)
        mujoco.mj_forward(model, data)

    def _set_present(self, names: Sequence[str]) -> None:
        self.present = tuple(names)
        self._present_dof = np.array([self.dof[name] + k for name in names for k in range(6)], dtype=int)
        self._present_qpos = np.array([self.qpos[name] + k for name in names for k in range(7)], dtype=int)

    def _take_away(self, name: str) -> None:
        geoms = self.geoms[name]
        self.model.geom_contype[geoms] = self.model.geom_conaffinity[geoms] = 0
        self.model.geom_group[geoms] = HIDDEN_GROUP
        self.model.body_gravcomp[self.body[name]] = 1.0

    def put(self, name: str, pose: Mapping[str, Any]) -> None:
        """Puts an object at a pose (`translation_m`, `rotation_xyzw`), at rest."""
        x, y, z, w = pose["rotation_xyzw"]
        self.data.qpos[self.qpos[name] : self.qpos[name] + 7] = [*pose["translation_m"], w, x, y, z]
        self.data.qvel[self.dof[name] : self.dof[name] + 6] = 0.0

    def move(self, targets: Array, until_s: float) -> None:
        """Moves the targets of the servos straight from where they are to these, which they reach at a time."""
        model, data, servos = self.model, self.data, self.robot.servos
        duration_s, last = until_s - data.time, data.ctrl[servos].copy()
        steps = int(np.ceil((duration_s - SAME_S) / model.opt.timestep))
        shares = model.opt.timestep / duration_s * np.arange(steps)
        for between in last + shares[:, None] * (targets - last):
            data.ctrl[servos] = between
            mujoco.mj_step(model, data)
        data.ctrl[servos] = targets
        # A step leaves poses where they were at its beginning.
        mujoco.mj_kinematics(model, data)

    def is_stable(self) -> bool:
        """Whether MuJoCo has not given up on this motion."""
        bad = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
        return all(self.data.warning[int(kind)].number == 0 for kind in bad)

    def pose(self, name: str) -> dict[str, list[float]]:
        """`world_from_object` of an object, as files state poses."""
        w, x, y, z = self.data.qpos[self.qpos[name] + 3 : self.qpos[name] + 7].tolist()
        at = self.data.qpos[self.qpos[name] : self.qpos[name] + 3].tolist()
        return {"translation_m": at, "rotation_xyzw": [x, y, z, w]}

    def matrix(self, name: str) -> Array:
        """The same as a matrix."""
        return poses.of_record(self.pose(name))

    def fastest_m_s(self) -> float:
        """The highest speed of an object that is present; turning counts as at 5 cm from its axis."""
        velocities = self.data.qvel[self._present_dof].reshape(-1, 2, 3)
        linear_m_s, angular_rad_s = np.sqrt((velocities * velocities).sum(2)).T
        return float((linear_m_s + ROTATION_RADIUS_M * angular_rad_s).max(initial=0.0))

    def arrangement(self) -> Array:
        """Positions and quaternions (w first) of the objects that are present, (objects, 7)."""
        found: Array = self.data.qpos[self._present_qpos].reshape(-1, 7)
        return found

    def hand_is_away(self, gap_m: float) -> bool:
        """Whether the hand is at least this far from all objects."""
        model, data = self.model, self.data
        geoms = np.concatenate([self.geoms[name] for name in self.present])
        geoms = geoms[model.geom_contype[geoms] > 0]
        for hand in self.hand_geoms:
            between_m = np.linalg.norm(data.geom_xpos[geoms] - data.geom_xpos[hand], axis=1)
            near = geoms[between_m - model.geom_rbound[geoms] - model.geom_rbound[hand] < gap_m]
            if any(mujoco.mj_geomDistance(model, data, hand, geom, gap_m, None) < gap_m for geom in near):
                return False
        return True

    def state(self) -> dict[str, Any]:
        """Poses and contacts, as `tabletopgen judge` reads them."""
        return {"objects": {name: self.pose(name) for name in self.present}, "contacts": self.contacts()}

    def contacts(self) -> list[dict[str, Any]]:
        """Pairs among table, gripper and objects that press on each other."""
        model, data = self.model, self._with_all_contacts()
        found, force = set(), np.zeros(6)
        for number in range(data.ncon):
            mujoco.mj_contactForce(model, data, number, force)
            first, second = sorted(self._side(int(geom)) for geom in data.contact[number].geom)
            if force[0] > TOUCH_N and first != second:
                found.add((first, second))
        word = {"table": "table", "gripper": "gripper"}
        sides = [[word.get(name, {"object": name}) for name in pair] for pair in sorted(found)]
        return [{"first": first, "second": second} for first, second in sides]

    def _with_all_contacts(self) -> Any:
        """The state with contacts of all objects, also of those that are left out while they rest."""
        if not self._sleep:
            return self.data
        if self._for_contacts is None:
            self._for_contacts = mujoco.MjData(self.model)
        whole = self._for_contacts
        for name in ("qpos", "qvel", "ctrl"):
            getattr(whole, name)[:] = getattr(self.data, name)
        self.model.opt.enableflags &= ~self._sleep
        mujoco.mj_forward(self.model, whole)
        self.model.opt.enableflags |= self._sleep
        return whole

    def _side(self, geom: int) -> str:
        body = int(self.model.geom_bodyid[geom])
        if body in self.robot.bodies:
            return "gripper"
        name = str(self.model.body(body).name)
        return name if name in self.body else "table"


# What differs between episodes.
VARIED = ("body_mass", "body_inertia", "body_gravcomp", "geom_friction", "geom_contype", "geom_conaffinity", "geom_group")
