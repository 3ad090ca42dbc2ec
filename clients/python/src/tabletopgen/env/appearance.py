"""Colors and light of an episode, as far as MuJoCo's materials and lamp can have them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tabletopgen.env.engine import mujoco
from tabletopgen.env.robot import below
from tabletopgen.env.start import LightStart, Start

TABLE, LIGHT = "table", "sun"


class Appearance:
    """Colors of the materials of objects and table, and the lamp of the scene, of a model."""

    def __init__(self, model: Any, geoms: Mapping[str, NDArray[np.int64]]):
        self.model, self.geoms = model, geoms
        of_table = np.flatnonzero(np.isin(model.geom_bodyid, below(model, int(model.body(TABLE).id))))
        self.materials = {name: materials_of(model, own) for name, own in {**geoms, TABLE: of_table}.items()}
        self.light = int(model.light(LIGHT).id)
        self._as_compiled = {name: getattr(model, name).copy() for name in ("mat_rgba", "light_dir", "light_pos", "light_diffuse")}

    def begin(self, start: Start) -> None:
        """The colors and the light that an episode has. A color cannot be brighter than white."""
        for name, values in self._as_compiled.items():
            getattr(self.model, name)[:] = values
        tints = {name: drawn.tint for name, drawn in start.objects.items()} | {TABLE: start.table_tint}
        for name, tint in tints.items():
            colors = self.model.mat_rgba[self.materials[name], :3]
            self.model.mat_rgba[self.materials[name], :3] = np.clip(colors * np.array(tint), 0.0, 1.0)
        self._light(start.light)

    def color(self, name: str) -> list[float]:
        """The color of most of an object's surface as an episode has it, red, green and blue from 0 to 1: that of the
        material with the largest area, times the mean of its texture."""
        areas_m2: dict[int, float] = {}
        for geom in self.geoms[name]:
            material = int(self.model.geom_matid[geom])
            if material >= 0:
                areas_m2[material] = areas_m2.get(material, 0.0) + area_m2(self.model, int(geom))
        if not areas_m2:
            return [float(channel) for channel in self.model.geom_rgba[self.geoms[name][0], :3]]
        largest = max(areas_m2, key=lambda material: areas_m2[material])
        found: list[float] = (self.model.mat_rgba[largest, :3] * texture_color(self.model, largest)).tolist()
        return found

    def _light(self, drawn: LightStart) -> None:
        model, number = self.model, self.light
        model.light_diffuse[number] *= drawn.brightness_factor
        x, y, z = model.light_dir[number]
        distance_m = float(np.linalg.norm(model.light_pos[number]))
        azimuth_rad = np.arctan2(y, x) + drawn.turn_rad
        elevation_rad = np.clip(np.arctan2(-z, np.hypot(x, y)) + drawn.raise_rad, 0.3, 1.5)
        flat = np.cos(elevation_rad)
        direction = np.array([flat * np.cos(azimuth_rad), flat * np.sin(azimuth_rad), -np.sin(elevation_rad)])
        model.light_dir[number], model.light_pos[number] = direction, -distance_m * direction


def materials_of(model: Any, geoms: NDArray[np.int64]) -> NDArray[np.int64]:
    """Materials of geoms, each once."""
    found: NDArray[np.int64] = np.unique(model.geom_matid[geoms])
    return found[found >= 0]


def area_m2(model: Any, geom: int) -> float:
    """The area of a mesh; of another shape, that of the largest side of its box."""
    mesh = int(model.geom_dataid[geom])
    if mesh < 0:
        return float(np.prod(sorted(2 * model.geom_aabb[geom, 3:])[1:]))
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    faces = model.mesh_face[model.mesh_faceadr[mesh] : model.mesh_faceadr[mesh] + model.mesh_facenum[mesh]]
    corners = model.mesh_vert[first : first + count][faces].astype(np.float64)
    return float(np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2)


def texture_color(model: Any, material: int) -> NDArray[np.float64]:
    """The mean color of a material's texture, channels from 0 to 1; white without one."""
    texture = int(model.mat_texid[material, int(mujoco.mjtTextureRole.mjTEXROLE_RGB)])
    if texture < 0:
        return np.ones(3)
    channels, first = int(model.tex_nchannel[texture]), int(model.tex_adr[texture])
    size = int(model.tex_height[texture]) * int(model.tex_width[texture]) * channels
    pixels = model.tex_data[first : first + size].reshape(-1, channels)[:, :3]
    mean: NDArray[np.float64] = pixels.mean(axis=0) / 255
    return np.broadcast_to(mean, (3,)).copy()
