"""LeRobot, PyAV, pyarrow, h5py and Pillow read a recorded dataset, and all of its formats say the same.

    recorded.py DATASET [--train STEPS]

DATASET is what `tabletopgen episodes --format lerobot-v3.0,lerobot-v3.0-images,lerobot-v2.1,robomimic,parquet-png`
wrote. The PNG files are what was rendered; LeRobot's decoded video must equal them within the error of the codec,
everything else exactly. With --train, LeRobot's own training runs so many steps. Prints one line of JSON; exit code 1
with a complaint.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import av
import h5py
import numpy as np
import pyarrow.parquet as parquet
from PIL import Image

from complaints import Complaints

# Actions that equal states in this share of the frames would be copies of them.
MAX_EQUAL_SHARE = 0.5
MAX_IDLE_FRAMES = 4
QUANTITIES = ("position", "velocity", "acceleration", "jerk")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path)
    parser.add_argument("--train", type=int, default=0)
    given = parser.parse_args()
    complaints = Complaints()
    episodes = plain(given.dataset / "parquet-png")
    for name in ("lerobot-v3.0", "lerobot-v3.0-images"):
        lerobot(given.dataset / name, episodes, complaints)
    version_two(given.dataset / "lerobot-v2.1", episodes, complaints)
    robomimic(given.dataset / "robomimic" / "dataset.hdf5", episodes, complaints)
    previews(given.dataset / "lerobot-v3.0", episodes, complaints)
    for number, episode in enumerate(episodes):
        sensible(f"episode {number}", episode, complaints)
        rotations(f"episode {number}", episode, episodes[0], complaints)
        within_limits(f"episode {number}", episode, complaints)
    for card in sorted(given.dataset.glob("*/README.md")):
        shares_of_card(card, episodes, complaints)
    trained = train(given.dataset / "lerobot-v3.0", given.train) if given.train else None
    print(json.dumps({**complaints.facts(), "trained_loss": trained, "complaints": complaints.texts}))
    return int(bool(complaints.texts))


def plain(root: Path) -> list:
    described = json.loads((root / "dataset.json").read_text())["description"]
    cameras = [camera["name"] for camera in described["cameras"]]
    episodes = []
    for folder in sorted((root / "episodes").iterdir()):
        frames = parquet.read_table(folder / "frames.parquet")
        kinds = ("state", "action", "servo_command")
        names = {kind: [element["name"] for element in described[kind]] for kind in kinds}
        limits = {kind: [element.get("limits") for element in described[kind]] for kind in kinds}
        episodes.append(
            {
                "names": names,
                "limits": limits,
                "fps": described["fps"],
                "state": np.array(frames["observation.state"].to_pylist(), np.float32),
                "action": np.array(frames["action"].to_pylist(), np.float32),
                "servo_command": np.array(frames["servo_command"].to_pylist(), np.float32),
                "clouds": clouds(folder, frames, cameras),
                "images": {camera: sorted((folder / camera).glob("rgb_*.png")) for camera in cameras},
            }
        )
    return episodes


def clouds(folder: Path, frames, cameras: list) -> dict:
    """The points of some frames, and what each camera has where they are seen; nothing of a dataset without clouds."""
    if "point_cloud" not in frames.column_names:
        return {}
    found = {}
    for t in sorted({0, len(frames) // 2, len(frames) - 1}):
        numbers = [np.array(frames[key][t].as_py()) for key in ("point_cloud", "point_cloud_colors", "point_cloud_ids")]
        positions, colors = numbers[0].astype(np.float32).reshape(-1, 3), numbers[1].astype(np.uint8).reshape(-1, 3)
        points = (positions, colors, numbers[2].astype(np.uint16))
        found[t] = {"points": points, "seen": [seen(folder, frames, camera, t, points) for camera in cameras]}
    return found


def seen(folder: Path, frames, camera: str, t: int, points: tuple) -> np.ndarray:
    """Which points are what the camera has at the pixel where they are: its depth, color and instance."""
    k = np.array(frames[f"camera.{camera}.intrinsics"][t].as_py()).reshape(3, 3)
    pose = np.array(frames[f"camera.{camera}.world_from_camera"][t].as_py()).reshape(4, 4)
    in_camera = (points[0] - pose[:3, 3]) @ pose[:3, :3]
    depth_m = in_camera[:, 2]
    ahead = np.where(depth_m > 1e-6, depth_m, 1.0)
    pixels = np.floor((in_camera @ k.T)[:, :2] / ahead[:, None]).astype(int)
    image = pixels_of(folder / camera / f"rgb_{t:06}.png")
    inside = (depth_m > 1e-6) & (pixels >= 0).all(1) & (pixels < image.shape[1::-1]).all(1)
    column, row = np.where(inside[:, None], pixels, 0).T
    depth_mm, ids = (np.array(Image.open(folder / camera / f"{kind}_{t:06}.png")) for kind in ("depth_mm", "instance_ids"))
    at_depth = np.abs(depth_mm[row, column] / 1000 - depth_m) < 0.001
    return inside & at_depth & (image[row, column] == points[1]).all(1) & (ids[row, column] == points[2])


def pixels_of(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path).convert("RGB"))


def lerobot(root: Path, episodes: list, complaints: Complaints) -> None:
    """Every frame, and windows of time with images, states and actions."""
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    fps, is_exact = episodes[0]["fps"], root.name.endswith("images")
    camera = next(iter(episodes[0]["images"]))
    steps = {f"observation.images.{camera}": (-1, 0), "observation.state": (0,), "action": (0, 1, 2)}
    deltas = {key: [step / fps for step in of_key] for key, of_key in steps.items()}
    options = {"root": root, "video_backend": "pyav"}
    whole = LeRobotDataset(f"judge/{root.name}", **options)
    windowed = LeRobotDataset(f"judge/{root.name}", delta_timestamps=deltas, **options)
    complaints.equal("frames", len(whole), sum(len(episode["state"]) for episode in episodes))
    index = 0
    for number, episode in enumerate(episodes):
        last = len(episode["state"]) - 1
        for t in range(last + 1):
            item, name = whole[index], f"{root.name} episode {number} frame {t}"
            complaints.equal(f"{name} state", item["observation.state"].numpy(), episode["state"][t])
            complaints.equal(f"{name} action", item["action"].numpy(), episode["action"][t])
            complaints.equal(f"{name} servo command", item["servo_command"].numpy(), episode["servo_command"][t])
            complaints.equal(f"{name} place", [int(item["episode_index"]), int(item["frame_index"])], [number, t])
            for of, paths in episode["images"].items():
                pixels = np.round(item[f"observation.images.{of}"].numpy().transpose(1, 2, 0) * 255).astype(np.uint8)
                decoded(f"{name} {of}", pixels, pixels_of(paths[t]), is_exact, complaints)
            if t % 7 == 0:
                actions = np.clip([t, t + 1, t + 2], 0, last)
                found = windowed[index]["action"].numpy()
                complaints.equal(f"{name} window", found, episode["action"][actions])
            index += 1


def decoded(name: str, found: np.ndarray, expected: np.ndarray, is_exact: bool, complaints: Complaints) -> None:
    """Textures have no flat regions, so that the mean error alone bounds what the codec may do."""
    if is_exact:
        complaints.equal(name, found, expected)
        return
    complaints.checks += 1
    rms = float(np.sqrt(((found.astype(float) - expected.astype(float)) ** 2).mean()))
    complaints.worst_rms = max(complaints.worst_rms, rms)
    if rms > 10.0:
        complaints.texts.append(f"{name}: an error of {rms:.1f} rms")


def version_two(root: Path, episodes: list, complaints: Complaints) -> None:
    """Files of v2.1 by pyarrow and PyAV; LeRobot 0.4 does not open them."""
    information = json.loads((root / "meta/info.json").read_text())
    complaints.equal("version", information["codebase_version"], "v2.1")
    for number, episode in enumerate(episodes):
        frames = parquet.read_table(root / f"data/chunk-000/episode_{number:06d}.parquet")
        found = np.array(frames["action"].to_pylist(), np.float32)
        complaints.equal(f"v2.1 episode {number} actions", found, episode["action"])
        found = np.array(frames["servo_command"].to_pylist(), np.float32)
        complaints.equal(f"v2.1 episode {number} servo commands", found, episode["servo_command"])
        for camera, paths in episode["images"].items():
            path = root / f"videos/chunk-000/observation.images.{camera}/episode_{number:06d}.mp4"
            with av.open(str(path)) as video:
                count = sum(1 for _ in video.decode(video=0))
            complaints.equal(f"v2.1 episode {number} frames of {camera}", count, len(paths))


def robomimic(path: Path, episodes: list, complaints: Complaints) -> None:
    with h5py.File(path) as file:
        complaints.equal("demos", len(file["data"]), len(episodes))
        for number, episode in enumerate(episodes):
            demo = file[f"data/demo_{number}"]
            complaints.equal(f"demo {number} samples", int(demo.attrs["num_samples"]), len(episode["state"]))
            complaints.equal(f"demo {number} targets", demo["action_targets"][:], episode["action"])
            complaints.equal(f"demo {number} servo commands", demo["servo_commands"][:], episode["servo_command"])
            inside = float(np.abs(demo["actions"][:]).max()) <= 1.0
            complaints.equal(f"demo {number} actions are within [-1, 1]", inside, True)
            for t, points in episode["clouds"].items():
                keys = ("point_cloud", "point_cloud_colors", "point_cloud_ids")
                for key, expected in zip(keys, points["points"], strict=True):
                    complaints.equal(f"demo {number} frame {t} {key}", demo["obs"][key][t], expected)


def previews(root: Path, episodes: list, complaints: Complaints) -> None:
    """The small video of each episode has all of its frames."""
    for number, episode in enumerate(episodes):
        with av.open(str(root / f"strips/chunk-000/episode_{number:06d}.mp4")) as video:
            count = sum(1 for _ in video.decode(video=0))
        complaints.equal(f"frames of preview {number}", count, len(episode["state"]))


def sensible(name: str, episode: dict, complaints: Complaints) -> None:
    """Actions are no copies of states, the gripper closes and opens, and no end is idle."""
    states, actions = episode["state"], episode["action"]
    joints = [index for index, label in enumerate(episode["names"]["action"]) if label.startswith("joint")]
    equal = np.isclose(states[:, joints], actions[:, joints], atol=1e-6).all(1).mean()
    complaints.equal(f"{name} actions are no copies", bool(equal < MAX_EQUAL_SHARE), True)
    moving = np.abs(np.diff(actions[:, joints], axis=0)).max(1) > 1e-3
    moving |= np.abs(np.diff(actions[:, -2])) > 1e-4
    complaints.equal(f"{name} begins with a motion", bool(moving[:MAX_IDLE_FRAMES].any()), True)
    complaints.equal(f"{name} ends soon after one", bool(moving[-MAX_IDLE_FRAMES - 1 :].any()), True)
    share = states[:, -1]
    complaints.equal(f"{name} gripper: 1 is open", bool(share[0] > 0.9 and share.min() < 0.9), True)
    for t, points in episode["clouds"].items():
        share = float(np.any(points["seen"], axis=0).mean())
        complaints.equal(f"{name} frame {t}: points are what a camera shows there", share > 0.99, True)
    quaternions = states[:, [episode["names"]["state"].index(f"end_effector_q{axis}") for axis in "wxyz"]]
    complaints.close(f"{name} quaternions", np.linalg.norm(quaternions, axis=1), np.ones(len(states)), 1e-5)


def rotations(name: str, episode: dict, first: dict, complaints: Complaints) -> None:
    """Quaternions do not jump to their negatives, and the six numbers are the columns of their matrices."""
    quaternions = {kind: columns(episode, kind, [f"end_effector_q{axis}" for axis in "wxyz"]) for kind in ("state", "action")}
    dots = {
        "from frame to frame": (quaternions["state"][1:] * quaternions["state"][:-1]).sum(1),
        "from action to action": (quaternions["action"][1:] * quaternions["action"][:-1]).sum(1),
        "between state and action": (quaternions["state"] * quaternions["action"]).sum(1),
        "between the first frames of episodes": quaternions["state"][:1] @ columns(
            first, "state", [f"end_effector_q{axis}" for axis in "wxyz"])[0],
    }
    for pair, products in dots.items():
        complaints.equal(f"{name} quaternions of other signs {pair}", int((products < 0).sum()), 0)
    six = [f"end_effector_row{row}_column{column}" for column in (0, 1) for row in (0, 1, 2)]
    for kind, (w, x, y, z) in ((kind, of_kind.T) for kind, of_kind in quaternions.items()):
        first_column = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]
        second_column = [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)]
        expected = np.stack([*first_column, *second_column], 1)
        complaints.close(f"{name} six numbers of the {kind}", columns(episode, kind, six), expected, 1e-5)


def columns(episode: dict, kind: str, names: list) -> np.ndarray:
    return episode[kind][:, [episode["names"][kind].index(name) for name in names]].astype(float)


def within_limits(name: str, episode: dict, complaints: Complaints) -> None:
    """Actions, and their differences over time, are within the robot's limits, but for the rounding of float32."""
    limited = [name for name, limits in zip(episode["names"]["action"], episode["limits"]["action"], strict=True) if limits]
    complaints.equal(f"{name} numbers with limits", limited, episode["names"]["servo_command"])
    for number, shares in zip(limited, shares_of(episode, "action"), strict=True):
        for quantity, share, slack in zip(QUANTITIES, shares, (0.0, 0.001, 0.005, 0.02), strict=True):
            complaints.equal(f"{name} {number} within its limit of {quantity}", bool(share <= 1.0 + slack), True)


