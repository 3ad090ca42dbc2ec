"""What a finished scene shows: a view of it for `expectations.py`, measured from poses and hulls.

Colors, materials and states are those of the description of the same text and seed, whose objects have the names of the
instances; everything else is measured. Relations are those of `scene/relations.py`, and what is on, in or stacked on an
object is carried by it, directly or not; left, right, front and behind are as the person at the target sees them where
the description says so (`seated`). Other tolerances are the constants below; distances are between the outlines from
above.
"""

import dataclasses
import itertools
import math

from tabletopgen_checks.language.description import Described, chains
from tabletopgen_checks.scene.polygons import bounds, distance_m
from tabletopgen_checks.scene.relations import DIRECTIONS, EDGES, edge_distance_m, holds, is_above
from tabletopgen_checks.scene.scene import Scene

# Neighbors of a row, a column or a grid line deviate at most this much from a straight line.
STRAIGHT_CM = 3.0
# The radii of a circle differ at most by this share.
ROUND = 0.2
PARALLEL_DEG = 10.0
# What is around a target is at most this far from it.
AROUND_CM = 35.0
# Members of a pile touch or nearly touch another.
PILE_CM = 3.0
# Cosines of the tilt up to which an object is upright, and from which on it lies.
UPRIGHT, LYING = 0.9, 0.35
# The center and the sides of a table are thirds of its extents.
THIRD = 1 / 6


class Measured:
    """`described` is the view of the description that the scene was made from."""

    def __init__(self, scene: Scene, described):
        self.scene, self.bodies, self.described = scene, scene.bodies, described
        found = [item for item in described.objects if item.name in self.bodies]
        self.objects = [measured(item, self.bodies[item.name]) for item in found]
        self.by_name = {item.name: item for item in self.objects}
        outline = scene.outline
        self.edges = list(zip(outline, outline[1:] + outline[:1]))
        self.low, self.high = bounds(outline)
        self.table = {"shape": scene.table["shape"], "size_cm": [100 * side for side in scene.table["size_m"]]}
        self.excluded, self.reported = described.excluded, described.reported
        self.corrected, self.goal = described.corrected, described.goal

    def differences(self) -> list:
        """Objects of the description that the scene lacks, and the reverse."""
        asked = {item.name: item.category for item in self.described.objects}
        found = {name: body.category for name, body in self.bodies.items()}
        return [f"{name} is not in the scene" for name in sorted(asked.keys() - found.keys())] + [
            f"{name} is only in the scene" for name in sorted(found.keys() - asked.keys())
        ]

    def related(self, kind, name, target, second=None) -> bool:
        body, other = self.bodies[name], self.bodies.get(target)
        if kind.startswith("at_"):
            return self.is_at(body, kind.split("_")[1:])
        if kind in EDGES:
            return True
        if other is None:
            return False
        if kind in DIRECTIONS and (name, target) in self.described.seated:
            turn_rad = -self.seat_yaw_rad(other)
            body, other = body.turned(turn_rad), other.turned(turn_rad)
        if kind in ("on", "in"):
            return self.is_carried(kind, body, other)
        if kind == "stacked_on" and body.parent != target:
            return False
        if kind == "parallel_to":
            turn = angle_deg(long_side(body), long_side(other))
            return min(turn, 180 - turn) <= PARALLEL_DEG
        if kind == "around":
            return gap_cm(body, other) <= AROUND_CM
        return holds(kind, body, self.scene.outline, other, self.bodies.get(second))

    def is_carried(self, kind, body, other) -> bool:
        """Whether a body stands in or on another one, or above it on what does."""
        chain = [body.name, *self.scene.supporters(body.name)]
        if other.name not in chain[1:]:
            return False
        if kind == "in":
            return holds(kind, body, self.scene.outline, other)
        direct = self.bodies[chain[chain.index(other.name) - 1]]
        return is_above(body, other) and holds(kind, direct, self.scene.outline, other)

    def seat_yaw_rad(self, body) -> float:
        """Yaw of the person at an object, who faces away from the nearest edge; 0 at the front edge."""
        way = min((nearest(body.center, *edge) for edge in self.edges), key=lambda way: math.hypot(*way))
        return math.atan2(way[1], way[0]) + math.pi / 2

    def is_at(self, body, words) -> bool:
        shares = [(body.center[k] - 0.5 * (self.low[k] + self.high[k])) / (self.high[k] - self.low[k]) for k in (0, 1)]
        sides = {"left": shares[0] < -THIRD, "right": shares[0] > THIRD, "front": shares[1] < -THIRD,
                 "back": shares[1] > THIRD, "center": max(map(abs, shares)) <= THIRD}
        return all(sides[word] for word in words)

    def distances_cm(self, kind, name, target) -> list:
        body = self.bodies[name]
        if kind in EDGES:
            return [100 * edge_distance_m(kind, body, self.scene.outline)]
        return [gap_cm(body, self.bodies[target])] if target in self.bodies else []

    def arranged(self, kind, names) -> list:
        bodies = [self.bodies[name] for name in names]
        if kind == "stack":
            return [(chain, None) for chain in chains(names, lambda a, b: self.related("stacked_on", a, b))]
        groups = {
            "row": lambda: lines(bodies, 1, 0),
            "column": lambda: lines(bodies, 0, 1),
            "circle": lambda: [bodies] if is_circle(bodies) else [],
            "grid": lambda: [bodies] if is_grid(bodies) else [],
            "pile": lambda: [bodies] if is_pile(bodies) else [],
            "pyramid": lambda: [bodies] if is_pyramid(bodies) else [],
        }[kind]()
        return [([body.name for body in group], smallest_gap_cm(group)) for group in groups]


