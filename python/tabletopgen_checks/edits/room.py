"""Is there room for an object? A search through every centimeter and sixteen yaws, to check refusals.

A hull counts as the prism over its footprint between its lowest and its highest point. That takes more room than the
hull, so a place that is found is free; one that is not found proves nothing. An object stands on a level: the table
top, or the flat top of a hull of the object that carries it, with its center of mass above that top. So nothing stands
on the rim of a plate.
"""

import math
from dataclasses import dataclass

from tabletopgen_checks.scene.polygons import (
    area_m2,
    bounds,
    center_of,
    convex_hull,
    depth_m,
    minkowski_sum,
    outline_holds,
    rows_of,
    shifted,
    sides,
    simplified,
    turned,
)
from tabletopgen_checks.scene.scene import TABLE, Body, Scene

STEP_M = 0.01
YAWS = 16
CLEARANCE_M = 0.01
# An object to place is searched with so many prisms, one above the other.
LAYERS = 4
# Hulls that touch do not overlap in height.
TOUCH_M = 0.001
# What is no lower than this below the highest point of a hull is its top.
TOP_M = 0.002


@dataclass
class Prism:
    polygon: list
    low_m: float
    high_m: float


@dataclass
class Shape:
    """An object to place: prisms about its center, above its lowest point; the horizontal center of mass; its yaw."""

    prisms: list
    center_of_mass: tuple = (0.0, 0.0)
    yaw_rad: float = 0.0


@dataclass
class FreePlace:
    """A free place, with what `scene/relations.py` needs of a body."""

    footprint: list
    center: tuple
    yaw_rad: float
    bottom_m: float
    top_m: float

    def bounds(self) -> tuple:
        return bounds(self.footprint)

    def extent_m(self, way) -> float:
        x, y = self.center
        return max(0.0, max((p - x) * way[0] + (q - y) * way[1] for p, q in self.footprint))

    def front(self) -> tuple:
        return math.sin(self.yaw_rad), -math.cos(self.yaw_rad)


def prism(hull, shift=(0.0, 0.0), floor_m=0.0) -> Prism:
    polygon = shifted(convex_hull([point[:2] for point in hull]), (-shift[0], -shift[1]))
    heights = [point[2] - floor_m for point in hull]
    return Prism(polygon, min(heights), max(heights))


def shape_of(body: Body, factor: float = 1.0) -> Shape:
    """As it stands, `factor` times as large."""
    prisms = [prism(hull, body.center, body.bottom_m) for hull in body.hulls]
    for one in prisms:
        one.polygon = [(factor * x, factor * y) for x, y in one.polygon]
        one.low_m, one.high_m = factor * one.low_m, factor * one.high_m
    balance = tuple(factor * (body.center_of_mass_m[k] - body.center[k]) for k in (0, 1))
    return Shape(prisms, balance, body.yaw_rad or 0.0)


def box(size_m) -> Shape:
    x, y, z = 0.5 * size_m[0], 0.5 * size_m[1], size_m[2]
    return Shape([Prism([(-x, -y), (x, -y), (x, y), (-x, y)], 0.0, z)])


def obstacles_of(scene: Scene, left_out=()) -> list:
    """The prisms of everything on the table but for some names."""
    bodies = [body for name, body in scene.bodies.items() if name not in left_out]
    return [prism(hull) for hull in scene.table_hulls] + [prism(hull) for body in bodies for hull in body.hulls]


def levels_of(scene: Scene, supporter: str) -> list:
    """(height, polygons that carry) of the table or of an object, the lowest first."""
    if supporter == TABLE:
        return [(0.0, None)]
    tops = {}
    for hull in scene.bodies[supporter].hulls:
        high_m = max(point[2] for point in hull)
        tops.setdefault(round(high_m / TOUCH_M), []).append((high_m, top_of(hull)))
    return [(max(high_m for high_m, _ in found), [top for _, top in found]) for _, found in sorted(tops.items())]


def top_of(hull) -> list:
    """The polygon of what is highest of a hull."""
    high_m = max(point[2] for point in hull)
    return convex_hull([point[:2] for point in hull if point[2] > high_m - TOP_M])