def shares_of(episode: dict, kind: str) -> np.ndarray:
    """The largest shares of the limits, by number and quantity."""
    rows = []
    for values, limits in zip(episode[kind].astype(float).T, episode["limits"][kind], strict=True):
        if not limits:
            continue
        low, high = limits["position"]
        row = [np.abs(values - (low + high) / 2).max() / ((high - low) / 2)]
        for order, quantity in enumerate(QUANTITIES[1:], 1):
            differences = np.diff(values, order) * float(episode["fps"]) ** order
            row.append(np.abs(differences).max(initial=0.0) / limits[quantity])
        rows.append(row)
    return np.array(rows)


def shares_of_card(card: Path, episodes: list, complaints: Complaints) -> None:
    """The card states what the numbers use of the limits."""
    for kind in ("action", "servo_command"):
        expected = 100 * np.max([shares_of(episode, kind) for episode in episodes], axis=0)
        lines = [line for line in card.read_text(encoding="utf-8").splitlines() if line.startswith(f"| `{kind}` |") and "%" in line]
        found = [[float(cell.strip(" %")) for cell in line.split("|")[3:7]] for line in lines]
        complaints.close(f"{card.parent.name} card: shares of limits of {kind}", found, expected, 0.06)


def train(root: Path, steps: int) -> float:
    """The loss after so many steps of LeRobot's own training loop, of a small policy on a CPU."""
    with tempfile.TemporaryDirectory() as folder:
        words = [
            "--policy.type=act", "--policy.device=cpu", "--policy.push_to_hub=false", "--policy.chunk_size=10",
            "--policy.n_action_steps=10", "--policy.dim_model=64", "--policy.dim_feedforward=128", "--policy.n_heads=4",
            "--policy.pretrained_backbone_weights=null", f"--dataset.root={root}", "--dataset.repo_id=judge/recorded",
            "--dataset.video_backend=pyav", f"--steps={steps}", "--batch_size=2", "--num_workers=0", "--log_freq=10",
            f"--output_dir={folder}/run", "--wandb.enable=false", "--save_checkpoint=false", "--eval_freq=0",
        ]
        program = Path(sys.executable).with_name("lerobot-train")
        done = subprocess.run([program, *words], capture_output=True, text=True)
        text = done.stdout + done.stderr
        losses = [word.split(":")[1] for word in text.split() if word.startswith("loss:")]
        if done.returncode != 0 or not losses:
            raise SystemExit(f"lerobot-train: {text[-2000:]}")
        return float(losses[-1])


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as cache:
        # Nothing is fetched, and nothing outlives the run.
        os.environ.update(HF_HUB_OFFLINE="1", HF_HOME=cache, HF_DATASETS_CACHE=cache, HF_LEROBOT_HOME=cache)
        sys.exit(main())
