"""Files for the viewer Rerun (`.rrd`), written by its package, which functions import when called."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from tabletopgen._media import imported
from tabletopgen.simulators import bodies_of

PACKAGE = "rerun-sdk"
APPLICATION = "tabletopgen"


def write_scene(bundle: Path, path: str | Path) -> Path:
    """A bundle with GLB as entities of the frame `world`, in meters: table and objects by their names, each with its
    mesh, mass and friction, and the camera of the image, which is shown in it. Returns the path of the file."""
    rr = imported("rerun", PACKAGE)
    scene = json.loads((bundle / "scene.json").read_text(encoding="utf-8"))
    target = placed(path)
    with rr.RecordingStream(APPLICATION, recording_id=scene["id"]) as stream:
        stream.save(target)
        stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        # Files of GLB have +y up.
        upright = rr.Transform3D(rotation=rr.RotationAxisAngle(axis=(1, 0, 0), radians=math.pi / 2))
        for body in bodies_of(bundle):
            entity = f"world/{rr.escape_entity_path_part(body['name'])}"
            pose = pose_of(rr, body) if "translation_m" in body else rr.Transform3D()
            stream.log(entity, pose, rr.AnyValues(**facts_of(body)), static=True)
            stream.log(f"{entity}/mesh", upright, rr.Asset3D(path=bundle / "glb" / f"{body['name']}.glb"), static=True)
        camera = scene["camera"]
        pinhole = rr.Pinhole(
            focal_length=(camera["fx"], camera["fy"]),
            principal_point=(camera["cx"], camera["cy"]),
            resolution=(camera["width_px"], camera["height_px"]),
            image_plane_distance=0.3,
        )
        stream.log("world/camera", pose_of(rr, camera["world_from_camera"]), pinhole, static=True)
        image = bundle / "preview" / "reference.png"
        if image.is_file():
            stream.log("world/camera", rr.EncodedImage(path=image), static=True)
    return target


def write_episode(dataset: Path, episode: int, path: str | Path) -> Path:
    """An episode of a dataset for LeRobot: cameras, state, action and the rest by frames, as Rerun's reader of LeRobot
    names them. Returns the path of the file."""
    imported("rerun", PACKAGE)
    reader = imported("rerun.experimental", PACKAGE).LeRobotReader(dataset)
    if episode not in reader.episodes():
        raise ValueError(f"{dataset} has no episode {episode} but {len(reader.episodes())}, which count from 0")
    target = placed(path)
    reader.stream(episode).write_rrd(target, application_id=APPLICATION, recording_id=f"episode_{episode}")
    return target


def placed(path: str | Path) -> Path:
    """A path whose folder exists."""
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    return target


def pose_of(rr: Any, pose: dict[str, Any]) -> Any:
    return rr.Transform3D(translation=pose["translation_m"], quaternion=rr.Quaternion(xyzw=pose["rotation_xyzw"]))


def facts_of(body: dict[str, Any]) -> dict[str, Any]:
    """What is known of a body beside its shape."""
    return {"label": body["label"], "mass_kg": body["mass_kg"], "friction_static": body["friction"]["static"]}
