"""What a finished scene shows: a view of scene.json for `expectations.py`, measured from poses and boxes.

Colors, materials and states are those of the description of the same text and seed, whose objects have the names of the
instances; everything else is measured. Left, right, front and behind, on, in and next to are those of `places.py`, as
the person at the target sees them where the description says so (`seated`). The
tolerances are the constants below; distances are between the outlines from above.
"""

import dataclasses
import itertools
import math

from tabletopgen_checks.language.description import chains
from tabletopgen_checks.scene.places import Thing, holds, stands_on
from tabletopgen_checks.scene.polygons import distance_m

# Neighbors of a row, a column or a grid line deviate at most this much from a straight line.
STRAIGHT_CM = 3.0
# The radii of a circle differ at most by this share.
ROUND = 0.2
FACING_DEG = 25.0
PARALLEL_DEG = 10.0
# What is around a target is at most this far from it.
AROUND_CM = 35.0
# Members of a pile touch or nearly touch another.
PILE_CM = 3.0
# Cosines of the tilt up to which an object is upright, and from which on it lies.
UPRIGHT, LYING = 0.9, 0.35
# The center and the sides of a table are thirds of its extents.
THIRD = 1 / 6

DIRECTIONS = {"left_of": "left", "right_of": "right", "in_front_of": "front", "behind": "behind", "next_to": "next"}
EDGES = {"from_left_edge": (0, -1), "from_right_edge": (0, 1), "from_front_edge": (1, -1), "from_back_edge": (1, 1)}


class Measured:
    """`described` is the view of the description of which scene.json is the scene."""

    def __init__(self, scene: dict, described):
        self.things = {instance["name"]: Thing(instance) for instance in scene["instances"]}
        self.described = described
        found = [item for item in described.objects if item.name in self.things]
        self.objects = [measured(item, self.things[item.name]) for item in found]
        self.by_name = {item.name: item for item in self.objects}
        outline = scene["table"]["outline_m"]
        self.edges = list(zip(outline, outline[1:] + outline[:1]))
        self.low = [min(corner[k] for corner in outline) for k in (0, 1)]
        self.high = [max(corner[k] for corner in outline) for k in (0, 1)]
        self.table = {"shape": scene["table"]["shape"], "size_cm": [100 * side for side in scene["table"]["size_m"]]}
        self.excluded, self.reported = described.excluded, described.reported
        self.corrected, self.goal = described.corrected, described.goal

    def differences(self) -> list:
        """Objects of the description that the scene lacks, and the reverse."""
        asked = {item.name: item.category for item in self.described.objects}
        found = {name: thing.category for name, thing in self.things.items()}
        return [f"{name} is not in the scene" for name in sorted(asked.keys() - found.keys())] + [
            f"{name} is only in the scene" for name in sorted(found.keys() - asked.keys())
        ]

    def related(self, kind, name, target, second=None) -> bool:
        thing, other = self.things[name], self.things.get(target)
        if kind.startswith("at_"):
            return self.is_at(thing, kind.split("_")[1:])
        if kind in EDGES:
            return True
        if other is None:
            return False
        if kind in DIRECTIONS:
            if (name, target) in self.described.seated:
                turn_rad = -self.seat_yaw_rad(other)
                thing, other = thing.turned(turn_rad), other.turned(turn_rad)
            return holds(thing, DIRECTIONS[kind], other, self.things)
        if kind in ("on", "in"):
            return holds(thing, kind, other, self.things)
        if kind == "stacked_on":
            return stands_on(thing, other, self.things)
        if kind == "between":
            return is_between(thing, other, self.things[second])
        if kind == "facing":
            return angle_deg(front(thing), toward(thing, other)) <= FACING_DEG
        if kind == "parallel_to":
            turn = angle_deg(long_side(thing), long_side(other))
            return min(turn, 180 - turn) <= PARALLEL_DEG
        if kind == "around":
            return gap_cm(thing, other) <= AROUND_CM
        raise ValueError(f"no measure of the relation {kind}")

    def seat_yaw_rad(self, thing) -> float:
        """Yaw of the person at a thing, who faces away from the nearest edge; 0 at the front edge."""
        way = min((nearest(thing.center, *edge) for edge in self.edges), key=lambda way: math.hypot(*way))
        return math.atan2(way[1], way[0]) + math.pi / 2

    def is_at(self, thing, words) -> bool:
        shares = [
            (thing.center[k] - 0.5 * (self.low[k] + self.high[k])) / (self.high[k] - self.low[k]) for k in (0, 1)
        ]
        sides = {"left": shares[0] < -THIRD, "right": shares[0] > THIRD, "front": shares[1] < -THIRD,
                 "back": shares[1] > THIRD, "center": max(map(abs, shares)) <= THIRD}
        return all(sides[word] for word in words)

    def distances_cm(self, kind, name, target) -> list:
        thing = self.things[name]
        if kind in EDGES:
            axis, side = EDGES[kind]
            edge = self.high[axis] - thing.high[axis] if side > 0 else thing.low[axis] - self.low[axis]
            return [100 * edge]
        return [gap_cm(thing, self.things[target])] if target in self.things else []

    def arranged(self, kind, names) -> list:
        things = [self.things[name] for name in names]
        if kind == "stack":
            found = chains(names, lambda a, b: stands_on(self.things[a], self.things[b], self.things))
            return [(chain, None) for chain in found]
        groups = {
            "row": lambda: lines(things, 1, 0),
            "column": lambda: lines(things, 0, 1),
            "circle": lambda: [things] if is_circle(things) else [],
            "grid": lambda: [things] if is_grid(things) else [],
            "pile": lambda: [things] if is_pile(things) else [],
            "pyramid": lambda: [things] if is_pyramid(things) else [],
        }[kind]()
        return [([thing.name for thing in group], smallest_gap_cm(group)) for group in groups]


