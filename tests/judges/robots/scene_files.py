"""Independent programs read what `tabletopgen execute --out FOLDER --video` wrote: the robot in the scene, and the
motion.

    scene_files.py FOLDER

PyBullet loads the URDF as one tree, usd-core finds the base where it stood, pyarrow reads the table, PyAV decodes the
video. MuJoCo's part is replay.py. Prints one line of JSON; exit code 1 where one has a complaint.
"""

import json
import sys
from pathlib import Path

import av
import numpy as np
import pyarrow.parquet
from pxr import Usd, UsdGeom, UsdPhysics

# Positions in USD's joints are single precision.
NEAR_M = 1e-6


def main(folder: str) -> int:
    folder = Path(folder)
    execution = json.loads((folder / "execution.json").read_text())["execution"]
    recording = json.loads((folder / "trajectory.json").read_text())
    base_m = np.array(execution["world_from_base"]["translation_m"])
    robot = execution["robot"]
    complaints = [
        *usd(folder / "usd" / f"scene_with_{robot}.usda", robot, base_m),
        *urdf(folder / "urdf" / f"scene_with_{robot}.urdf", base_m),
        *table(folder / "trajectory.parquet", recording),
        *video(folder / "video.mp4", recording),
    ]
    print(json.dumps({"folder": str(folder), "complaints": complaints}))
    return int(bool(complaints))


def usd(path: Path, robot: str, base_m) -> list:
    stage = Usd.Stage.Open(str(path))
    root = stage.GetPrimAtPath(f"/World/{robot}")
    base = UsdGeom.XformCache().GetLocalToWorldTransform(root).ExtractTranslation()
    fixed = UsdPhysics.Joint(stage.GetPrimAtPath(f"/World/{robot}/joints/base_joint"))
    wrong = []
    for what, found in (("the robot", base), ("its fixed joint", fixed.GetLocalPos0Attr().Get())):
        if not np.allclose(found, base_m, atol=NEAR_M):
            wrong.append(f"usd: {what} is at {found}, not at {base_m}")
    bodies = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    if len(bodies) < 8:
        wrong.append(f"usd: only {len(bodies)} rigid bodies")
    return wrong


def urdf(path: Path, base_m) -> list:
    try:
        import pybullet
    except ModuleNotFoundError:
        # Later Pythons have no packages of PyBullet.
        return []
    client = pybullet.connect(pybullet.DIRECT)
    body = pybullet.loadURDF(str(path), useFixedBase=True)
    links = {pybullet.getJointInfo(body, k)[12].decode(): k for k in range(pybullet.getNumJoints(body))}
    base = next(name for name in links if name.endswith("link0") or name == "base_link")
    at_m = pybullet.getLinkState(body, links[base], computeForwardKinematics=True)[4]
    pybullet.disconnect(client)
    return [] if np.allclose(at_m, base_m, atol=NEAR_M) else [f"urdf: {base} is at {at_m}, not at {base_m}"]


def table(path: Path, recording: dict) -> list:
    rows = pyarrow.parquet.read_table(path)
    wrong = []
    if rows.num_rows != len(recording["frames"]):
        wrong.append(f"parquet: {rows.num_rows} rows for {len(recording['frames'])} frames")
    targets = [frame["joint_targets"] for frame in recording["frames"]]
    if rows.column("joint_targets").to_pylist() != targets:
        wrong.append("parquet: other joint targets than in trajectory.json")
    if json.loads(rows.schema.metadata[b"joints"]) != recording["joints"]:
        wrong.append("parquet: other joints than in trajectory.json")
    return wrong


def video(path: Path, recording: dict) -> list:
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
        rate = float(stream.average_rate)
    wrong = []
    duration_s = len(recording["frames"]) / recording["rate_hz"]
    if abs(len(frames) / rate - duration_s) > 0.1:
        wrong.append(f"video: {len(frames)} frames at {rate} Hz for a motion of {duration_s:.2f} s")
    if np.std(frames[0]) < 5:
        wrong.append("video: the first frame shows nothing")
    if np.abs(frames[0].astype(int) - frames[len(frames) // 2]).max() < 30:
        wrong.append("video: nothing moves")
    return wrong


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
