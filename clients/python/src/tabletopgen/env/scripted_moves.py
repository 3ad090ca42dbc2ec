"""Places to which a script puts objects, in search of one where a predicate holds: the judge decides."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

import numpy as np

from tabletopgen.env import poses
from tabletopgen.env.folder import EnvironmentFolder
from tabletopgen.env.judge import SCENE
from tabletopgen.env.poses import Array
from tabletopgen.env.simulation import Simulation

# Objects are let go so far above what is below them, set down so far from a neighbor, and held up so high.
DROP_M, BESIDE_M, RAISED_M = 0.004, 0.04, 0.1
TURN_RAD = 0.8
# Shares of the half of the table, or of a target, to each side of its center.
GRID, OFFSETS = (0.0, -0.6, 0.6, -0.3, 0.3), (0.0, -0.4, 0.4)
# Predicates that hold above a target, beside it, and by how an object is turned; others hold somewhere on the table.
ABOVE = ("on", "in", "stacked_on")
BESIDE = ("left_of", "right_of", "in_front_of", "behind", "next_to")
POSTURES = ("rotated", "upright", "lying_on_side", "upside_down")

# Poses by the names of objects.
Move = dict[str, Array]


class ScriptedMoves:
    """Moves of the objects of a simulation as they are when a move is asked for."""

    def __init__(self, files: EnvironmentFolder, simulation: Simulation):
        self.simulation = simulation
        self.points_m = {name: collision_points(simulation, name) for name in simulation.objects}
        table = json.loads((files.scene / SCENE).read_text(encoding="utf-8"))["table"]["outline_m"]
        outline = np.array(table)
        self.table_m = np.stack([outline.min(0), outline.max(0)])

    def of(self, predicate: Mapping[str, Any]) -> Iterator[Move]:
        """Moves that may make a predicate true, the most promising first."""
        kind, name, target = predicate["predicate"], predicate["object"], predicate.get("target")
        if kind == "lifted":
            yield {name: poses.with_rotation([0.0, 0.0, RAISED_M], np.eye(3)) @ self.simulation.matrix(name)}
        elif kind == "swapped":
            yield self._exchanged(name, str(target))
        else:
            yield from ({name: pose} for pose in self._poses(kind, name, target, predicate.get("second_target")))

    def _poses(self, kind: str, name: str, target: str | None, second: str | None) -> Iterator[Array]:
        """Where an object is put for a predicate that is about it alone."""
        if kind in ABOVE and target is not None:
            yield from self._above(name, target)
        elif kind in BESIDE and target is not None:
            yield from self._beside(name, target)
        elif kind in POSTURES:
            yield from self._turned(name)
        elif target is not None and second is not None:
            yield self._set_down(name, 0.5 * (self._center_m(target) + self._center_m(second)))
        else:
            yield from (self._set_down(name, at) for at in self._grid())

    def _bounds(self, name: str, pose: Array | None = None) -> Array:
        """The lowest and the highest coordinates of an object, meters."""
        own = self.simulation.matrix(name) if pose is None else pose
        points = self.points_m[name] @ own[:3, :3].T + own[:3, 3]
        return np.stack([points.min(0), points.max(0)])

    def _center_m(self, name: str) -> Array:
        center: Array = self._bounds(name).mean(0)[:2]
        return center

    def _set_down(self, name: str, at_m: Array, above_m: float = 0.0, rotation: Array | None = None) -> Array:
        """The pose with the center of the object there, its lowest point just above a height."""
        pose = self.simulation.matrix(name)
        if rotation is not None:
            pose[:3, :3] = rotation
        bounds = self._bounds(name, pose)
        pose[:2, 3] += at_m - bounds.mean(0)[:2]
        pose[2, 3] += above_m + DROP_M - bounds[0, 2]
        return pose

    def _above(self, name: str, target: str) -> Iterator[Array]:
        low, high = self._bounds(target)
        for x, y in product(OFFSETS, OFFSETS):
            center = 0.5 * (low + high)[:2] + 0.5 * np.array([x, y]) * (high - low)[:2]
            yield self._set_down(name, center, float(high[2]))

    def _beside(self, name: str, target: str) -> Iterator[Array]:
        half = 0.5 * np.ptp(self._bounds(name), axis=0)[:2] + 0.5 * np.ptp(self._bounds(target), axis=0)[:2] + BESIDE_M
        for x, y in ((-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)):
            yield self._set_down(name, self._center_m(target) + np.array([x, y]) * half)

    def _exchanged(self, name: str, target: str) -> Move:
        return {name: self._set_down(name, self._center_m(target)), target: self._set_down(target, self._center_m(name))}

    def _turned(self, name: str) -> Iterator[Array]:
        """Where it is, but turned: about the vertical, and onto each side."""
        now, at = self.simulation.matrix(name)[:3, :3], self._center_m(name)
        for vector in ([0.0, 0.0, TURN_RAD], [np.pi / 2, 0.0, 0.0], [0.0, np.pi / 2, 0.0], [np.pi, 0.0, 0.0]):
            yield self._set_down(name, at, rotation=poses.of_rotation_vector(vector) @ now)

    def _grid(self) -> Iterator[Array]:
        center, half = self.table_m.mean(0), 0.5 * np.ptp(self.table_m, axis=0)
        for x, y in product(GRID, GRID):
            yield center + np.array([x, y]) * half


def collision_points(simulation: Simulation, name: str) -> Array:
    """Points of the collision shapes of an object in its frame, meters: corners of meshes, and of the boxes around
    other shapes."""
    model, parts = simulation.model, []
    for geom in simulation.geoms[name]:
        if not model.geom_contype[geom]:
            continue
        mesh = int(model.geom_dataid[geom])
        if mesh >= 0:
            first = int(model.mesh_vertadr[mesh])
            points = model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])]
        else:
            center, half = model.geom_aabb[geom].reshape(2, 3)
            points = center + half * np.array(list(product((-1, 1), repeat=3)))
        pose = poses.transform(model.geom_pos[geom], model.geom_quat[geom])
        parts.append(points @ pose[:3, :3].T + pose[:3, 3])
    return np.concatenate(parts)
