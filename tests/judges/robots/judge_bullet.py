"""PyBullet reads robot.urdf, finds the same poses, and its motors hold the home pose for two seconds."""

import os
import sys

import numpy as np

from poses import Largest, pose_of

# It greets on standard output, which is for findings.
_stdout = os.dup(1)
os.dup2(2, 1)
try:
    import pybullet
finally:
    sys.stdout.flush()
    os.dup2(_stdout, 1)

# PyBullet keeps origins of joints in single precision.
SINGLE = 2e-6
HOLDING_RAD = 2e-3


def judge(folder, robot):
    client = pybullet.connect(pybullet.DIRECT)
    try:
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_SELF_COLLISION_EXCLUDE_PARENT
        body = pybullet.loadURDF(str(folder / "robot.urdf"), useFixedBase=True, flags=flags)
        count = pybullet.getNumJoints(body)
        infos = [pybullet.getJointInfo(body, index) for index in range(count)]
        joints = {info[1].decode(): info[0] for info in infos}
        links = {info[12].decode(): info[0] for info in infos}
        fingers = [info[1].decode() for info in infos if info[2] == pybullet.JOINT_PRISMATIC]
        largest = compare(body, robot, joints, links, fingers)
        held = hold(body, robot, joints, fingers)
    finally:
        pybullet.disconnect(client)
    complaints = largest.complaints("poses of robot.urdf differ", SINGLE)
    if not held < HOLDING_RAD:
        complaints.append(f"a joint ends {held:.4f} from its target at home")
    return {**largest.facts(), "home_rad": held}, complaints


def place(body, robot, joints, fingers, sample):
    for name, position in zip(robot["arm_joints"], sample["positions"]):
        pybullet.resetJointState(body, joints[name], position)
    for finger in fingers:
        pybullet.resetJointState(body, joints[finger], sample["gripper_position"])


def compare(body, robot, joints, links, fingers):
    largest = Largest()
    for number, sample in enumerate(robot["samples"]):
        place(body, robot, joints, fingers, sample)
        for link, pose in zip(robot["links"][1:], sample["base_from_link"][1:]):
            state = pybullet.getLinkState(body, links[link], computeForwardKinematics=True)
            turn = pybullet.getMatrixFromQuaternion(state[5])
            largest.add(pose, pose_of(turn, state[4]), f"{link} of sample {number}")
    return largest


def hold(body, robot, joints, fingers):
    """How far a joint is from home after two seconds under gravity that start there."""
    home = robot["home"]
    pybullet.setGravity(0, 0, -9.81)
    place(body, robot, joints, fingers, home)
    targets = dict(zip(robot["arm_joints"], home["positions"]))
    targets |= {finger: home["gripper_position"] for finger in fingers}
    for name, position in targets.items():
        force = pybullet.getJointInfo(body, joints[name])[10]
        pybullet.setJointMotorControl2(
            body, joints[name], pybullet.POSITION_CONTROL, targetPosition=position, force=force
        )
    for _ in range(480):
        pybullet.stepSimulation()
    ends = [pybullet.getJointState(body, joints[name])[0] for name in robot["arm_joints"]]
    return float(np.abs(np.subtract(ends, home["positions"])).max())
