"""MuJoCo reads robot.xml and finds the same poses; the robot stays at home for two seconds, holds a box of 40 mm and
100 g in its gripper for three, and presses a thin box with the forces that the gripper's target asks for."""

import re

import mujoco
import numpy as np

from poses import Largest, pose_of

# How far a joint at rest may be from its target, and how far the box may slip.
HOLDING_RAD = 2e-3
SLIP_M = 1e-3
BOX_M, BOX_KG = 0.04, 0.1
# The thickness of a coin or a spoon, and the share of a force that may be missing.
THIN_M, THIN_FORCE_SHARE = 0.004, 0.1


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
    for key in ("grip_force_n", "max_force_n"):
        forces = press(text, robot, robot[key])
        facts[f"thin_{key}"] = forces
        if not np.allclose(forces, robot[key], rtol=THIN_FORCE_SHARE):
            complaints.append(f"the fingers press {THIN_M} m with {forces} N instead of {robot[key]} N")
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
    model, data = around_box(text, robot, [BOX_M] * 3)
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


def press(text, robot, force_n):
    """The force of each finger on a box of 4 mm, with the target that asks for a force."""
    model, data = around_box(text, robot, [0.02, THIN_M, 0.02])
    model.opt.gravity[:] = 0.0
    servo = model.actuator(robot["gripper_joint"])
    fingers = finger_joints(model, robot)
    # One servo pulls all fingers, and its stiffness makes the force of what the target is ahead of them.
    lead = len(fingers) * force_n / servo.gainprm[0]
    for _ in range(round(1.0 / model.opt.timestep)):
        data.ctrl[servo.id] = data.joint(robot["gripper_joint"]).qpos[0] - lead
        mujoco.mj_step(model, data)
    return [pressing(model, data, model.jnt_bodyid[model.joint(finger).id]) for finger in fingers]


def pressing(model, data, finger):
    """The sum of the normal forces between a finger and the box, newtons."""
    total, force, held = 0.0, np.zeros(6), model.body("held").id
    for number, contact in enumerate(data.contact):
        if {model.geom_bodyid[geom] for geom in contact.geom} == {finger, held}:
            mujoco.mj_contactForce(model, data, number, force)
            total += force[0]
    return float(total)


def around_box(text, robot, size_m):
    """The robot at home, its fingers right beside a box of this size between them; y is where they close."""
    tool = np.asarray(robot["home"]["base_from_tool"])
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, tool[:3, :3].flatten())
    place, turn, half = (" ".join(map(str, v)) for v in (tool[:3, 3], quaternion, np.array(size_m) / 2))
    box = (
        f'<body name="held" pos="{place}" quat="{turn}"><freejoint/><geom type="box" condim="4"'
        f' friction="0.8 0.005 0.0001" size="{half}" mass="{BOX_KG}"/></body>'
    )
    # The home pose has no place for the box.
    text = re.sub("<keyframe>.*</keyframe>", "", text, flags=re.DOTALL)
    model = mujoco.MjModel.from_xml_string(text.replace("</worldbody>", box + "</worldbody>"))
    data = mujoco.MjData(model)
    for name, position in zip(robot["arm_joints"], robot["home"]["positions"]):
        data.joint(name).qpos[0] = position
        data.actuator(name).ctrl[0] = position
    for finger in finger_joints(model, robot):
        data.joint(finger).qpos[0] = size_m[1] / 2 + 0.001
    return model, data


def in_tool(data, robot):
    """Where the box is in the frame of the tool."""
    site = data.site(robot["tool"])
    return site.xmat.reshape(3, 3).T @ (data.body("held").xpos - site.xpos)


def step(model, data, seconds):
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
