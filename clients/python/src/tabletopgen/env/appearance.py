"""Colors and light of an episode, as far as MuJoCo's materials and lamp can have them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tabletopgen.env.robot import below
from tabletopgen.env.start import LightStart, Start

TABLE, LIGHT = "table", "sun"


class Appearance:
    """Colors of the materials of objects and table, and the lamp of the scene, of a model."""

    def __init__(self, model: Any, geoms: Mapping[str, NDArray[np.int64]]):
        self.model = model
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
