"""LeRobot v2.1 by its documented layout: pyarrow reads the tables, PyAV decodes the videos."""

import io
import json

import av
import numpy as np
import pyarrow.parquet
from PIL import Image

import scene
from complaints import Complaints

KEYS = ("timestamp", "frame_index", "episode_index", "index", "task_index")


def judge(folder) -> tuple:
    complaints = Complaints()
    for root in (folder / "lerobot-v2.1", folder / "lerobot-v2.1-images"):
        info = json.loads((root / "meta/info.json").read_text(encoding="utf-8"))
        complaints.equal("version", info["codebase_version"], "v2.1")
        complaints.equal("frames", info["total_frames"], scene.total_frames())
        complaints.equal("episodes of the split", info["splits"], {"train": f"0:{scene.EPISODES}"})
        metadata(root, complaints)
        first = 0
        for episode in range(scene.EPISODES):
            path = info["data_path"].format(episode_chunk=0, episode_index=episode)
            rows(root / path, info, episode, first, complaints)
            for camera in scene.CAMERAS if info["video_path"] else ():
                key = f"observation.images.{camera}"
                path = info["video_path"].format(episode_chunk=0, video_key=key, episode_index=episode)
                video(root / path, episode, complaints)
            first += scene.frames(episode)
    return complaints.facts(), complaints.texts


def metadata(root, complaints: Complaints) -> None:
    lines = {
        name: [json.loads(line) for line in (root / f"meta/{name}.jsonl").read_text(encoding="utf-8").splitlines()]
        for name in ("tasks", "episodes", "episodes_stats")
    }
    tasks = [{"task_index": i, "task": task} for i, task in enumerate(scene.TASKS)]
    complaints.equal("tasks", lines["tasks"], tasks)
    numbers = range(scene.EPISODES)
    episodes = [{"episode_index": e, "tasks": [scene.TASKS[e % 2]], "length": scene.frames(e)} for e in numbers]
    complaints.equal("episodes", lines["episodes"], episodes)
    for episode, line in enumerate(lines["episodes_stats"]):
        complaints.equal("episode of statistics", line["episode_index"], episode)
        for key, expected in (("observation.state", scene.states(episode)), ("action", scene.actions(episode))):
            of_key = line["stats"][key]
            complaints.close(f"mean of {key}", of_key["mean"], expected.astype(float).mean(0), 1e-6)
            complaints.equal(f"largest of {key}", np.array(of_key["max"], np.float32), expected.max(0))
            complaints.equal(f"count of {key}", of_key["count"], [scene.frames(episode)])
    modality = json.loads((root / "meta/modality.json").read_text(encoding="utf-8"))
    complaints.equal("gripper of the state", modality["state"]["gripper"], {"start": 1, "end": 2})
    complaints.equal("rotation of the state", modality["state"]["end_effector_rotation"], {"start": 6, "end": 10})
    complaints.equal("six numbers of the state", modality["state"]["end_effector_rotation_6d"], {"start": 10, "end": 16})
    complaints.equal("arm of the action", modality["action"]["arm"], {"start": 0, "end": 1})
    complaints.equal("video", modality["video"]["wrist"], {"original_key": "observation.images.wrist"})


def rows(path, info: dict, episode: int, first: int, complaints: Complaints) -> None:
    table = pyarrow.parquet.read_table(path)
    expected = {key for key, feature in info["features"].items() if feature["dtype"] != "video"}
    complaints.equal("columns", set(table.column_names), expected)
    frames = scene.frames(episode)
    column = lambda key: np.array(table[key].to_pylist())  # noqa: E731
    name = f"{path.parents[2].name} episode {episode}"
    complaints.equal(f"{name} state", column("observation.state").astype(np.float32), scene.states(episode))
    complaints.equal(f"{name} action", column("action").astype(np.float32), scene.actions(episode))
    complaints.equal(f"{name} servo command", column("servo_command").astype(np.float32), scene.servo_commands(episode))
    steps = np.arange(frames)
    for key, values in zip(KEYS[1:], (steps, steps * 0 + episode, steps + first, steps * 0 + episode % 2), strict=True):
        complaints.equal(f"{name} {key}", column(key), values)
    times = (steps / scene.FPS).astype(np.float32)
    complaints.equal(f"{name} timestamp", column("timestamp").astype(np.float32), times)
    for camera in scene.CAMERAS:
        key = f"observation.images.{camera}"
        if info["features"][key]["dtype"] == "image":
            for t, file in enumerate(table[key].to_pylist()):
                pixels = np.array(Image.open(io.BytesIO(file["bytes"])))
                complaints.image(f"{name} {camera} frame {t}", pixels, scene.image(episode, t), is_exact=True)


def video(path, episode: int, complaints: Complaints) -> None:
    with av.open(path) as container:
        stream = container.streams.video[0]
        complaints.equal("codec", stream.codec_context.name, "h264")
        complaints.equal("pixel format", stream.codec_context.pix_fmt, "yuv420p")
        complaints.equal("rate", stream.average_rate, scene.FPS)
        frames = list(container.decode(stream))
    complaints.equal(f"frames of {path.name}", len(frames), scene.frames(episode))
    complaints.equal("first frame", frames[0].key_frame, True)
    keys = [t for t, frame in enumerate(frames) if frame.key_frame] + [len(frames)]
    complaints.equal("key frames within ten", max(np.diff(keys)) <= 10, True)
    for t, frame in enumerate(frames):
        complaints.equal("time", frame.pts * frame.time_base * scene.FPS, t)
        complaints.image(f"{path.name} frame {t}", frame.to_ndarray(format="rgb24"), scene.image(episode, t), False)
