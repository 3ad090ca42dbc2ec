"""MuJoCo repeats executions from their joint targets alone, and the program decides the tasks in its poses.

    replay.py PROGRAM BUNDLE FOLDER...

Each folder is what `PROGRAM execute --bundle BUNDLE --out FOLDER` wrote. The robot starts where the motion starts; its
servos get the recorded targets, interpolated; nothing else is replayed. Prints one line of JSON for each folder. The
exit code is 1 where MuJoCo's end does not satisfy the goal.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import mujoco
import numpy as np

# After the last target the scene comes to rest in this time.
REST_S = 1.0
# Contacts with less force do not carry anything.
TOUCH_N = 1e-3


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("bundle")
    parser.add_argument("folders", nargs="+", type=Path)
    given = parser.parse_args()
    failed = False
    for folder in given.folders:
        verdict = judged(given.program, given.bundle, folder, replayed(folder))
        failed |= not verdict["reached"]
        print(json.dumps({"folder": str(folder), **verdict}), flush=True)
    return int(failed)


def replayed(folder: Path) -> dict:
    """The state of the scene after the motion, in MuJoCo."""
    scene = Scene(folder)
    while scene.data.time < scene.end_s + REST_S:
        scene.step()
    return scene.state()


class Scene:
    """The robot in the scene, at the start of the recorded motion."""

    def __init__(self, folder: Path):
        execution = json.loads((folder / "execution.json").read_text())["execution"]
        recording = json.loads((folder / "trajectory.json").read_text())
        robot, variant = execution["robot"], execution.get("variant")
        self.prefix = f"{robot}_{variant}_" if variant else f"{robot}_"
        self.model = mujoco.MjModel.from_xml_path(str(folder / "mjcf" / f"scene_with_{robot}.xml"))
        self.data = mujoco.MjData(self.model)
        frames = recording["frames"]
        self.objects = recording["objects"]
        self.times_s = np.array([frame["time_s"] for frame in frames])
        self.end_s = float(self.times_s[-1]) if frames else 0.0
        self.targets = {
            **{name: [frame["joint_targets"][k] for frame in frames] for k, name in enumerate(recording["joints"])},
            recording["gripper_joint"]: [frame["gripper_target"] for frame in frames],
        }
        self.start(recording)

    def start(self, recording: dict) -> None:
        first = recording["frames"][0]
        for name, position in zip(recording["joints"], first["joint_positions"]):
            self.data.joint(self.prefix + name).qpos[0] = position
        fingers = [self.model.joint(k).name for k in range(self.model.njnt)]
        moved = {self.prefix + name for name in recording["joints"]}
        for name in fingers:
            if name.startswith(self.prefix) and name not in moved:
                # Each finger goes half the way; its sign is that of its range.
                low, high = self.model.joint(name).range
                side = 1.0 if high > -low else -1.0
                # Targets that press a thin object are below 0, where no finger is.
                self.data.joint(name).qpos[0] = side * max(0.0, first["gripper_target"])
        mujoco.mj_forward(self.model, self.data)

    def step(self) -> None:
        for name, targets in self.targets.items():
            control = np.interp(self.data.time, self.times_s, targets)
            self.data.actuator(self.prefix + name).ctrl[0] = control
        mujoco.mj_step(self.model, self.data)

    def state(self) -> dict:
        """As `tabletopgen judge` reads it."""
        objects = {name: self.pose(name) for name in self.objects}
        return {"objects": objects, "contacts": self.contacts()}

    def pose(self, name: str) -> dict:
        body = self.data.body(name)
        w, x, y, z = map(float, body.xquat)
        return {"translation_m": [float(v) for v in body.xpos], "rotation_xyzw": [x, y, z, w]}

    def contacts(self) -> list:
        found = set()
        force = np.zeros(6)
        for number, contact in enumerate(self.data.contact):
            mujoco.mj_contactForce(self.model, self.data, number, force)
            pair = tuple(sorted(self.side(geom) for geom in contact.geom))
            if force[0] > TOUCH_N and pair[0] != pair[1]:
                found.add(pair)
        as_json = {"table": "table", "gripper": "gripper"}
        return [
            {side: as_json.get(name, {"object": name}) for side, name in zip(("first", "second"), pair)}
            for pair in sorted(found)
        ]

    def side(self, geom: int) -> str:
        body = self.model.body(self.model.geom_bodyid[geom]).name
        if body.startswith(self.prefix):
            return "gripper"
        return body if body in self.objects else "table"


def judged(program: str, bundle: str, folder: Path, state: dict) -> dict:
    """What the program decides in that state."""
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(state, file)
        file.flush()
        command = [program, "judge", "--bundle", bundle, "--task", folder / "task.json", "--state", file.name, "--json"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if not done.stdout.startswith("{"):
        raise SystemExit(f"{program} judge: {done.stderr or done.stdout}")
    return json.loads(done.stdout)


if __name__ == "__main__":
    sys.exit(main())
