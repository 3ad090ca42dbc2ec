"""MuJoCo reads robot.xml and finds the same poses; the robot stays at home for two seconds, and holds a box of 40 mm
and 100 g in its gripper for three."""

import re

import mujoco
import numpy as np

from poses import Largest, pose_of

# How far a joint at rest may be from its target, and how far the box may slip.
HOLDING_RAD = 2e-3
SLIP_M = 1e-3
BOX_M, BOX_KG = 0.04, 0.1


def judge(folder, robot):
    text = (folder / "robot.xml").read_text(encoding="utf-8")
    model = mujoco.MjModel.from_xml_string(text)
    largest = compare(model, robot)
    facts, complaints = largest.facts(), largest.complaints("poses of robot.xml differ")
    held = hold(model, robot, robot["home"])
    facts["home_rad"] = held
    if not held < HOLDING_RAD:
        complaints.append(f"a joint ends {held:.4f} from its target at home")
    slip, gap = grip(text, robot)
    facts |= {"slip_m": slip, "gap_m": gap}
    if not slip < SLIP_M:
        complaints.append(f"the held box slips by {slip:.5f} m")
    if not abs(gap - BOX_M) < SLIP_M:
        complaints.append(f"the fingers are {gap:.4f} m apart at a box of {BOX_M} m")
    return facts, complaints


def compare(model, robot):
    data, largest = mujoco.MjData(model), Largest()
    fingers = finger_joints(model, robot)
    for number, sample in enumerate(robot["samples"]):
        for name, position in zip(robot["arm_joints"], sample["positions"]):
            data.joint(name).qpos[0] = position
        for finger in fingers:
            data.joint(finger).qpos[0] = sample["gripper_position"]
        mujoco.mj_kinematics(model, data)
        for link, pose in zip(robot["links"], sample["base_from_link"]):
            body = data.body(link)
            largest.add(pose, pose_of(body.xmat, body.xpos), f"{link} of sample {number}")
        site = data.site(robot["tool"])
        largest.add(sample["base_from_tool"], pose_of(site.xmat, site.xpos), f"the tool of sample {number}")
    return largest


def finger_joints(model, robot):
    names = [model.joint(k).name for k in range(model.njnt)]
    return [name for name in names if name and name not in robot["arm_joints"]]


def hold(model, robot, home):
    """How far a joint is from home after two seconds that start there."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    step(model, data, 2.0)
    ends = [data.joint(name).qpos[0] for name in robot["arm_joints"]]
    return float(np.abs(np.subtract(ends, home["positions"])).max())


def grip(text, robot):
    """How far a box slips in the closed gripper in three seconds under gravity, and how far apart the pads are."""
    tool = np.asarray(robot["home"]["base_from_tool"])
    box = (
        f'<body name="held" pos="{" ".join(map(str, tool[:3, 3]))}"><freejoint/><geom type="box" condim="4"'
        f' friction="0.8 0.005 0.0001" size="{" ".join([str(BOX_M / 2)] * 3)}" mass="{BOX_KG}"/></body>'
    )
    # The home pose has no place for the box.
    text = re.sub("<keyframe>.*</keyframe>", "", text, flags=re.DOTALL)
    model = mujoco.MjModel.from_xml_string(text.replace("</worldbody>", box + "</worldbody>"))
    data = mujoco.MjData(model)
    targets = dict(zip(robot["arm_joints"], robot["home"]["positions"]))
    for name, position in targets.items():
        data.joint(name).qpos[0] = position
        data.actuator(name).ctrl[0] = position
    for finger in finger_joints(model, robot):
        data.joint(finger).qpos[0] = BOX_M / 2 + 0.001
    data.actuator(robot["gripper_joint"]).ctrl[0] = 0.0
    # The box floats while the fingers close.
    gravity = model.opt.gravity.copy()
    model.opt.gravity[:] = 0.0
    step(model, data, 0.5)
    model.opt.gravity[:] = gravity
    start = in_tool(data, robot)
    step(model, data, 3.0)
    gap = sum(data.joint(finger).qpos[0] for finger in finger_joints(model, robot))
    return float(np.linalg.norm(in_tool(data, robot) - start)), float(gap)


def in_tool(data, robot):
    """Where the box is in the frame of the tool."""
    site = data.site(robot["tool"])
    return site.xmat.reshape(3, 3).T @ (data.body("held").xpos - site.xpos)


def step(model, data, seconds):
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
