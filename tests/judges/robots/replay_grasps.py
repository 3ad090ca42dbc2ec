"""MuJoCo repeats trials of grasps with the exported gripper and object, and says which objects stay in the hand.

    replay_grasps.py ROBOT_XML SCENE_XML LINES

LINES and ROBOT_XML are what `tabletopgen-lab grasp-trials` printed and wrote, SCENE_XML is `mjcf/scene.xml` of the
bundle. The hand hangs on three slides; the object stands alone on a plane. Prints one line of JSON for each object: of
each trial the recorded verdict, MuJoCo's, and the slip in MuJoCo.
"""

import json
import sys
from pathlib import Path

import mujoco
import numpy as np

# As in the trials (crates/method/manipulation/src/grasp/trial.rs).
HOLDING_SHARE, SETTLE_S, MAX_CLOSING_S, EXTRA_WAY_M, LOST_M = 0.3, 0.15, 0.8, 0.005, 0.05
PLANE_FRICTION = [0.5, 0.005, 0.0001]
# The slides are moved, not driven: MuJoCo's solver does not see the damping of stiff servos. So heavy, nothing moves
# them.
SLIDE_KG, SLIDE_ARMATURE_KG = 1.0, 1e6
AXES = {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}


def main() -> int:
    robot_xml, scene_xml, lines = map(Path, sys.argv[1:4])
    header, *objects = [json.loads(line) for line in lines.read_text().splitlines()]
    for record in objects:
        if record["trials"]:
            hand = Hand(robot_xml, scene_xml, header, record)
            done = [{"recorded": one["verdict"], **hand.tried(one)} for one in record["trials"]]
            print(json.dumps({"object": record["object"], "mass_kg": record["mass_kg"], "trials": done}), flush=True)
    return 0


class Hand:
    """The gripper on slides, beside one object on a plane."""

    def __init__(self, robot_xml: Path, scene_xml: Path, header: dict, record: dict):
        self.header, self.trial, self.name = header, header["trial"], record["object"]
        self.model = composed(robot_xml, scene_xml, header, record)
        self.data = mujoco.MjData(self.model)
        self.hand = self.model.body(header["hand_body"]).id
        self.site = self.model.site(header["tool_site"]).id
        self.object = self.model.body(self.name).id
        self.servo = self.model.actuator(header["gripper_joint"]).id
        def below(body):
            return body == self.hand or (body != 0 and below(self.model.body_parentid[body]))
        in_hand = {body for body in range(self.model.nbody) if below(body)}
        self.fingers = [j for j in range(self.model.njnt) if self.model.jnt_bodyid[j] in in_hand]
        # One servo pulls all fingers.
        self.position_per_n = len(self.fingers) / self.model.actuator_gainprm[self.servo][0]

    def tried(self, grasp: dict) -> dict:
        mujoco.mj_resetData(self.model, self.data)
        self.place(grasp)
        self.target_m, force_n = grasp["pregrasp_opening_m"], grasp["force_n"]
        closing_m = 0.5 * max(grasp["pregrasp_opening_m"] - grasp["opening_m"], 0.0) + EXTRA_WAY_M
        end_s = closing_m / self.trial["closing_speed_m_s"] + MAX_CLOSING_S
        while self.data.time < end_s and not self.holds(force_n):
            self.step(force_n)
        for _ in range(round(SETTLE_S / self.model.opt.timestep)):
            self.step(force_n)
        if not self.holds(force_n):
            return {"found": "dropped", "slip_m": None, "turn_rad": None}
        gripped = self.tool_from_object()
        point = np.linalg.inv(gripped) @ [0.0, 0.0, 0.0, 1.0]
        self.follow(lambda t: [0.0, 0.0, self.trial["lift_m"] * soft(t / self.trial["lift_s"])], self.trial["lift_s"], force_n)
        lifted = (self.tool_from_object() @ point)[:3]
        slip_m = turn_rad = 0.0

        def watch():
            nonlocal slip_m, turn_rad
            now = self.tool_from_object()
            slip_m = max(slip_m, float(np.linalg.norm((now @ point)[:3] - lifted)))
            cosine = 0.5 * (np.trace(now[:3, :3] @ gripped[:3, :3].T) - 1.0)
            turn_rad = max(turn_rad, float(np.arccos(np.clip(cosine, -1.0, 1.0))))
            return slip_m > LOST_M

        raised = np.array([0.0, 0.0, self.trial["lift_m"]])
        self.follow(lambda t: raised + self.shaken(t), self.trial["shake_s"] + self.trial["hold_s"], force_n, watch)
        if slip_m > LOST_M or not self.holds(force_n):
            found = "dropped"
        elif slip_m <= self.trial["max_slip_m"] and turn_rad <= self.trial["max_turn_rad"]:
            found = "stable"
        else:
            found = "slipped"
        return {"found": found, "slip_m": slip_m, "turn_rad": turn_rad}

    def place(self, grasp: dict) -> None:
        """The opened hand at the grasp: its body is moved in the model, the slides stay at zero."""
        mujoco.mj_forward(self.model, self.data)
        world_from_object = matrix(self.data.xpos[self.object], self.data.xmat[self.object])
        pose = grasp["object_from_tool"]
        x, y, z, w = pose["rotation_xyzw"]
        world_from_tool = world_from_object @ matrix(pose["translation_m"], rotation([w, x, y, z]))
        hand_from_tool = matrix(self.model.site_pos[self.site], rotation(self.model.site_quat[self.site]))
        world_from_hand = world_from_tool @ np.linalg.inv(hand_from_tool)
        self.model.body_pos[self.hand] = world_from_hand[:3, 3]
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, world_from_hand[:3, :3].flatten())
        self.model.body_quat[self.hand] = quaternion
        for joint in self.fingers:
            low, high = self.model.jnt_range[joint]
            side = 1.0 if high > -low else -1.0
            opened = grasp["pregrasp_opening_m"] / self.header["opening_per_position"]
            self.data.qpos[self.model.jnt_qposadr[joint]] = side * opened
        self.data.ctrl[self.servo] = grasp["pregrasp_opening_m"] / self.header["opening_per_position"]
        mujoco.mj_forward(self.model, self.data)

    def step(self, force_n: float) -> None:
        """The target closes with the wanted speed and leads the fingers by what the force needs
        (execution/fingers.rs)."""
        ratio = self.header["opening_per_position"]
        joint = self.model.joint(self.header["gripper_joint"]).id
        opening_m = ratio * self.data.qpos[self.model.jnt_qposadr[joint]]
        lead_m = ratio * force_n * self.position_per_n
        way_m = ratio * self.trial["closing_speed_m_s"] * self.model.opt.timestep
        moved_m = max(np.clip(self.target_m, opening_m - lead_m, opening_m + lead_m) - way_m, -lead_m)
        self.target_m = float(np.clip(moved_m, opening_m - lead_m, opening_m + lead_m))
        self.data.ctrl[self.servo] = self.target_m / ratio
        mujoco.mj_step(self.model, self.data)

    def follow(self, place, duration_s: float, force_n: float, watch=lambda: False) -> None:
        steps = round(duration_s / self.model.opt.timestep)
        step_s = self.model.opt.timestep
        for step in range(steps):
            now, then = (np.array(place(k * step_s)) for k in (step, step + 1))
            for axis, at, to in zip(AXES, now, then):
                joint = self.data.joint(f"slide_{axis}")
                joint.qpos[0], joint.qvel[0] = at, (to - at) / step_s
            self.step(force_n)
            if watch():
                break
        for axis in AXES:
            self.data.joint(f"slide_{axis}").qvel[0] = 0.0

    def shaken(self, time_s: float) -> np.ndarray:
        phase = 2.0 * np.pi * self.trial["shake_hz"] * time_s
        edge = 4.0 * time_s / self.trial["shake_s"]
        waves = [np.sin(phase), np.sin(phase + 1.0) - np.sin(1.0), np.sin(phase + 2.0) - np.sin(2.0)]
        return self.trial["shake_m"] * soft(min(edge, 4.0 - edge)) * np.array(waves)

    def holds(self, force_n: float) -> bool:
        pressing = dict.fromkeys((self.model.jnt_bodyid[joint] for joint in self.fingers), 0.0)
        force = np.zeros(6)
        for number, contact in enumerate(self.data.contact):
            bodies = [self.model.geom_bodyid[geom] for geom in contact.geom]
            if self.object in bodies:
                other = bodies[1 - bodies.index(self.object)]
                if other in pressing:
                    mujoco.mj_contactForce(self.model, self.data, number, force)
                    pressing[other] += force[0]
        return all(newtons >= HOLDING_SHARE * force_n for newtons in pressing.values())

    def tool_from_object(self) -> np.ndarray:
        world_from_tool = matrix(self.data.site_xpos[self.site], self.data.site_xmat[self.site])
        return np.linalg.inv(world_from_tool) @ matrix(self.data.xpos[self.object], self.data.xmat[self.object])


