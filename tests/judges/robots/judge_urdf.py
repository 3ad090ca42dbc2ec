"""Pinocchio reads robot.urdf and finds the same poses, Jacobian and masses."""

import numpy as np
import pinocchio

from pinocchio_model import joint_vector
from poses import EXACT, Largest


def judge(folder, robot):
    model = pinocchio.buildModelFromUrdf(str(folder / "robot.urdf"), mimic=False)
    data = model.createData()
    fingers = [name for name in model.names[1:] if name not in robot["arm_joints"]]
    largest, jacobian = Largest(), 0.0
    tool = model.getFrameId(robot["tool"])
    arm = [model.joints[model.getJointId(name)].idx_v for name in robot["arm_joints"]]
    for number, sample in enumerate(robot["samples"]):
        named = dict(zip(robot["arm_joints"], sample["positions"]))
        named |= {finger: sample["gripper_position"] for finger in fingers}
        vector = joint_vector(model, named)
        columns = pinocchio.computeFrameJacobian(model, data, vector, tool, pinocchio.LOCAL_WORLD_ALIGNED)
        jacobian = max(jacobian, float(np.abs(columns[:, arm] - sample["jacobian"]).max()))
        pinocchio.framesForwardKinematics(model, data, vector)
        for link, pose in zip(robot["links"], sample["base_from_link"]):
            largest.add(pose, data.oMf[model.getFrameId(link)].homogeneous, f"{link} of sample {number}")
        largest.add(sample["base_from_tool"], data.oMf[tool].homogeneous, f"the tool of sample {number}")
    # The base is fixed to the world, whose inertia is that of joint 0.
    mass, wanted = sum(inertia.mass for inertia in model.inertias), sum(filter(None, robot["masses_kg"]))
    complaints = largest.complaints("poses of robot.urdf differ")
    if jacobian > EXACT:
        complaints.append(f"the Jacobian differs by {jacobian:.3g}")
    # The frame of the tool weighs a milligram.
    if abs(mass - wanted) > 2e-6:
        complaints.append(f"the links weigh {mass} kg, not {wanted}")
    return {**largest.facts(), "jacobian": jacobian}, complaints
