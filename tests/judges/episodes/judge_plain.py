"""pyarrow and Pillow read the plain files."""

import json

import numpy as np
import pyarrow.parquet
from PIL import Image

import scene
from complaints import Complaints


def judge(folder) -> tuple:
    complaints, root = Complaints(), folder / "parquet-png"
    dataset = json.loads((root / "dataset.json").read_text(encoding="utf-8"))
    complaints.equal("frames", dataset["total_frames"], scene.total_frames())
    complaints.equal("names of the state", dataset["state_names"], scene.STATE_NAMES)
    complaints.equal("names of the action", dataset["action_names"], scene.ACTION_NAMES)
    complaints.equal("names of servo commands", dataset["servo_command_names"], scene.SERVO_COMMAND_NAMES)
    complaints.equal("declared depth", "millimeters" in dataset["conventions"]["depth"], True)
    millimeters = np.round(scene.depth_m() * np.float32(1000)).astype(int)
    for episode in range(scene.EPISODES):
        path = root / f"episodes/episode_{episode:06}"
        table = pyarrow.parquet.read_table(path / "frames.parquet")
        complaints.equal("state", np.array(table["observation.state"].to_pylist(), np.float32), scene.states(episode))
        complaints.equal("action", np.array(table["action"].to_pylist(), np.float32), scene.actions(episode))
        commands = np.array(table["servo_command"].to_pylist(), np.float32)
        complaints.equal("servo command", commands, scene.servo_commands(episode))
        wide = table["instance_ids.wrist"].to_pylist()
        for t in range(scene.frames(episode)):
            keys = ("point_cloud", "point_cloud_colors", "point_cloud_ids")
            for key, cloud in zip(keys, scene.points(episode, t), strict=True):
                found = np.array(table[key][t].as_py(), cloud.dtype).reshape(cloud.shape)
                complaints.equal(f"episode {episode} frame {t} {key}", found, cloud)
        complaints.equal("rows", len(wide), scene.frames(episode))
        for t in range(scene.frames(episode)):
            name = f"episode {episode} frame {t}"
            file = lambda camera, kind: np.array(Image.open(path / camera / f"{kind}_{t:06}.png"))  # noqa: B023, E731
            for camera in scene.CAMERAS:
                complaints.image(f"{name} {camera}", file(camera, "rgb"), scene.image(episode, t), is_exact=True)
            complaints.equal(f"{name} depth", file("front", "depth_mm").astype(int), millimeters)
            ids = file("front", "instance_ids").astype(np.uint32)
            complaints.equal(f"{name} ids", ids, scene.instance_ids(episode, t, "front"))
            ids = np.array(wide[t], np.uint32).reshape(scene.HEIGHT_PX, scene.WIDTH_PX)
            complaints.equal(f"{name} ids of the wrist", ids, scene.instance_ids(episode, t, "wrist"))
    return complaints.facts(), complaints.texts
