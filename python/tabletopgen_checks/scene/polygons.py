"""Polygons in the plane for the checker of edits: hulls, signed distances, and rows that a polygon covers.

Points are (x, y) in meters. Convex polygons are counter-clockwise; an outline may be concave.
"""

import math


def convex_hull(points) -> list:
    """Counter-clockwise corners without collinear ones."""
    points = sorted(set(map(tuple, points)))
    if len(points) < 3:
        return points
    return half_hull(points)[:-1] + half_hull(points[::-1])[:-1]


def half_hull(points) -> list:
    chain = []
    for point in points:
        while len(chain) > 1 and cross(chain[-2], chain[-1], point) <= 0.0:
            chain.pop()
        chain.append(point)
    return chain


def cross(a, b, c) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def area_m2(polygon) -> float:
    return 0.5 * sum(a[0] * b[1] - a[1] * b[0] for a, b in sides(polygon))


def sides(polygon):
    return zip(polygon, polygon[1:] + polygon[:1])


def bounds(points) -> tuple:
    """((low x, low y), (high x, high y))."""
    return tuple(tuple(choose(point[k] for point in points) for k in (0, 1)) for choose in (min, max))


def center_of(points) -> tuple:
    """Center of the axis-aligned box."""
    low, high = bounds(points)
    return tuple(0.5 * (low[k] + high[k]) for k in (0, 1))


def turned(points, angle_rad: float) -> list:
    """Points turned about the origin, counter-clockwise."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return [(c * x - s * y, s * x + c * y) for x, y in points]


def shifted(points, by) -> list:
    return [(x + by[0], y + by[1]) for x, y in points]


def segment_distance_m(point, a, b) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    along = ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / max(dx * dx + dy * dy, 1e-300)
    along = min(1.0, max(0.0, along))
    return math.hypot(point[0] - a[0] - along * dx, point[1] - a[1] - along * dy)


def depth_m(polygon, point) -> float:
    """Distance of a point to the edge of a convex polygon, a segment or a point; positive inside."""
    nearest = min(segment_distance_m(point, a, b) for a, b in sides(polygon))
    inside = len(polygon) >= 3 and all(cross(a, b, point) >= 0.0 for a, b in sides(polygon))
    return nearest if inside else -nearest


def distance_m(a, b) -> float:
    """Signed distance of convex polygons: negative by the shortest shift that separates them where they overlap."""
    separation = max(separation_m(a, b), separation_m(b, a))
    if separation < 0.0:
        return separation
    apart = [-depth_m(b, point) for point in a] + [-depth_m(a, point) for point in b]
    return max(0.0, min(apart))


def separation_m(a, b) -> float:
    """Largest separation along the outward normals of `a`."""
    found = -math.inf
    for (x, y), (u, v) in sides(a):
        length = math.hypot(u - x, v - y)
        if length > 0.0:
            nx, ny = (v - y) / length, (x - u) / length
            found = max(found, min((p - x) * nx + (q - y) * ny for p, q in b))
    return found


def simplified(polygon, tolerance_m: float = 0.001) -> list:
    """A convex polygon with fewer corners: those that are left out lie within the tolerance of it."""
    kept = list(polygon)
    for corner in polygon:
        if len(kept) > 8:
            k = kept.index(corner)
            # Between the neighbors that are left, all the corners that were left out count.
            first, last = kept[k - 1], kept[(k + 1) % len(kept)]
            start, end = polygon.index(first), polygon.index(last)
            between = polygon[start:end] if start < end else polygon[start:] + polygon[:end]
            if all(segment_distance_m(point, first, last) <= tolerance_m for point in between):
                kept.remove(corner)
    return kept


def outline_depth_m(outline, point) -> float:
    """Distance of a point to the edge of a simple polygon; positive inside."""
    inside = False
    for a, b in sides(outline):
        if (a[1] > point[1]) != (b[1] > point[1]):
            inside ^= point[0] < a[0] + (b[0] - a[0]) * (point[1] - a[1]) / (b[1] - a[1])
    nearest = min(segment_distance_m(point, a, b) for a, b in sides(outline))
    return nearest if inside else -nearest


def outline_holds(outline, polygon, margin_m: float) -> bool:
    """Whether a convex polygon lies inside a simple one, this far from its edge."""
    if any(outline_depth_m(outline, corner) < margin_m for corner in polygon):
        return False
    # A notch of the outline may reach in between the corners.
    return all(depth_m(polygon, corner) <= -margin_m + 1e-9 for corner in outline)


def minkowski_sum(a, b) -> list:
    """Of convex polygons, by merging their edges in the order of their directions."""
    if len(a) < 3 or len(b) < 3:
        return convex_hull([(p[0] + q[0], p[1] + q[1]) for p in a for q in b])
    a, b = from_lowest(a), from_lowest(b)
    total, i, j = [], 0, 0
    while i < len(a) or j < len(b):
        total.append((a[i % len(a)][0] + b[j % len(b)][0], a[i % len(a)][1] + b[j % len(b)][1]))
        u, v = edge(a, i), edge(b, j)
        turn = u[0] * v[1] - u[1] * v[0]
        # The edges that are left at the end come after all others.
        step_a = j >= len(b) or (i < len(a) and turn >= 0.0)
        step_b = i >= len(a) or (j < len(b) and turn <= 0.0)
        i, j = i + step_a, j + step_b
    return total


def edge(polygon, k) -> tuple:
    a, b = polygon[k % len(polygon)], polygon[(k + 1) % len(polygon)]
    return b[0] - a[0], b[1] - a[1]


def from_lowest(polygon) -> list:
    first = min(range(len(polygon)), key=lambda k: (polygon[k][1], polygon[k][0]))
    return polygon[first:] + polygon[:first]


def rows_of(polygon, first_y: float, step_m: float, count: int) -> dict:
    """Row number to (low x, high x) of the rows y = first_y + k step_m, 0 <= k < count, that cross a convex polygon."""
    found = {}
    for (x, y), (u, v) in sides(polygon):
        if y > v:
            x, y, u, v = u, v, x, y
        for row in range(max(0, math.ceil((y - first_y) / step_m)), count):
            at = first_y + row * step_m
            if at > v:
                break
            cut = x if v - y < 1e-12 else x + (u - x) * (at - y) / (v - y)
            low, high = found.get(row, (cut, cut))
            found[row] = min(low, cut), max(high, cut)
    return found
