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
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from tabletopgen.env.cameras import Camera
from tabletopgen.env.judge import MANIFEST, judged_files
from tabletopgen.env.recorded_dataset import RecordedDataset
from tabletopgen.env.robot import RobotNames
from tabletopgen.env.start import ADDED, AS_DESCRIBED, CameraStart, Start

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
    shutil.copytree(execution / "mjcf", folder / MJCF, dirs_exist_ok=True)
    return described(folder, bundle, robot_names(report["execution"], motion), motion["objects"], report["task"], dataset)


def write_environment_like(
    folder: Path, bundle: Path, like: EnvironmentFolder, dataset: RecordedDataset, deviation: CameraStart | None = AS_DESCRIBED
) -> EnvironmentFolder:
    """Writes the folder of the same task in another bundle. The robot's files are those of the environment that it is
    like, and so are the cameras, which all deviate alike in each start; the dataset needs none. Without a deviation,
    cameras are those of the dataset, and deviate as in its episodes."""
    shutil.copytree(bundle / MJCF, folder / MJCF, dirs_exist_ok=True)
    for path in (like.folder / MJCF).iterdir():
        if path.is_file() and not (folder / MJCF / path.name).exists():
            shutil.copyfile(path, folder / MJCF / path.name)
    drawn = [one["name"] for one in dataset.entries[0]["record"]["sample"]["objects"]]
    objects = [name for name in drawn if not name.startswith(ADDED)]
    cameras = [(camera, deviation) for camera in like.cameras] if deviation is not None else None
    return described(folder, bundle, like.robot, objects, like.task, dataset, cameras)


def described(
    folder: Path,
    bundle: Path,
    names: RobotNames,
    objects: Sequence[str],
    task: Mapping[str, Any],
    dataset: RecordedDataset,
    cameras: Sequence[tuple[Camera, CameraStart]] | None = None,
) -> EnvironmentFolder:
    """Writes all but the files of MJCF, which are there. `cameras` are taken in place of those of the dataset, with
    how they deviate in each start."""
    entries = [entry for entry in dataset.entries if entry["record"]["task"]["goal"] == task["goal"]]
    if not entries:
        instructions = sorted({entry["task"] for entry in dataset.entries})
        raise ValueError(f"{dataset.folder} has no episode of the task {task['instruction']!r}, only of {instructions}")
    first = entries[0]["record"]
    if first["task"]["robot"] != names.name:
        raise ValueError(f"{dataset.folder} was recorded with the robot {first['task']['robot']!r}, not with {names.name!r}")
    stand_at(scene_with_robot(folder / MJCF), first["world_from_base"])
    for path in (*judged_files(bundle), MANIFEST):
        target = folder / SCENE / path
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(bundle / path, target)
    starts = [start_of(dataset, entry, len(names.joints)) for entry in entries]
    if cameras is not None:
        starts = [replace(start, cameras=tuple(deviation for _, deviation in cameras)) for start in starts]
    lines = [json.dumps(start.to_json()) + "\n" for start in starts]
    (folder / STARTS).write_text("".join(lines), encoding="utf-8")
    document = {
        "format": FORMAT,
        "task": task,
        "robot": asdict(names),
        "objects": list(objects),
        "fps": first["fps"],
        "cameras": first["cameras"] if cameras is None else [asdict(camera) for camera, _ in cameras],
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
