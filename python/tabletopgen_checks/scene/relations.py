"""Whether a relation holds between bodies of a finished scene: the one statement of what in, on, next to and left of
mean.

Written again from the documented tolerances of the program: distances 1 cm, yaws and facing 10 degrees, positions 2 cm,
next to at most 15 cm apart, contacts 1.5 cm, overlap along a direction 1.5 cm, regions a twentieth of half the table.
The center of what is stacked on an object is above the center of that.
"""

import math

from tabletopgen_checks.scene.polygons import bounds, depth_m, distance_m

DISTANCE_TOLERANCE_M = 0.01
YAW_TOLERANCE_RAD = math.radians(10)
POSITION_TOLERANCE_M = 0.02
NEXT_TO_M = 0.15
CONTACT_TOLERANCE_M = 0.015
DIRECTION_OVERLAP_M = 0.015
REGION_TOLERANCE = 0.05
ROUNDING = 1e-9

DIRECTIONS = {"left_of": (-1, 0), "right_of": (1, 0), "in_front_of": (0, -1), "behind": (0, 1)}
# Shares of half the box of the table, from -1 to 1: (low x, low y), (high x, high y).
THIRD = 1 / 3
REGIONS = {
    "at_center": ((-0.4, -0.4), (0.4, 0.4)),
    "at_back": ((-1, 0.12), (1, 1)),
    "at_front": ((-1, -1), (1, -0.12)),
    "at_left": ((-1, -1), (-0.2, 1)),
    "at_right": ((0.2, -1), (1, 1)),
    "at_back_left": ((-1, THIRD), (-THIRD, 1)),
    "at_back_right": ((THIRD, THIRD), (1, 1)),
    "at_front_left": ((-1, -1), (-THIRD, -THIRD)),
    "at_front_right": ((THIRD, -1), (1, -THIRD)),
}
# The axis, and the side on it.
EDGES = {"from_left_edge": (0, -1), "from_right_edge": (0, 1), "from_front_edge": (1, -1), "from_back_edge": (1, 1)}


def holds(kind, body, outline, target=None, second=None, stated_m=None) -> bool:
    """Whether `body` stands in the relation to `target`, or to the table without one.

    A body has `footprint`, `center`, `bounds()`, `extent_m(way)`, `front()`, `bottom_m` and `top_m`.
    """
    if kind in ("on", "in", "stacked_on") and target is None:
        return abs(body.bottom_m) <= CONTACT_TOLERANCE_M
    if kind in REGIONS and target is None:
        return is_in_region(kind, body.center, outline)
    if kind in EDGES and target is None:
        free_m = edge_distance_m(kind, body, outline)
        return free_m <= NEXT_TO_M if stated_m is None else is_close(free_m, stated_m)
    if target is None:
        return kind == "facing" and faces(body, center_of_table(outline))
    if kind in ("on", "stacked_on"):
        if kind == "stacked_on" and body.bottom_m + body.top_m <= target.bottom_m + target.top_m:
            return False
        return is_above(body, target) and target.bottom_m + 0.001 < body.bottom_m <= target.top_m + CONTACT_TOLERANCE_M
    if kind == "in":
        return is_above(body, target) and target.bottom_m - 0.002 < body.bottom_m < target.top_m
    if kind in DIRECTIONS:
        # The distance takes the longest.
        if not is_toward(body, target, DIRECTIONS[kind]):
            return False
        return stated_m is None or is_apart_by(body, target, stated_m)
    if kind == "next_to":
        if lowest_distance_m(body, target) > (NEXT_TO_M if stated_m is None else stated_m + DISTANCE_TOLERANCE_M):
            return False
        free_m = distance_m(body.footprint, target.footprint)
        near = free_m <= NEXT_TO_M if stated_m is None else is_close(free_m, stated_m)
        return near and free_m > -DISTANCE_TOLERANCE_M
    if kind == "between":
        return second is not None and is_between(body, target, second)
    if kind == "facing":
        return faces(body, target.center)
    raise ValueError(f"no measure of the relation {kind}")


def is_close(found_m, stated_m) -> bool:
    return abs(found_m - stated_m) <= DISTANCE_TOLERANCE_M + ROUNDING


def is_apart_by(body, target, stated_m) -> bool:
    if lowest_distance_m(body, target) > stated_m + DISTANCE_TOLERANCE_M + ROUNDING:
        return False
    return is_close(distance_m(body.footprint, target.footprint), stated_m)


def lowest_distance_m(body, target) -> float:
    """A lower bound of the free distance: that of the circles around the footprints."""
    reach_m = sum(max(math.dist(one.center, corner) for corner in one.footprint) for one in (body, target))
    return math.dist(body.center, target.center) - reach_m


def is_above(body, target) -> bool:
    return depth_m(target.footprint, body.center) > -DISTANCE_TOLERANCE_M


def is_toward(body, target, way) -> bool:
    across_way = (-way[1], way[0])
    offset = [body.center[k] - target.center[k] for k in (0, 1)]
    along = offset[0] * way[0] + offset[1] * way[1]
    across = abs(offset[0] * across_way[0] + offset[1] * across_way[1])
    clear_m = along - body.extent_m((-way[0], -way[1])) - target.extent_m(way)
    beside = max(along, target.extent_m(across_way))
    return along > 0 and clear_m >= -DIRECTION_OVERLAP_M and across <= beside + ROUNDING


def is_between(body, first, second) -> bool:
    way = [second.center[k] - first.center[k] for k in (0, 1)]
    offset = [body.center[k] - first.center[k] for k in (0, 1)]
    length_m = math.hypot(*way)
    if length_m < 1e-6:
        return False
    share = (offset[0] * way[0] + offset[1] * way[1]) / length_m**2
    aside_m = abs(offset[0] * way[1] - offset[1] * way[0]) / length_m
    near = THIRD <= share <= 2 * THIRD and aside_m <= max(0.25 * length_m, 0.02)
    return near and all(distance_m(body.footprint, other.footprint) >= 0.0 for other in (first, second))


def center_of_table(outline) -> tuple:
    low, high = bounds(outline)
    return tuple(0.5 * (low[k] + high[k]) for k in (0, 1))


def faces(body, point) -> bool:
    toward = [point[k] - body.center[k] for k in (0, 1)]
    front = body.front()
    if math.hypot(*toward) < 1e-6:
        return True
    off = math.atan2(front[0] * toward[1] - front[1] * toward[0], front[0] * toward[0] + front[1] * toward[1])
    return abs(off) <= YAW_TOLERANCE_RAD + ROUNDING


def is_in_region(kind, point, outline) -> bool:
    low, high = bounds(outline)
    shares = [(2 * point[k] - low[k] - high[k]) / (high[k] - low[k]) for k in (0, 1)]
    from_share, to_share = REGIONS[kind]
    return all(from_share[k] - REGION_TOLERANCE <= shares[k] <= to_share[k] + REGION_TOLERANCE for k in (0, 1))


def edge_distance_m(kind, body, outline) -> float:
    axis, side = EDGES[kind]
    low, high = body.bounds()
    table_low, table_high = bounds(outline)
    return table_high[axis] - high[axis] if side > 0 else low[axis] - table_low[axis]
