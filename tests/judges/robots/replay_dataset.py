"""MuJoCo repeats recorded episodes from their servo commands or actions alone, and the program decides the tasks in its
poses.

    replay_dataset.py PROGRAM BUNDLE EXECUTION DATASET [COLUMN]

EXECUTION is what `PROGRAM execute --bundle BUNDLE --out EXECUTION` wrote with the robot of the dataset: its MJCF is
used. DATASET has the format `parquet-png`. Base, objects, masses and frictions are those of the episode's record; the
servos get the recorded numbers of COLUMN (`servo_command`, or `action`), each reached straight within a frame; nothing
else is replayed. Prints one line of JSON for each episode, and ends with exit code 0 whatever MuJoCo found.
"""

import json
import re
import sys
from pathlib import Path

import mujoco
import numpy as np
import pyarrow.parquet as parquet

from replay import REST_S, Scene, judged


class Episode(Scene):
    """The robot and the objects as the episode begins."""

    def __init__(self, execution: Path, record: dict, states: np.ndarray, actions: np.ndarray, names: list):
        verdict = json.loads((execution / "execution.json").read_text())["execution"]
        motion = json.loads((execution / "trajectory.json").read_text())
        robot = verdict["robot"]
        self.prefix = f"{robot}_"
        self.model = with_sample(execution / "mjcf" / f"scene_with_{robot}.xml", record)
        self.data = mujoco.MjData(self.model)
        self.objects = [name for name, _ in record["initial_poses"] if is_of_scene(name)]
        self.joints, self.gripper = motion["joints"], motion["gripper_joint"]
        fps = record["fps"]
        # An action is reached at the end of its frame; before the first the servos hold what is measured.
        self.times_s = np.arange(len(actions) + 1) / fps
        self.end_s = float(self.times_s[-1])
        column = {name: index for index, name in enumerate(names)}
        held = states[0, : len(self.joints)]
        targets = {joint: np.concatenate([[held[k]], actions[:, column[joint]]]) for k, joint in enumerate(self.joints)}
        opening = np.concatenate([[states[0, -2]], actions[:, column["gripper_opening"]]])
        self.targets = {**targets, self.gripper: opening / opening_per_position(motion)}
        self.place(record, held, float(states[0, -2]) / opening_per_position(motion))

    def place(self, record: dict, positions, finger_m: float) -> None:
        for name, pose in record["initial_poses"]:
            if not is_of_scene(name):
                continue
            joint = self.model.joint(self.model.body_jntadr[self.model.body(name).id])
            x, y, z, w = pose["rotation_xyzw"]
            self.data.joint(joint.name).qpos[:] = [*pose["translation_m"], w, x, y, z]
        for name, position in zip(self.joints, positions, strict=True):
            self.data.joint(self.prefix + name).qpos[0] = position
        arm = {self.prefix + name for name in self.joints}
        for number in range(self.model.njnt):
            name = self.model.joint(number).name
            if name.startswith(self.prefix) and name not in arm:
                low, high = self.model.joint(number).range
                self.data.joint(name).qpos[0] = max(finger_m, 0.0) * (1.0 if high > -low else -1.0)
        mujoco.mj_forward(self.model, self.data)


def is_of_scene(name: str) -> bool:
    """Whether the bundle has it. Distractors of an episode are not in its MJCF; MuJoCo's episode is without them."""
    return not name.startswith("distractor_")


def opening_per_position(motion: dict) -> float:
    """Both fingers move by the position of the servo's joint."""
    wide = max(motion["frames"], key=lambda frame: frame["opening_target_m"])
    return wide["opening_target_m"] / abs(wide["gripper_target"])


def with_sample(path: Path, record: dict):
    """The model with the base, the masses and the frictions of the episode, without the objects that are absent."""
    spec = mujoco.MjSpec.from_file(str(with_base(path, record["world_from_base"])))
    for key in list(spec.keys):
        spec.delete(key)
    present = {name for name, _ in record["initial_poses"] if is_of_scene(name)}
    drawn = {sample["name"]: sample for sample in record["sample"]["objects"]}
    for body in list(spec.worldbody.bodies):
        if body.name in drawn and body.name not in present:
            spec.delete(body)
    model = spec.compile()
    for name in present:
        sample, body = drawn[name], model.body(name).id
        model.body_mass[body] *= sample["mass_factor"]
        model.body_inertia[body] *= sample["mass_factor"]
        for geom in range(model.body_geomadr[body], model.body_geomadr[body] + model.body_geomnum[body]):
            model.geom_friction[geom, 0] *= sample["friction_factor"]
    return model


def with_base(path: Path, pose: dict) -> Path:
    """The file of the robot in the scene with the base of the episode, beside the one with that of the execution."""
    x, y, z, w = pose["rotation_xyzw"]
    numbers = [" ".join(map(repr, values)) for values in (pose["translation_m"], (w, x, y, z))]
    frame = f'<frame pos="{numbers[0]}" quat="{numbers[1]}">'
    text, count = re.subn(r"<frame pos=[^>]*>", frame, path.read_text())
    if count != 1:
        raise SystemExit(f"{path} has {count} frames, where one is that of the robot")
    moved = path.with_name(f"moved_{path.name}")
    moved.write_text(text)
    return moved


def main(program: str, bundle: str, execution: Path, dataset: Path, column: str = "servo_command") -> int:
    root = dataset / "parquet-png"
    described = json.loads((root / "dataset.json").read_text())["description"]
    names = [element["name"] for element in described[column]]
    for line in (root / "records.jsonl").read_text().splitlines():
        entry = json.loads(line)
        index = entry["episode_index"]
        frames = parquet.read_table(root / "episodes" / f"episode_{index:06d}" / "frames.parquet")
        states, actions = (np.stack(frames[key].to_pylist()) for key in ("observation.state", column))
        episode = Episode(execution, entry["record"], states, actions, names)
        while episode.data.time < episode.end_s + REST_S:
            episode.step()
        with_task = execution / f"episode_{index:06d}"
        with_task.mkdir(exist_ok=True)
        (with_task / "task.json").write_text(json.dumps(entry["record"]["task"]))
        verdict = judged(program, bundle, with_task, episode.state())
        print(json.dumps({"episode": index, "success": entry["success"], **verdict}), flush=True)
    return 0


if __name__ == "__main__":
    if len(sys.argv) not in (5, 6):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:3], *map(Path, sys.argv[3:5]), *sys.argv[5:]))
