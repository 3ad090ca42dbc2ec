"""What other engines need to step the bodies of an execution along its motion: CPU microseconds a step.

    stepping.py LAB BUNDLE EXECUTION [TIMES]

EXECUTION is what `tabletopgen execute --scene BUNDLE --out EXECUTION` wrote. Here (`LAB repeat-motion`), MuJoCo (the
MJCF of the execution, its own options) and PhysX (PyPI `sapien`: the collision shapes and the robot of its URDF) begin
with the same bodies at the same poses, and their servos get the recorded targets, each until the next frame, at 500
steps a second. MuJoCo and PhysX also say how far from here the moved object ends. Prints one line of JSON.
"""

import json
import math
import re
import resource
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import mujoco
import numpy as np

STEPS_PER_S = 500


def main(lab: str, bundle: str, execution: Path, times: int) -> int:
    recording = json.loads((execution / "trajectory.json").read_text())
    verdict = json.loads((execution / "execution.json").read_text())["execution"]
    results = own(lab, bundle, execution, times)
    for name, engine in (("mujoco", Mujoco), ("physx", Physx)):
        world = engine(execution, recording, verdict)
        used_s, steps = 0.0, 0
        for _ in range(times):
            world.begin()
            before = time.process_time()
            for frame in recording["frames"]:
                world.follow(frame, round(STEPS_PER_S / recording["rate_hz"]))
            used_s += time.process_time() - before
            steps += len(recording["frames"]) * round(STEPS_PER_S / recording["rate_hz"])
        results[f"{name}_us"] = 1e6 * used_s / steps
        results[f"{name}_apart_mm"] = 1e3 * apart_m(recording, world)
    print(json.dumps(results))
    return 0


def own(lab: str, bundle: str, execution: Path, times: int) -> dict:
    """Of so many repetitions and one, less those of one: what it takes to begin is left out."""
    used_s, results = [], []
    for count in (1, 1 + times):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        words = [lab, "repeat-motion", "--bundle", bundle, "--execution", str(execution), "--times", str(count)]
        results.append(json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout))
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        used_s.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    steps = results[1]["steps"] - results[0]["steps"]
    return {"steps": results[0]["steps"], "objects": results[0]["objects"], "hulls": results[0]["hulls"],
            "own_us": 1e6 * (used_s[1] - used_s[0]) / steps}


def apart_m(recording: dict, world) -> float:
    """How far the object that moved most ends from where it was recorded."""
    first, last = (np.array([pose["translation_m"] for pose in frame["object_poses"]])
                   for frame in (recording["frames"][0], recording["frames"][-1]))
    moved = int(np.linalg.norm(last - first, axis=1).argmax())
    return float(np.linalg.norm(world.position_m(recording["objects"][moved]) - last[moved]))


class Mujoco:
    def __init__(self, execution: Path, recording: dict, verdict: dict):
        self.robot, self.recording = verdict["robot"], recording
        self.model = mujoco.MjModel.from_xml_path(str(execution / "mjcf" / f"scene_with_{self.robot}.xml"))
        self.model.opt.timestep = 1 / STEPS_PER_S
        self.data = mujoco.MjData(self.model)
        names = [*recording["joints"], recording["gripper_joint"]]
        self.actuators = [self.model.actuator(f"{self.robot}_{name}").id for name in names]

    def begin(self):
        mujoco.mj_resetData(self.model, self.data)
        first = self.recording["frames"][0]
        for name, position in zip(self.recording["joints"], first["joint_positions"], strict=True):
            self.data.joint(f"{self.robot}_{name}").qpos[0] = position
        arm = {f"{self.robot}_{name}" for name in self.recording["joints"]}
        for number in range(self.model.njnt):
            name = self.model.joint(number).name
            if name.startswith(f"{self.robot}_") and name not in arm:
                self.data.joint(name).qpos[0] = first["gripper_target"]
        for name, pose in zip(self.recording["objects"], first["object_poses"], strict=True):
            joint = self.model.joint(self.model.body_jntadr[self.model.body(name).id])
            x, y, z, w = pose["rotation_xyzw"]
            self.data.joint(joint.name).qpos[:] = [*pose["translation_m"], w, x, y, z]
        mujoco.mj_forward(self.model, self.data)

    def follow(self, frame: dict, steps: int):
        self.data.ctrl[self.actuators] = [*frame["joint_targets"], frame["gripper_target"]]
        mujoco.mj_step(self.model, self.data, nstep=steps)

    def position_m(self, name: str) -> np.ndarray:
        return self.data.body(name).xpos


