"""The synthetic episodes anew, from the formulas that `crates/data/episodes/examples/synthetic/scene.rs` states.

Numbers are computed in float32 with the operations of the formulas, so that they compare bit by bit.
"""

import numpy as np

EPISODES, FPS, WIDTH_PX, HEIGHT_PX = 5, 15, 96, 64
SIDE_PX, STRIPE_PX, POINTS = 16, 8, 6
RED, GREEN, BLUE, GRAY, YELLOW = (220, 30, 40), (30, 200, 50), (40, 50, 210), (120, 120, 120), (230, 210, 40)
TASKS = ("push the square", "lift the square")
STATE_NAMES = ["joint_1_rad", "gripper_0_closed_1_open", "gripper_opening_m", "end_effector_x_m", "end_effector_y_m"]
STATE_NAMES += ["end_effector_z_m", *(f"end_effector_{axis}" for axis in ("qw", "qx", "qy", "qz"))]
STATE_NAMES += [f"end_effector_row{row}_column{column}" for column in (0, 1) for row in (0, 1, 2)]
ACTION_NAMES = ["joint_1_rad", "gripper_0_closed_1_open"]
SERVO_COMMAND_NAMES = ["joint_1_rad"]
CAMERAS = ("front", "wrist")
FAILED = 3
INTRINSICS = np.array([[100, 0, 48], [0, 100, 32], [0, 0, 1]], np.float32)


def frames(episode: int) -> int:
    return 17 + 6 * (episode % 3)


def total_frames() -> int:
    return sum(map(frames, range(EPISODES)))


def actions(episode: int) -> np.ndarray:
    return np.array([[(7 * t + 3 * episode) % 32 / 8 - 2, t % 2] for t in range(frames(episode))], np.float32)


def servo_commands(episode: int) -> np.ndarray:
    return np.minimum(actions(episode)[:, :1] + np.float32(0.25), np.float32(2))


def states(episode: int) -> np.ndarray:
    half = np.float32(0.5)
    joint, gripper = np.float32(0.1) * np.float32(episode), half
    rows = []
    for t, (to_joint, to_gripper) in enumerate(actions(episode)):
        along = np.float32(0.01) * np.float32(t)
        rows.append([joint, gripper, np.float32(0.08) * gripper, 0.3, along, 0.2, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0])
        joint = joint + half * (to_joint - joint)
        gripper = gripper + half * (to_gripper - gripper)
    return np.array(rows, np.float32)


def square(episode: int, t: int) -> tuple:
    """The rows and columns of the square."""
    left = (2 * t + 3 * episode) % (WIDTH_PX - SIDE_PX)
    return slice(40, 40 + SIDE_PX), slice(left, left + SIDE_PX)


def image(episode: int, t: int) -> np.ndarray:
    """Row x column x (red, green, blue); row 0 is the top."""
    pixels = np.empty((HEIGHT_PX, WIDTH_PX, 3), np.uint8)
    pixels[:] = GRAY
    for stripe, color in enumerate((RED, GREEN, BLUE)):
        pixels[stripe * STRIPE_PX : (stripe + 1) * STRIPE_PX] = color
    pixels[square(episode, t)] = YELLOW
    return pixels


def depth_m() -> np.ndarray:
    rows, columns = np.mgrid[0:HEIGHT_PX, 0:WIDTH_PX].astype(np.float32)
    depth = np.float32(0.5) + np.float32(0.001) * columns + np.float32(0.002) * rows
    depth[:, 0] = 0
    return depth


def instance_ids(episode: int, t: int, camera: str) -> np.ndarray:
    offset = 70_000 if camera == "wrist" else 0
    ids = np.full((HEIGHT_PX, WIDTH_PX), offset, np.uint32)
    ids[square(episode, t)] += 1
    return ids


def points(episode: int, t: int) -> tuple:
    """Coordinates, colors and instance ids of the points."""
    positions = [[np.float32(0.1) * np.float32(i), np.float32(0.01) * np.float32(t), 0.5] for i in range(POINTS)]
    colors = [[i, t, episode] for i in range(POINTS)]
    return np.array(positions, np.float32), np.array(colors, np.uint8), np.array([1000 * i + t for i in range(POINTS)])


def world_from_camera(t: int, camera: str) -> np.ndarray:
    x_m = 0.01 * t if camera == "wrist" else 0.0
    return np.array([[1, 0, 0, x_m], [0, -1, 0, 0], [0, 0, -1, 1], [0, 0, 0, 1]], np.float32)
