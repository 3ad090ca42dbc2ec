"""LeRobot 0.3.3, the last of PyPI that reads v2.1, opens it and reads every frame. Versions from 0.4 refuse v2.1.

openpi pins a revision of the same format by its Git hash, which PyPI does not have.
"""

import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset

import scene
from complaints import Complaints


def judge(folder) -> tuple:
    complaints = Complaints()
    for root in (folder / "lerobot-v2.1", folder / "lerobot-v2.1-images"):
        steps = {"action": [step / scene.FPS for step in range(3)]}
        dataset = LeRobotDataset(f"judge/{root.name}", root=root, video_backend="pyav", delta_timestamps=steps)
        complaints.equal("frames", len(dataset), scene.total_frames())
        index = 0
        for episode in range(scene.EPISODES):
            states, actions, last = scene.states(episode), scene.actions(episode), scene.frames(episode) - 1
            for t in range(last + 1):
                item, name = dataset[index], f"{root.name} episode {episode} frame {t}"
                complaints.equal(f"{name} state", item["observation.state"].numpy(), states[t])
                window = actions[np.clip([t, t + 1, t + 2], 0, last)]
                complaints.equal(f"{name} actions", item["action"].numpy(), window)
                complaints.equal(f"{name} task", item["task"], scene.TASKS[episode % 2])
                for camera in scene.CAMERAS:
                    tensor = item[f"observation.images.{camera}"].numpy().transpose(1, 2, 0)
                    pixels, is_exact = np.round(tensor * 255).astype(np.uint8), root.name.endswith("images")
                    complaints.image(f"{name} {camera}", pixels, scene.image(episode, t), is_exact)
                index += 1
    return complaints.facts(), complaints.texts