def composed(robot_xml: Path, scene_xml: Path, header: dict, record: dict):
    """The scene's object alone on a plane, and the robot's hand on slides along the axes of the world."""
    robot, spec = mujoco.MjSpec.from_file(str(robot_xml)), mujoco.MjSpec.from_file(str(scene_xml))
    for name in ("timestep", "integrator", "cone", "impratio", "noslip_iterations"):
        setattr(spec.option, name, getattr(robot.option, name))
    spec.memory = robot.memory
    for every in (spec.keys, spec.excludes, spec.sensors):
        for one in list(every):
            spec.delete(one)
    for body in list(spec.worldbody.bodies):
        if body.name != record["object"]:
            spec.delete(body)
    plane = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[2, 2, 0.1], pos=[0, 0, record["plane_z_m"]])
    plane.friction = PLANE_FRICTION
    carrier = spec.worldbody
    for axis, direction in AXES.items():
        carrier = carrier.add_body(name=f"slide_{axis}", gravcomp=1, mass=SLIDE_KG, inertia=[1e-3] * 3, ipos=[0, 0, 0])
        carrier.explicitinertial = True
        slide = carrier.add_joint(name=f"slide_{axis}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=direction)
        slide.armature = SLIDE_ARMATURE_KG
    carrier.add_frame().attach_body(robot.body(header["hand_body"]), "", "")
    return spec.compile()


def matrix(position, turned) -> np.ndarray:
    transform = np.eye(4)
    transform[:3, :3], transform[:3, 3] = np.reshape(turned, (3, 3)), position
    return transform


def rotation(quaternion_wxyz) -> np.ndarray:
    flat = np.zeros(9)
    mujoco.mju_quat2Mat(flat, np.array(quaternion_wxyz, dtype=float))
    return flat


def soft(share: float) -> float:
    share = min(max(share, 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)


if __name__ == "__main__":
    sys.exit(main())
