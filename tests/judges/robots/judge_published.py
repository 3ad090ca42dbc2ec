"""Forward kinematics against what others published: the URDF of the Panda in PyPI's example-robot-data, computed by
Pinocchio, and the modified DH parameters of the PiPER."""

import math

import numpy as np
import pinocchio

from pinocchio_model import joint_vector, load_published_panda
from poses import Largest

# alpha of the link before in degrees, a of the link before and d in mm; the offset of theta in degrees, for the
# firmware of today and of before S-V1.6-3.
PIPER = (
    (0, 0, 123, 0, 0),
    (-90, 0, 0, -172.22, -174.22),
    (0, 285.03, 0, -102.78, -100.78),
    (90, -21.98, 250.75, 0, 0),
    (-90, 0, 0, 0, 0),
    (90, 0, 91, 0, 0),
)

HALF_TURN = np.diag([-1.0, -1.0, 1.0, 1.0])


def judge(_folder, robot):
    largest = Largest()
    compare = {"panda": compare_panda, "piper": compare_piper}[robot["name"]]
    compare(robot, largest)
    facts = {"samples": len(robot["samples"]), **largest.facts()}
    return facts, largest.complaints("differs from the published kinematics")


def compare_panda(robot, largest):
    model = load_published_panda()
    data = model.createData()
    for number, sample in enumerate(robot["samples"]):
        named = {f"panda_{name}": value for name, value in zip(robot["arm_joints"], sample["positions"])}
        named |= {f"panda_finger_joint{k}": sample["gripper_position"] for k in (1, 2)}
        pinocchio.framesForwardKinematics(model, data, joint_vector(model, named))
        for link, pose in zip(robot["links"], sample["base_from_link"]):
            published = data.oMf[model.getFrameId(f"panda_{link}")].homogeneous
            # This edition has both fingers in one orientation; the manufacturer's newer ones turn the right one.
            published = published @ HALF_TURN if link == "rightfinger" else published
            largest.add(pose, published, f"{link} of sample {number}")


def compare_piper(robot, largest):
    for number, sample in enumerate(robot["samples"]):
        pose = np.eye(4)
        for row, position in zip(PIPER, sample["positions"]):
            alpha, a, d, *offsets = row
            offset = offsets[1 if robot["variant"] == "old_zero" else 0]
            pose = pose @ craig(math.radians(alpha), a / 1e3, d / 1e3, math.radians(offset) + position)
        flange = sample["base_from_link"][robot["links"].index("link6")]
        largest.add(flange, pose, f"the flange of sample {number}")


def craig(alpha, a, d, theta):
    """Rx(alpha) Tx(a) Rz(theta) Tz(d), as one matrix."""
    ca, sa, ct, st = math.cos(alpha), math.sin(alpha), math.cos(theta), math.sin(theta)
    return np.array(
        [
            [ct, -st, 0, a],
            [st * ca, ct * ca, -sa, -sa * d],
            [st * sa, ct * sa, ca, ca * d],
            [0, 0, 0, 1],
        ]
    )