def free_place(
    scene: Scene, shape: Shape, obstacles: list, levels: list, accepts=lambda found: True, yaws=None,
    clearance_m: float = CLEARANCE_M, around=None
) -> FreePlace | None:
    """The first free place that `accepts`; `around` = (center, half a side) bounds the search to a square.

    Yaws are added to that of the shape; all sixteen unless they are given.
    """
    yaws = [2 * math.pi * k / YAWS for k in range(YAWS)] if yaws is None else yaws
    layers = layered(shape.prisms)
    for height_m, carriers in levels:
        low, high = bounds(scene.outline) if carriers is None else bounds([p for part in carriers for p in part])
        first, counts = grid(low, high, around)
        for yaw in yaws:
            prisms = [Prism(turned(one.polygon, yaw), one.low_m, one.high_m) for one in layers]
            footprint = simplified(convex_hull([corner for one in prisms for corner in one.polygon]))
            limits = [] if carriers is not None else outline_limits(scene.outline, footprint, max(0.0, clearance_m))
            free = free_cells(prisms, obstacles, height_m, first, counts, clearance_m, limits)
            balance = turned([shape.center_of_mass], yaw)[0]
            for row, column in free:
                center = (first[0] + column * STEP_M, first[1] + row * STEP_M)
                over = (center[0] + balance[0], center[1] + balance[1])
                if carriers is not None and all(depth_m(part, over) < clearance_m for part in carriers):
                    continue
                corners = shifted(footprint, center)
                top_m = height_m + max(one.high_m for one in prisms)
                found = FreePlace(corners, center_of(corners), shape.yaw_rad + yaw, height_m, top_m)
                # What stands on an object may stick out over the edge of the table.
                is_inside = carriers is not None or limits
                if accepts(found) and (is_inside or outline_holds(scene.outline, corners, max(0.0, clearance_m))):
                    return found
    return None


def grid(low, high, around) -> tuple:
    """(first point, (columns, rows))."""
    if around is not None:
        center, half_m = around
        steps = round(half_m / STEP_M)
        return (center[0] - steps * STEP_M, center[1] - steps * STEP_M), (2 * steps + 1, 2 * steps + 1)
    return low, tuple(int((high[k] - low[k]) / STEP_M) + 1 for k in (0, 1))


def layered(prisms: list) -> list:
    """At most `LAYERS` prisms that enclose the prisms: the convex footprint of what is at each height."""
    low, high = min(one.low_m for one in prisms), max(one.high_m for one in prisms)
    if len(prisms) <= LAYERS:
        return prisms
    found, step = [], (high - low) / LAYERS
    for k in range(LAYERS):
        start, end = low + k * step, low + (k + 1) * step
        corners = [corner for one in prisms if one.low_m < end and one.high_m > start for corner in one.polygon]
        if corners:
            found.append(Prism(convex_hull(corners), start, end))
    return found


def outline_limits(outline, footprint, margin_m) -> list:
    """Half-planes (x, y, limit) of centers that keep the footprint inside a convex outline; none for a concave one."""
    hull = convex_hull(outline)
    if area_m2(hull) - abs(area_m2(outline)) > 1e-6:
        return []
    limits = []
    for (x, y), (u, v) in sides(hull):
        length = math.hypot(u - x, v - y)
        nx, ny = (v - y) / length, (x - u) / length
        reach_m = max(p * nx + q * ny for p, q in footprint)
        limits.append((nx, ny, x * nx + y * ny - reach_m - margin_m))
    return limits


def free_cells(prisms, obstacles, height_m, first, counts, clearance_m, limits=()):
    """(row, column) of the centers within the limits with nothing nearer to a prism than the clearance."""
    columns, count = counts
    blocked = [bytearray(columns) for _ in range(count)]
    for row in range(count if limits else 0):
        low, high, y = first[0], first[0] + columns * STEP_M, first[1] + row * STEP_M
        for nx, ny, limit in limits:
            if abs(nx) < 1e-12:
                high = high if ny * y <= limit else low - STEP_M
            elif nx > 0:
                high = min(high, (limit - ny * y) / nx)
            else:
                low = max(low, (limit - ny * y) / nx)
        start = min(columns, max(0, math.ceil((low - first[0]) / STEP_M)))
        end = max(start, min(columns, math.floor((high - first[0]) / STEP_M) + 1))
        blocked[row][:start], blocked[row][end:] = b"\1" * start, b"\1" * (columns - end)
    ring = octagon(max(0.0, clearance_m))
    for one in prisms:
        mirrored = minkowski_sum(convex_hull([(-x, -y) for x, y in one.polygon]), ring)
        low_m, high_m = height_m + one.low_m + TOUCH_M, height_m + one.high_m - TOUCH_M
        for other in obstacles:
            if low_m < other.high_m and other.low_m < high_m:
                forbidden = minkowski_sum(other.polygon, mirrored)
                for row, (low, high) in rows_of(forbidden, first[1], STEP_M, count).items():
                    start = max(0, math.ceil((low - first[0]) / STEP_M))
                    end = min(columns, math.floor((high - first[0]) / STEP_M) + 1)
                    if start < end:
                        blocked[row][start:end] = b"\1" * (end - start)
    for row, cells in enumerate(blocked):
        column = cells.find(0)
        while column >= 0:
            yield row, column
            column = cells.find(0, column + 1)


def octagon(radius_m: float) -> list:
    """Around the circle, so that nothing is nearer than the radius."""
    if radius_m == 0.0:
        return [(0.0, 0.0)]
    outer = radius_m / math.cos(math.pi / 8)
    corners = [math.pi / 8 + k * math.pi / 4 for k in range(8)]
    return [(outer * math.cos(angle), outer * math.sin(angle)) for angle in corners]
