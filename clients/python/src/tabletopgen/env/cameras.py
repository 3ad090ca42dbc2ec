"""Cameras of a dataset in MuJoCo: where they are in an episode, and what they see."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tabletopgen.env import poses
from tabletopgen.env.engine import mujoco
from tabletopgen.env.poses import Array
from tabletopgen.env.start import CameraStart

# Axes of OpenCV (x right, y down, z forward) to those of MuJoCo (x right, y up, z backward).
TURNED = np.diag([1.0, -1.0, -1.0])

Image = NDArray[np.uint8]


@dataclass(frozen=True)
class Camera:
    """A camera as a dataset's records describe it, fixed to the `world` or to the `tool`."""

    name: str
    mount: str
    eye_m: tuple[float, float, float]
    target_m: tuple[float, float, float]
    fov_x_rad: float
    width_px: int
    height_px: int

    @classmethod
    def of_record(cls, record: Mapping[str, Any]) -> Camera:
        return cls(**{**record, "eye_m": tuple(record["eye_m"]), "target_m": tuple(record["target_m"])})

    def focal_px(self, drawn: CameraStart) -> float:
        """The focal length in an episode."""
        return 0.5 * self.width_px / float(np.tan(0.5 * self.fov_x_rad)) * drawn.focal_factor

    def mount_from_camera(self, drawn: CameraStart) -> Array:
        """The pose in an episode, with axes of OpenCV."""
        eye = np.array(self.eye_m)
        forward = np.array(self.target_m) - eye
        forward /= np.linalg.norm(forward)
        vertical = np.array([0.0, 0.0, 1.0])
        up = vertical if np.linalg.norm(np.cross(forward, vertical)) > 1e-9 else np.array([0.0, 1.0, 0.0])
        right = np.cross(forward, up)
        right /= np.linalg.norm(right)
        nominal = poses.with_rotation(eye, np.stack([right, np.cross(forward, right), forward], axis=1))
        return nominal @ poses.with_rotation(drawn.offset_m, poses.of_rotation_vector(drawn.turn_rad))


def name_of(camera: Camera) -> str:
    """The name of a camera in the model, where others may have its own."""
    return f"observed_{camera.name}"


class CameraImages:
    """Images of the cameras of a model; drawing needs OpenGL."""

    def __init__(self, model: Any, cameras: Sequence[Camera], tool_site: int):
        self.model, self.cameras = model, tuple(cameras)
        self._renderers: dict[tuple[int, int], Any] = {}
        site = model.site(tool_site)
        self._body_from_tool = poses.transform(site.pos, site.quat)

    def place(self, drawn: Sequence[CameraStart]) -> None:
        """Puts the cameras where an episode has them; kinematics have to be computed after that."""
        for camera, own in zip(self.cameras, drawn, strict=True):
            number = self.model.camera(name_of(camera)).id
            pose = camera.mount_from_camera(own)
            if camera.mount == "tool":
                pose = self._body_from_tool @ pose
            self.model.cam_pos[number] = pose[:3, 3]
            self.model.cam_quat[number] = poses.quaternion_wxyz(pose[:3, :3] @ TURNED)
            self.model.cam_fovy[number] = np.degrees(2.0 * np.arctan(0.5 * camera.height_px / camera.focal_px(own)))

    def world_from_camera(self, data: Any, camera: Camera) -> Array:
        """The pose with axes of OpenCV, as the datasets' `camera.NAME.world_from_camera`."""
        number = self.model.camera(name_of(camera)).id
        return poses.with_rotation(data.cam_xpos[number], data.cam_xmat[number].reshape(3, 3) @ TURNED)

    def images(self, data: Any) -> dict[str, Image]:
        """What each camera sees, (height, width, 3)."""
        return {camera.name: self.image(data, name_of(camera), camera.width_px, camera.height_px) for camera in self.cameras}

    def image(self, data: Any, camera: str, width_px: int, height_px: int) -> Image:
        """What a camera of the model sees."""
        size = (height_px, width_px)
        if size not in self._renderers:
            self._renderers[size] = mujoco.Renderer(self.model, *size)
        self._renderers[size].update_scene(data, camera=camera)
        drawn: Image = self._renderers[size].render()
        return drawn

    def close(self) -> None:
        for renderer in self._renderers.values():
            renderer.close()
        self._renderers.clear()
