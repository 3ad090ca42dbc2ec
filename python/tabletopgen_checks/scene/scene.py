"""A finished scene as its bundle shows it: scene.json, report.json and the hulls of the URDF files.

Nothing here is shared with the program that makes the scenes. World frame: x to the right, y to the back, z up, the
origin on the table top; meters, kilograms, radians.
"""

import copy
import json
import math
from pathlib import Path

from tabletopgen_checks.scene.polygons import bounds, center_of, convex_hull, turned

TABLE = "table"


class Body:
    """An instance with its collision hulls in the world. `hulls` are lists of points in the frame of the object; where
    there are none, the box of the object is its hull.
    """

    def __init__(self, instance: dict, hulls: list | None = None):
        self.instance, self.local_hulls = instance, hulls or [box_corners(instance["size_m"])]
        self.name, self.label, self.category = instance["name"], instance["label"], instance["category"]
        self.size_m, self.mass_kg, self.friction = instance["size_m"], instance["mass_kg"], instance["friction"]
        self.yaw_rad, self.symmetry_order = instance["yaw_rad"], instance["symmetry_order"]
        self.parent, self.relation = instance["support"]["parent"], instance["support"]["relation"]
        self.pose = instance["translation_m"], instance["rotation_xyzw"]
        turn = rotation(instance["rotation_xyzw"])
        self.hulls = [[placed(turn, instance["translation_m"], point) for point in hull] for hull in self.local_hulls]
        self.points = [point for hull in self.hulls for point in hull]
        self.center_of_mass_m = placed(turn, instance["translation_m"], instance["center_of_mass_m"])
        self.footprint = convex_hull([point[:2] for point in self.points])
        self.center = center_of(self.footprint)
        self.bottom_m, self.top_m = (choose(point[2] for point in self.points) for choose in (min, max))

    def outline(self) -> list:
        """The points of `local_hulls` that decide the footprint and the height: as a hull they give both again."""
        extremes = {*self.footprint, self.bottom_m, self.top_m}
        local = [point for hull in self.local_hulls for point in hull]
        return [point for point, (x, y, z) in zip(local, self.points) if extremes & {(x, y), z}]

    def turned(self, angle_rad: float) -> "Body":
        """The footprint of the same body in a world that is turned about the vertical through the origin."""
        body = copy.copy(self)
        body.footprint = turned(self.footprint, angle_rad)
        body.center = center_of(body.footprint)
        return body

    def bounds(self) -> tuple:
        return bounds(self.footprint)

    def axis(self, k: int) -> tuple:
        """The direction of an axis of the object in the world."""
        return rotated(self.pose[1], tuple(float(j == k) for j in range(3)))

    def extent_m(self, way) -> float:
        """From the center along a unit direction."""
        x, y = self.center
        return max(0.0, max((p - x) * way[0] + (q - y) * way[1] for p, q in self.footprint))

    def front(self) -> tuple:
        """Horizontal direction of the front: -y of the object turned by the yaw."""
        if self.yaw_rad is None:
            return rotated(self.instance["rotation_xyzw"], (0.0, -1.0, 0.0))[:2]
        return math.sin(self.yaw_rad), -math.cos(self.yaw_rad)


class Scene:
    """The table, the bodies by name, and what the report says."""

    def __init__(self, scene: dict, hulls: dict, report: dict | None = None, folder: Path | None = None):
        self.scene, self.report, self.folder = scene, report or {}, folder
        self.id, self.table = scene.get("id"), scene["table"]
        self.outline = [tuple(corner) for corner in scene["table"]["outline_m"]]
        # What stands up from the table top is an obstacle.
        self.table_hulls = [hull for hull in hulls.get(TABLE, ()) if max(point[2] for point in hull) > 0.002]
        self.bodies = {instance["name"]: Body(instance, hulls.get(instance["name"])) for instance in scene["instances"]}

    def contents(self, name: str) -> list:
        """What stands on or in an object, directly or not."""
        found = []
        for body in self.bodies.values():
            if body.name != name and name in self.supporters(body.name):
                found.append(body.name)
        return found

    def supporters(self, name: str) -> list:
        """The objects below, the direct one first; without the table."""
        found, body = [], self.bodies[name]
        while body.parent in self.bodies and body.parent not in found:
            found.append(body.parent)
            body = self.bodies[body.parent]
        return found


def read_scene(folder: Path) -> Scene:
    """The scene of an unpacked bundle."""
    scene, report = (json.loads((folder / name).read_text(encoding="utf-8")) for name in ("scene.json", "report.json"))
    names = [instance["name"] for instance in scene["instances"]] + [TABLE]
    return Scene(scene, {name: read_hulls(folder / "urdf" / name) for name in names}, report, folder)


def box_corners(size_m) -> list:
    """The box of an object, whose origin is the center of the bottom."""
    x, y, z = 0.5 * size_m[0], 0.5 * size_m[1], size_m[2]
    return [(a, b, c) for a in (-x, x) for b in (-y, y) for c in (0.0, z)]


def read_hulls(folder: Path) -> list:
    return [read_points(path) for path in sorted(folder.glob("hull_*.obj"))]


def read_points(path: Path) -> list:
    lines = path.read_text(encoding="utf-8").splitlines()
    return [tuple(map(float, line.split()[1:4])) for line in lines if line.startswith("v ")]


def rotation(xyzw) -> list:
    """Rows of the rotation matrix."""
    x, y, z, w = (part / math.sqrt(sum(q * q for q in xyzw)) for part in xyzw)
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]


def placed(turn, translation, point) -> tuple:
    return tuple(sum(turn[k][j] * point[j] for j in range(3)) + translation[k] for k in range(3))


def rotated(xyzw, point) -> tuple:
    return placed(rotation(xyzw), (0.0, 0.0, 0.0), point)


def inverse_placed(pose, point) -> tuple:
    """A point of the world in the frame of a pose (translation, rotation_xyzw)."""
    turn, away = rotation(pose[1]), [point[k] - pose[0][k] for k in range(3)]
    return tuple(sum(turn[j][k] * away[j] for j in range(3)) for k in range(3))


def moved_m(a: Body, b: Body) -> float:
    return math.dist(a.pose[0], b.pose[0])


def angle_rad(a: Body, b: Body) -> float:
    """Angle between the rotations of two bodies."""
    dot = abs(sum(p * q for p, q in zip(a.pose[1], b.pose[1])))
    return 2.0 * math.acos(min(1.0, dot))


def wrapped_rad(angle: float, order: int = 1) -> float:
    """The angle from -pi / order to pi / order; 0 for any symmetry (order 0)."""
    if order == 0:
        return 0.0
    period = 2.0 * math.pi / order
    return (angle + 0.5 * period) % period - 0.5 * period