class Physx:
    """The servos have the stiffness, damping and greatest force of those in the MJCF."""

    def __init__(self, execution: Path, recording: dict, verdict: dict):
        import sapien

        self.sapien, self.recording, self.execution, self.verdict = sapien, recording, execution, verdict
        reference = Mujoco(execution, recording, verdict)
        self.servos = {}
        for actuator in range(reference.model.nu):
            name = reference.model.actuator(actuator).name.removeprefix(f"{reference.robot}_")
            gain, bias = reference.model.actuator_gainprm[actuator], reference.model.actuator_biasprm[actuator]
            force = reference.model.actuator_forcerange[actuator, 1]
            self.servos[name] = (float(gain[0]), float(-bias[2]), float(force))
        self.links = ElementTree.parse(execution / "urdf" / "scene.urdf").getroot().findall("link")

    def begin(self):
        sapien = self.sapien
        self.scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
        self.scene.set_timestep(1 / STEPS_PER_S)
        first = self.recording["frames"][0]
        poses = dict(zip(self.recording["objects"], first["object_poses"], strict=True))
        self.actors = {}
        for link in self.links:
            if link.get("name") in poses or link.get("name") == "table":
                self.actors[link.get("name")] = self.actor(link, poses.get(link.get("name")))
        self.load_robot()
        self.drive(first)
        positions = [*first["joint_positions"], *[first["gripper_target"]] * (self.arm.dof - len(self.recording["joints"]))]
        self.arm.set_qpos(np.array(positions))

    def actor(self, link, pose):
        builder = self.scene.create_actor_builder()
        friction = float(link.find("contact/lateral_friction").get("value"))
        material = self.sapien.physx.PhysxMaterial(friction, friction, 0.0)
        for collision in link.findall("collision"):
            self.add_collision(builder, collision, material)
        if pose is None:
            return builder.build_static(link.get("name"))
        inertial = link.find("inertial")
        center = [float(number) for number in inertial.find("origin").get("xyz").split()]
        inertia = np.array([float(inertial.find("inertia").get(key)) for key in ("ixx", "iyy", "izz")])
        builder.set_mass_and_inertia(float(inertial.find("mass").get("value")), self.sapien.Pose(center), inertia)
        x, y, z, w = pose["rotation_xyzw"]
        builder.set_initial_pose(self.sapien.Pose(pose["translation_m"], [w, x, y, z]))
        return builder.build(link.get("name"))

    def add_collision(self, builder, collision, material):
        """A hull by its file, or the solid that it stands for."""
        from transforms3d.euler import euler2quat

        shape, origin = collision.find("geometry")[0], collision.find("origin")
        place, turn = (origin.get(name) or "0 0 0" for name in ("xyz", "rpy"))
        at_m, turn_rad = ([float(number) for number in numbers.split()] for numbers in (place, turn))
        pose = self.sapien.Pose(at_m, euler2quat(*turn_rad))
        if shape.tag == "mesh":
            path = self.execution / "urdf" / shape.get("filename")
            builder.add_convex_collision_from_file(str(path), pose=pose, material=material)
        elif shape.tag == "box":
            half_m = [0.5 * float(side) for side in shape.get("size").split()]
            builder.add_box_collision(pose, half_m, material=material)
        elif shape.tag == "cylinder":
            radius_m, length_m = float(shape.get("radius")), float(shape.get("length"))
            # SAPIEN's cylinders lie along x, those of URDF along z.
            upright = self.sapien.Pose(q=euler2quat(0.0, -math.pi / 2, 0.0))
            builder.add_cylinder_collision(pose * upright, radius_m, 0.5 * length_m, material=material)
        elif shape.tag == "sphere":
            builder.add_sphere_collision(pose, float(shape.get("radius")), material=material)
        else:
            raise ValueError(f"no collision shape of SAPIEN for <{shape.tag}> of URDF")

    def load_robot(self):
        source = self.execution / "urdf" / f"{self.verdict['robot']}.urdf"
        text = re.sub(r"<visual.*?</visual>", "", source.read_text(), flags=re.DOTALL)
        with tempfile.NamedTemporaryFile("w", suffix=".urdf", dir=source.parent) as file:
            file.write(text)
            file.flush()
            loader = self.scene.create_urdf_loader()
            loader.fix_root_link = True
            self.arm = loader.load(file.name)
        pose = self.verdict["world_from_base"]
        x, y, z, w = pose["rotation_xyzw"]
        self.arm.set_root_pose(self.sapien.Pose(pose["translation_m"], [w, x, y, z]))
        for link in self.arm.links:
            link.disable_gravity = True
        self.joints = self.arm.get_active_joints()
        # The servo of the gripper moves all fingers.
        fingers = len(self.joints) - len(self.recording["joints"])
        finger = tuple(number / fingers for number in self.servos[self.recording["gripper_joint"]])
        for joint in self.joints:
            is_of_arm = joint.name in self.recording["joints"]
            stiffness, damping, force = self.servos[joint.name] if is_of_arm else finger
            joint.set_drive_properties(stiffness=stiffness, damping=damping, force_limit=force)

    def drive(self, frame: dict):
        targets = dict(zip(self.recording["joints"], frame["joint_targets"], strict=True))
        for joint in self.joints:
            joint.set_drive_target(targets.get(joint.name, frame["gripper_target"]))

    def follow(self, frame: dict, steps: int):
        self.drive(frame)
        for _ in range(steps):
            self.scene.step()

    def position_m(self, name: str) -> np.ndarray:
        return np.array(self.actors[name].pose.p)


if __name__ == "__main__":
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], sys.argv[2], Path(sys.argv[3]), int(sys.argv[4]) if len(sys.argv) == 5 else 3))