def view_of(scene: Scene) -> Measured:
    """The view of a scene without a description: everything in it counts as asked for."""
    objects = [{"id": body.name, "requested": True, **body.instance} for body in scene.bodies.values()]
    return Measured(scene, Described({"objects": objects, "table": {}}))


def measured(item, body):
    """The described object with the measured size, pose, yaw and position."""
    up = body.axis(2)[2]
    pose = "lying_on_side" if abs(up) <= LYING else "tilted"
    if abs(up) >= UPRIGHT:
        pose = "upright" if up > 0 else "upside_down"
    return dataclasses.replace(
        item,
        size_cm=tuple(100 * side for side in body.size_m),
        pose=pose,
        yaw_deg=math.degrees(math.atan2(body.axis(0)[1], body.axis(0)[0])),
        position_cm=tuple(100 * body.center[k] for k in (0, 1)),
    )


def gap_cm(a, b) -> float:
    """Horizontal distance of the footprints."""
    return 100 * max(0.0, distance_m(a.footprint, b.footprint))


def smallest_gap_cm(bodies):
    gaps = [gap_cm(a, b) for a, b in itertools.combinations(bodies, 2)]
    return min(gaps) if gaps else None


def nearest(point, start, end) -> tuple:
    """The way from a point to the nearest point of a segment."""
    along = [end[k] - start[k] for k in (0, 1)]
    share = sum((point[k] - start[k]) * along[k] for k in (0, 1)) / (along[0] ** 2 + along[1] ** 2)
    share = max(0.0, min(1.0, share))
    return tuple(start[k] + share * along[k] - point[k] for k in (0, 1))


def long_side(body) -> tuple:
    return body.axis(0 if body.size_m[0] >= body.size_m[1] else 1)[:2]


def angle_deg(a, b) -> float:
    length = math.hypot(*a) * math.hypot(*b)
    if length == 0:
        return 180.0
    return math.degrees(math.acos(max(-1.0, min(1.0, (a[0] * b[0] + a[1] * b[1]) / length))))


def clusters(values) -> list:
    """Indices of values, grouped where sorted neighbors are close."""
    order = sorted(range(len(values)), key=values.__getitem__)
    groups = []
    for k in order:
        if groups and values[k] - values[groups[-1][-1]] <= STRAIGHT_CM / 100:
            groups[-1].append(k)
        else:
            groups.append([k])
    return groups


def lines(bodies, across, along) -> list:
    """Groups with about the same coordinate `across`, in the order of the other one, that stand side by side."""
    found = []
    for group in clusters([body.center[across] for body in bodies]):
        line = sorted((bodies[k] for k in group), key=lambda body: body.center[along])
        apart = all(b.center[along] - a.center[along] > 0.005 for a, b in zip(line, line[1:]))
        if len(line) > 1 and apart:
            found.append(line)
    return found


def is_circle(bodies) -> bool:
    if len(bodies) < 3:
        return False
    center = [sum(body.center[k] for body in bodies) / len(bodies) for k in (0, 1)]
    radii = [math.hypot(body.center[0] - center[0], body.center[1] - center[1]) for body in bodies]
    return min(radii) > 0.02 and max(radii) - min(radii) <= ROUND * max(radii)


def is_grid(bodies) -> bool:
    rows, columns = (clusters([body.center[k] for body in bodies]) for k in (1, 0))
    return len(rows) > 1 and len(columns) > 1 and len(rows) * len(columns) == len(bodies)


def is_pile(bodies) -> bool:
    """Every one is near another, or on one."""
    return len(bodies) > 1 and all(
        any(gap_cm(a, b) <= PILE_CM for b in bodies if b is not a) for a in bodies
    )


def is_pyramid(bodies) -> bool:
    """Layers of fewer and fewer, the topmost above the lowest."""
    layers = [len(group) for group in clusters([body.bottom_m for body in bodies])]
    return len(layers) > 1 and all(a > b for a, b in zip(layers, layers[1:]))
