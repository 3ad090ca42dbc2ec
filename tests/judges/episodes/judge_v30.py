"""LeRobot of PyPI opens v3.0, reads every frame in both image modes, and reads windows of time."""

import json

import numpy as np
import pandas
from lerobot.datasets.lerobot_dataset import LeRobotDataset

import scene
from complaints import Complaints

FOLDERS = ("lerobot-v3.0", "lerobot-v3.0-images")


def judge(folder) -> tuple:
    complaints = Complaints()
    for root in (folder / name for name in FOLDERS):
        frames(root, complaints)
        windows(root, complaints)
        metadata(root, complaints)
    return complaints.facts(), complaints.texts


def opened(root, **options) -> LeRobotDataset:
    return LeRobotDataset(f"judge/{root.name}", root=root, video_backend="pyav", **options)


def frames(root, complaints: Complaints) -> None:
    dataset, is_exact = opened(root), root.name.endswith("images")
    complaints.equal("frames", len(dataset), scene.total_frames())
    complaints.equal("episodes", dataset.num_episodes, scene.EPISODES)
    complaints.equal("fps", dataset.fps, scene.FPS)
    complaints.equal("names of the state", dataset.features["observation.state"]["names"], scene.STATE_NAMES)
    complaints.equal("names of the action", dataset.features["action"]["names"], scene.ACTION_NAMES)
    index = 0
    for episode in range(scene.EPISODES):
        states, actions, commands = scene.states(episode), scene.actions(episode), scene.servo_commands(episode)
        for t in range(scene.frames(episode)):
            item, name = dataset[index], f"{root.name} episode {episode} frame {t}"
            complaints.equal(f"{name} state", item["observation.state"].numpy(), states[t])
            complaints.equal(f"{name} action", item["action"].numpy(), actions[t])
            complaints.equal(f"{name} servo command", item["servo_command"].numpy().reshape(-1), commands[t])
            complaints.equal(f"{name} task", item["task"], scene.TASKS[episode % 2])
            complaints.equal(f"{name} place", [int(item["episode_index"]), int(item["frame_index"])], [episode, t])
            complaints.equal(f"{name} time", np.float32(item["timestamp"]), np.float32(t / scene.FPS))
            for camera in scene.CAMERAS:
                pixels = pixels_of(item[f"observation.images.{camera}"])
                complaints.image(f"{name} {camera}", pixels, scene.image(episode, t), is_exact)
                pose = item[f"camera.{camera}.world_from_camera"].numpy().reshape(4, 4)
                complaints.equal(f"{name} {camera} pose", pose, scene.world_from_camera(t, camera))
                k = item[f"camera.{camera}.intrinsics"].numpy().reshape(3, 3)
                complaints.equal(f"{name} {camera} K", k, scene.INTRINSICS)
            index += 1


def windows(root, complaints: Complaints) -> None:
    """One image back, and three actions from now on; beyond the ends of an episode frames repeat and are marked."""
    steps = {"observation.images.front": (-1, 0), "observation.state": (-1, 0), "action": (0, 1, 2)}
    deltas = {key: [step / scene.FPS for step in of_key] for key, of_key in steps.items()}
    dataset, index = opened(root, delta_timestamps=deltas), 0
    for episode in range(scene.EPISODES):
        states, actions, last = scene.states(episode), scene.actions(episode), scene.frames(episode) - 1
        for t in range(last + 1):
            item, name = dataset[index], f"{root.name} window at episode {episode} frame {t}"
            times = {key: [t + step for step in of_key] for key, of_key in steps.items()}
            inside = {key: np.clip(of_key, 0, last) for key, of_key in times.items()}
            complaints.equal(f"{name} state", item["observation.state"].numpy(), states[inside["observation.state"]])
            complaints.equal(f"{name} action", item["action"].numpy(), actions[inside["action"]])
            for key, of_key in times.items():
                padded = [not 0 <= time <= last for time in of_key]
                complaints.equal(f"{name} {key} padding", item[f"{key}_is_pad"].tolist(), padded)
            for image, time in zip(item["observation.images.front"], inside["observation.images.front"], strict=True):
                expected, is_exact = scene.image(episode, int(time)), root.name.endswith("images")
                complaints.image(f"{name} image of {time}", pixels_of(image), expected, is_exact)
            index += 1


def pixels_of(tensor) -> np.ndarray:
    return np.round(tensor.numpy().transpose(1, 2, 0) * 255).astype(np.uint8)


def metadata(root, complaints: Complaints) -> None:
    tasks = pandas.read_parquet(root / "meta/tasks.parquet")
    complaints.equal(f"{root.name} tasks", list(tasks.index), list(scene.TASKS))
    statistics = json.loads((root / "meta/stats.json").read_text(encoding="utf-8"))
    columns = {"observation.state": scene.states, "action": scene.actions, "servo_command": scene.servo_commands}
    for key, of_episode in columns.items():
        rows = np.concatenate([of_episode(episode) for episode in range(scene.EPISODES)]).astype(np.float64)
        for statistic, expected in statistics_of(rows).items():
            complaints.close(f"{root.name} {key} {statistic}", statistics[key][statistic], expected, 1e-6)
    places = [(episode, t) for episode in range(scene.EPISODES) for t in range(scene.frames(episode))]
    images = np.concatenate([scene.image(*place).reshape(-1, 3) for place in places]) / 255
    for statistic, expected in statistics_of(images).items():
        actual = statistics["observation.images.front"][statistic]
        complaints.close(f"{root.name} front {statistic}", actual, expected.reshape(3, 1, 1), 1e-9)


def statistics_of(rows: np.ndarray) -> dict:
    statistics = {"min": rows.min(0), "max": rows.max(0), "mean": rows.mean(0), "std": rows.std(0)}
    for share in (1, 10, 50, 90, 99):
        statistics[f"q{share:02}"] = np.quantile(rows, share / 100, axis=0)
    return statistics