def measured(item, thing):
    """The described object with the measured size, pose, yaw and position."""
    up = thing.axes[2][2]
    pose = "lying_on_side" if abs(up) <= LYING else "tilted"
    if abs(up) >= UPRIGHT:
        pose = "upright" if up > 0 else "upside_down"
    return dataclasses.replace(
        item,
        size_cm=tuple(100 * side for side in thing.size),
        pose=pose,
        yaw_deg=math.degrees(math.atan2(thing.axes[0][1], thing.axes[0][0])),
        position_cm=tuple(100 * thing.center[k] for k in (0, 1)),
    )


def gap_cm(a, b) -> float:
    """Horizontal distance of the footprints, or of the boxes where one is not known."""
    if a.footprint and b.footprint:
        return 100 * max(0.0, distance_m(a.footprint, b.footprint))
    return 100 * math.hypot(*(max(a.low[k] - b.high[k], b.low[k] - a.high[k], 0.0) for k in (0, 1)))


def smallest_gap_cm(things):
    gaps = [gap_cm(a, b) for a, b in itertools.combinations(things, 2)]
    return min(gaps) if gaps else None


def nearest(point, start, end) -> tuple:
    """The way from a point to the nearest point of a segment."""
    along = [end[k] - start[k] for k in (0, 1)]
    share = sum((point[k] - start[k]) * along[k] for k in (0, 1)) / (along[0] ** 2 + along[1] ** 2)
    share = max(0.0, min(1.0, share))
    return tuple(start[k] + share * along[k] - point[k] for k in (0, 1))


def toward(a, b) -> tuple:
    return tuple(b.center[k] - a.center[k] for k in (0, 1))


def front(thing) -> tuple:
    """The horizontal direction of the front: -y of the object."""
    return tuple(-thing.axes[1][k] for k in (0, 1))


def long_side(thing) -> tuple:
    return tuple(thing.axes[0 if thing.size[0] >= thing.size[1] else 1][k] for k in (0, 1))


def angle_deg(a, b) -> float:
    length = math.hypot(*a) * math.hypot(*b)
    if length == 0:
        return 180.0
    return math.degrees(math.acos(max(-1.0, min(1.0, (a[0] * b[0] + a[1] * b[1]) / length))))


def is_between(thing, first, second) -> bool:
    """Its center projects between the centers, no farther aside than half of the larger box or a quarter of the way."""
    way = toward(first, second)
    length = math.hypot(*way)
    if length == 0:
        return False
    at = toward(first, thing)
    along = (at[0] * way[0] + at[1] * way[1]) / length
    aside = abs(at[0] * way[1] - at[1] * way[0]) / length
    half = max(0.5 * (box.high[k] - box.low[k]) for box in (first, second) for k in (0, 1))
    return 0 < along < length and aside <= max(half, 0.25 * length)


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


def lines(things, across, along) -> list:
    """Groups with about the same coordinate `across`, in the order of the other one, that stand side by side."""
    found = []
    for group in clusters([thing.center[across] for thing in things]):
        line = sorted((things[k] for k in group), key=lambda thing: thing.center[along])
        apart = all(b.center[along] - a.center[along] > 0.005 for a, b in zip(line, line[1:]))
        if len(line) > 1 and apart:
            found.append(line)
    return found


def is_circle(things) -> bool:
    if len(things) < 3:
        return False
    middle = [sum(thing.center[k] for thing in things) / len(things) for k in (0, 1)]
    radii = [math.hypot(thing.center[0] - middle[0], thing.center[1] - middle[1]) for thing in things]
    return min(radii) > 0.02 and max(radii) - min(radii) <= ROUND * max(radii)


def is_grid(things) -> bool:
    rows, columns = (clusters([thing.center[k] for thing in things]) for k in (1, 0))
    return len(rows) > 1 and len(columns) > 1 and len(rows) * len(columns) == len(things)


def is_pile(things) -> bool:
    """Every one is near another, or on one."""
    return len(things) > 1 and all(
        any(gap_cm(a, b) <= PILE_CM for b in things if b is not a) for a in things
    )


def is_pyramid(things) -> bool:
    """Layers of fewer and fewer, the topmost above the lowest."""
    layers = [len(group) for group in clusters([thing.low[2] for thing in things])]
    return len(layers) > 1 and all(a > b for a, b in zip(layers, layers[1:]))
