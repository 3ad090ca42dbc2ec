"""The folder of an environment: all that runs it but for the program, which decides when its task is done.

    environment.json    robot, objects, cameras, rate and task
    starts.jsonl        one start of an episode a line
    mjcf/               the scene with the robot where it stands in the episodes
    scene/              what the judge reads of the bundle
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tabletopgen.env.cameras import Camera
from tabletopgen.env.judge import MANIFEST, judged_files
from tabletopgen.env.recorded_dataset import RecordedDataset
from tabletopgen.env.robot import RobotNames
from tabletopgen.env.start import Start

FORMAT = "tabletopgen-environment/1"
DESCRIPTION, STARTS, MJCF, SCENE = "environment.json", "starts.jsonl", "mjcf", "scene"
FRAME = re.compile(r"<frame pos=[^>]*>")


@dataclass(frozen=True)
class EnvironmentFolder:
    """What a folder has."""

    folder: Path
    robot: RobotNames
    objects: tuple[str, ...]
    cameras: tuple[Camera, ...]
    fps: int
    task: Mapping[str, Any]
    starts: Sequence[Start]

    @property
    def mjcf(self) -> Path:
        """The file of the scene with the robot."""
        return scene_with_robot(self.folder / MJCF)

    @property
    def scene(self) -> Path:
        """The part of the bundle for the judge."""
        return self.folder / SCENE

    @classmethod
    def read(cls, folder: str | Path) -> EnvironmentFolder:
        folder = Path(folder)
        path = folder / DESCRIPTION
        if not path.is_file():
            raise ValueError(f"{folder} is no environment: it has no {DESCRIPTION}; write one by `python -m tabletopgen.env prepare`")
        document = json.loads(path.read_text(encoding="utf-8"))
        if document["format"] != FORMAT:
            raise ValueError(f"{path} has the format {document['format']!r}, where this version reads {FORMAT!r}; write the folder again")
        robot = document["robot"]
        with open(folder / STARTS, encoding="utf-8") as lines:
            starts = [Start.from_json(json.loads(line)) for line in lines]
        return cls(
            folder=folder,
            robot=RobotNames(**{**robot, "joints": tuple(robot["joints"])}),
            objects=tuple(document["objects"]),
            cameras=tuple(Camera.of_record(camera) for camera in document["cameras"]),
            fps=document["fps"],
            task=document["task"],
            starts=starts,
        )


def write_environment(folder: Path, bundle: Path, execution: Path, dataset: RecordedDataset) -> EnvironmentFolder:
    """Writes the folder of the task of an execution, with the starts of all episodes of that task in a dataset."""
    report = json.loads((execution / "execution.json").read_text(encoding="utf-8"))
    motion = json.loads((execution / "trajectory.json").read_text(encoding="utf-8"))
    names, task = robot_names(report["execution"], motion), report["task"]
    entries = [entry for entry in dataset.entries if entry["record"]["task"]["goal"] == task["goal"]]
    if not entries:
        instructions = sorted({entry["task"] for entry in dataset.entries})
        raise ValueError(f"{dataset.folder} has no episode of the task {task['instruction']!r}, only of {instructions}")
    first = entries[0]["record"]
    if first["task"]["robot"] != names.name:
        raise ValueError(f"{dataset.folder} was recorded with the robot {first['task']['robot']!r}, not with {names.name!r}")
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copytree(execution / "mjcf", folder / MJCF, dirs_exist_ok=True)
    stand_at(scene_with_robot(folder / MJCF), first["world_from_base"])
    for path in (*judged_files(bundle), MANIFEST):
        target = folder / SCENE / path
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(bundle / path, target)
    starts = [start_of(dataset, entry, len(names.joints)) for entry in entries]
    lines = [json.dumps(start.to_json()) + "\n" for start in starts]
    (folder / STARTS).write_text("".join(lines), encoding="utf-8")
    document = {
        "format": FORMAT,
        "task": task,
        "robot": asdict(names),
        "objects": motion["objects"],
        "fps": first["fps"],
        "cameras": first["cameras"],
    }
    (folder / DESCRIPTION).write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    return EnvironmentFolder.read(folder)


def robot_names(execution: Mapping[str, Any], motion: Mapping[str, Any]) -> RobotNames:
    """Names in the files that an execution wrote. All fingers move with the joint that has the servo."""
    name, variant = execution["robot"], execution.get("variant")
    prefix = f"{name}_{variant}_" if variant else f"{name}_"
    widest = max(motion["frames"], key=lambda frame: frame["opening_target_m"])
    opening_per_position = widest["opening_target_m"] / abs(widest["gripper_target"])
    return RobotNames(name, prefix, tuple(motion["joints"]), motion["gripper_joint"], opening_per_position)


def scene_with_robot(mjcf: Path) -> Path:
    """The one file of a folder of MJCF that has both."""
    found = list(mjcf.glob("scene_with_*.xml"))
    if len(found) != 1:
        raise ValueError(f"{mjcf} has {len(found)} files scene_with_*.xml, where one is expected; give a folder that `execute --out` wrote")
    return found[0]


def stand_at(mjcf: Path, world_from_base: Mapping[str, Any]) -> None:
    """Rewrites a file so that the base of the robot stands there."""
    x, y, z, w = world_from_base["rotation_xyzw"]
    position, quaternion = (" ".join(map(repr, values)) for values in (world_from_base["translation_m"], (w, x, y, z)))
    text, count = FRAME.subn(f'<frame pos="{position}" quat="{quaternion}">', mjcf.read_text(encoding="utf-8"))
    if count != 1:
        raise ValueError(f"{mjcf} has {count} frames, where the only one is that of the robot")
    mjcf.write_text(text, encoding="utf-8")


def start_of(dataset: RecordedDataset, entry: Mapping[str, Any], joints: int) -> Start:
    """The start of an episode: its record, and its first state."""
    (state,) = dataset.frames(entry["episode_index"], ["observation.state"]).values()
    quaternion = state[0, 2 * joints + 3 : 2 * joints + 7]
    return Start.of_record(entry["episode_index"], entry["record"], state[0, :joints], state[0, -2], quaternion)
