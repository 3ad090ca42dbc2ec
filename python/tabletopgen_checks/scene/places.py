"""Is everything there that a wish asks for, and where it asks for it? Read from scene.json, as anybody would measure it.

What is *on* a thing has its middle over that thing's box and above its middle; what is *in* one has its lowest end
inside the box, below the rim; what is *piled* stands on its like. The chain of supports must say the same. *Left*,
*right*, *front* and *behind* are those of somebody at the front edge: within 45 degrees of straight, or beside the
thing's box; *next to* leaves at most 15 cm between the boxes.
"""

import copy
import json
import math
from collections import Counter
from pathlib import Path

SLACK_M = 0.01
NEXT_TO_M = 0.15
DIRECTIONS = {"left": (-1, 0), "right": (1, 0), "front": (0, -1), "behind": (0, 1)}


def differences(wish, bundle: Path) -> list:
    """What is missing, too much, or elsewhere; empty when all is as asked for."""
    scene = json.loads((bundle / "scene.json").read_text(encoding="utf-8"))
    things = [Thing(instance) for instance in scene["instances"]]
    found = Counter(thing.category for thing in things)
    wrong = [
        f"{found[category]} {category} instead of {wish.expect.get(category, 0)}"
        for category in sorted(set(found) | set(wish.expect))
        if found[category] != wish.expect.get(category, 0)
    ]
    if wish.table and scene["table"]["shape"] != wish.table:
        wrong.append(f"a {scene['table']['shape']} table instead of a {wish.table} one")
    by_name = {thing.name: thing for thing in things}
    for place in wish.places:
        hosts = [thing for thing in things if thing.category == place.host]
        subjects = [thing for thing in things if thing.category == place.thing]
        if place.where == "piled":
            carried = sum(any(stands_on(t, h, by_name) for h in hosts if h is not t) for t in subjects)
            if subjects and carried != len(subjects) - 1:
                wrong.append(f"{carried + 1} {place.thing} in the pile of {len(subjects)}")
            continue
        for thing in subjects:
            if not any(holds(thing, place.where, host, by_name) for host in hosts):
                wrong.append(f"{thing.name} is not {place.where} the {place.host}")
    return wrong


class Thing:
    """An instance's box in the world: origin at the middle of its bottom, axes, size."""

    def __init__(self, instance):
        self.name, self.category = instance["name"], instance["category"]
        self.support = instance["support"]
        self.origin, self.size = instance["translation_m"], instance["size_m"]
        self.axes = axes(instance["rotation_xyzw"])
        # The outline of its hulls from above where it is known; else that of the box, which is larger.
        self.footprint = [tuple(corner) for corner in instance.get("footprint", ())]
        self.measure()

    def measure(self):
        self.center = self.at((0, 0, 0.5))
        faces = [(0.5, 0, 0.5), (-0.5, 0, 0.5), (0, 0.5, 0.5), (0, -0.5, 0.5), (0, 0, 0), (0, 0, 1)]
        self.lowest_end = min((self.at(face) for face in faces), key=lambda point: point[2])
        corners = [self.at((x, y, z)) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0, 1)]
        self.low = [min(corner[k] for corner in corners) for k in range(3)]
        self.high = [max(corner[k] for corner in corners) for k in range(3)]
        for k in (0, 1) if self.footprint else ():
            along = [corner[k] for corner in self.footprint]
            self.low[k], self.high[k] = min(along), max(along)
            self.center[k] = 0.5 * (self.low[k] + self.high[k])

    def turned(self, yaw_rad):
        """The same thing in a world that is turned about the vertical through the origin."""
        cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
        def turned(v):
            return [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], *v[2:]]
        thing = copy.copy(self)
        thing.origin, thing.axes = turned(self.origin), [turned(axis) for axis in self.axes]
        thing.footprint = [tuple(turned(corner)) for corner in self.footprint]
        thing.measure()
        return thing

    def at(self, shares):
        """A point of the box in the world; shares of its size, the bottom at 0."""
        along = [share * side for share, side in zip(shares, self.size)]
        return [self.origin[k] + sum(along[j] * self.axes[j][k] for j in range(3)) for k in range(3)]

    def over(self, point) -> bool:
        """Whether a point lies above or below the box's bottom face."""
        away = [point[k] - self.origin[k] for k in range(3)]
        inside = [abs(sum(away[k] * self.axes[j][k] for k in range(3))) for j in (0, 1)]
        return all(inside[j] <= 0.5 * self.size[j] + SLACK_M for j in (0, 1))


def axes(xyzw):
    x, y, z, w = xyzw
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
        [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
        [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)],
    ]


def holds(thing, where, host, by_name) -> bool:
    if where == "on":
        # A paper clip in the well of a plate is below the height of the rim.
        return carried_by(thing, host, by_name) and host.over(thing.center) and thing.center[2] > host.low[2]
    if where == "in":
        inside = host.over(thing.lowest_end) and thing.lowest_end[2] < host.high[2]
        return carried_by(thing, host, by_name) and inside
    if where == "next":
        gaps = [max(thing.low[k] - host.high[k], host.low[k] - thing.high[k], 0.0) for k in (0, 1)]
        return math.hypot(*gaps) <= NEXT_TO_M
    dx, dy = DIRECTIONS[where]
    way = [thing.center[k] - host.center[k] for k in (0, 1)]
    along, across = way[0] * dx + way[1] * dy, abs(way[0] * dy - way[1] * dx)
    half = 0.5 * ((host.high[0] - host.low[0]) if dx == 0 else (host.high[1] - host.low[1]))
    return along > 0 and across <= max(along, half)


def stands_on(thing, host, by_name) -> bool:
    """Directly, as the next of a pile."""
    parent = by_name.get(thing.support["parent"])
    return parent is host and host.over(thing.center) and thing.center[2] > host.center[2]


def carried_by(thing, host, by_name) -> bool:
    parent = by_name.get(thing.support["parent"])
    while parent is not None and parent is not host:
        parent = by_name.get(parent.support["parent"])
    return parent is host
