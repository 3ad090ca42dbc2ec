"""Is a refusal right? Each operation that was refused is tried by the search of `edit_room` in the scene before it."""

import math

from tabletopgen_checks.catalog import CATEGORIES
from tabletopgen_checks.edits.room import box, free_place, levels_of, obstacles_of, prism, shape_of, top_of
from tabletopgen_checks.scene.polygons import shifted, turned
from tabletopgen_checks.scene.relations import NEXT_TO_M, POSITION_TOLERANCE_M, holds
from tabletopgen_checks.scene.scene import TABLE, Scene, wrapped_rad

# An object of clutter is taken to be this large.
CLUTTER_M = (0.12, 0.12, 0.12)
# Yaws of an object with its sides along the edges of the table.
QUARTERS = [0.5 * math.pi * k for k in range(4)]


def place_for(operation, scene: Scene, names=lambda words: words) -> str:
    """Words about a place for the operation in a scene; empty where the search finds none.

    `names` gives the names in the scene of targets and references. Operations that need no room are always possible.
    """
    targets = [name for name in names(operation.targets) if name in scene.bodies]
    references = [name for name in names(operation.references) if name in scene.bodies]
    search = {
        "add": add, "move": move, "rotate": rotate, "resize": resize, "replace": replace, "stack": stack, "tidy": tidy,
        "clutter": clutter, "remove": remove,
    }.get(operation.name)
    if search is None:
        return f"{operation.name} needs no room"
    found = search(operation, scene, targets, references)
    return f"there is room at {found}" if found else ""


def in_words(place) -> str:
    degrees = math.degrees(place.yaw_rad)
    return f"({place.center[0]:.2f}, {place.center[1]:.2f}) m, height {place.bottom_m:.3f} m, yaw {degrees:.0f} degrees"


def add(operation, scene, targets, references) -> str:
    """Boxes of the largest size of the category, one after another."""
    sizes = [CATEGORIES[category].high_m for category in operation.categories if category in CATEGORIES]
    if not sizes:
        return ""
    shape, obstacles, found = box(max(sizes, key=math.prod)), obstacles_of(scene), None
    for _ in range(operation.count):
        found = placed(shape, operation.wire.get("where") or {"relation": "on"}, scene, references, obstacles)
        if found is None:
            return ""
        obstacles = obstacles + occupied(shape, found)
    return in_words(found)


def move(operation, scene, targets, references) -> str:
    if not targets:
        return ""
    body = scene.bodies[targets[0]]
    left_out = [body.name, *scene.contents(body.name)]
    shape = shape_of(body)
    for name in left_out[1:]:
        inner = scene.bodies[name]
        shape.prisms += [prism(hull, body.center, body.bottom_m) for hull in inner.hulls]
    place = operation.wire["where"]
    if "offset_m" in place:
        place = {"position_m": [body.center[k] + place["offset_m"][k] for k in (0, 1)]}
    found = placed(shape, place, scene, references, obstacles_of(scene, left_out))
    return in_words(found) if found else ""


def placed(shape, place, scene, references, obstacles):
    """A free place that satisfies a `where`."""
    bodies = [scene.bodies[name] for name in references]
    target, second = (bodies + [None, None])[:2]
    relation, yaws, around = place.get("relation"), None, None
    if "yaw_rad" in place:
        yaws = [place["yaw_rad"] - shape.yaw_rad]
    if "position_m" in place:
        around = (tuple(place["position_m"]), 0.5 * POSITION_TOLERANCE_M)
        return free_place(scene, shape, obstacles, levels_of(scene, TABLE), yaws=yaws, around=around)
    supporter = target.name if relation in ("on", "in") and target is not None else TABLE
    levels = levels_of(scene, supporter)
    if relation == "in" and target is not None:
        levels = [level for level in levels if level[0] < target.top_m - 0.002]

    def accepts(found):
        return holds(relation, found, scene.outline, target, second, place.get("distance_m"))

    if target is not None and (relation == "next_to" or "distance_m" in place):
        reach_m = place.get("distance_m", NEXT_TO_M) + radius_m(target.footprint, target.center)
        reach_m += max(radius_m(one.polygon, (0.0, 0.0)) for one in shape.prisms)
        around = (target.center, reach_m)
    return free_place(scene, shape, obstacles, levels, accepts, yaws, around=around)


def radius_m(polygon, center) -> float:
    return max(math.dist(corner, center) for corner in polygon)


def occupied(shape, found) -> list:
    """The prisms of a shape at its place."""
    turn = found.yaw_rad - shape.yaw_rad
    low = [(corner, one) for one in shape.prisms for corner in one.polygon]
    hull = []
    for (x, y), one in low:
        c, s = math.cos(turn), math.sin(turn)
        at = (c * x - s * y + found.center[0], s * x + c * y + found.center[1])
        hull += [(*at, found.bottom_m + one.low_m), (*at, found.bottom_m + one.high_m)]
    return [prism(hull)]


def in_place(scene, name, shape, yaws, around=None) -> str:
    """A place within the tolerance of the present one, or `around` another, at its height."""
    body = scene.bodies[name]
    obstacles = obstacles_of(scene, [name, *scene.contents(name)])
    # What carries it was at rest below it before.
    levels = [(body.bottom_m, [body.footprint])] if body.parent != TABLE else levels_of(scene, TABLE)
    around = around or (body.center, POSITION_TOLERANCE_M)
    found = free_place(scene, shape, obstacles, levels, yaws=yaws, around=around)
    return in_words(found) if found else ""


def rotate(operation, scene, targets, references) -> str:
    if not targets:
        return ""
    body = scene.bodies[targets[0]]
    if body.yaw_rad is None:
        return ""
    if references:
        other = scene.bodies[references[0]]
        wanted = math.atan2(other.center[1] - body.center[1], other.center[0] - body.center[0]) + 0.5 * math.pi
    elif "by_rad" in operation.wire:
        wanted = body.yaw_rad + operation.wire["by_rad"]
    else:
        wanted = operation.wire["to_rad"]
    turn, origin = wrapped_rad(wanted - body.yaw_rad), body.pose[0][:2]
    # About the axis through its origin, and nowhere else.
    center = shifted(turned(shifted([body.center], (-origin[0], -origin[1])), turn), origin)[0]
    return in_place(scene, body.name, shape_of(body), [turn], (center, 0.0))


def resize(operation, scene, targets, references) -> str:
    """Where the catalog has no object of that size, the refusal is right."""
    if not targets:
        return ""
    body, factor = scene.bodies[targets[0]], operation.wire["factor"]
    if body.category in CATEGORIES:
        low, high = CATEGORIES[body.category].low_m, CATEGORIES[body.category].high_m
        longest = factor * max(body.size_m)
        if not max(low) <= longest <= max(high):
            return ""
    return in_place(scene, body.name, shape_of(body, factor), [0.0])


def replace(operation, scene, targets, references) -> str:
    sizes = [CATEGORIES[category].high_m for category in operation.categories if category in CATEGORIES]
    return in_place(scene, targets[0], box(max(sizes, key=math.prod)), None) if sizes and targets else ""


def stack(operation, scene, targets, references) -> str:
    """The largest at the bottom where it stands, or from the first; each on the top of the one below."""
    bodies = [scene.bodies[name] for name in targets]
    if len(operation.wire["targets"]) == 1:
        bodies.sort(key=lambda body: -math.prod(body.size_m))
    moving = {inner for body in bodies for inner in (body.name, *scene.contents(body.name))}
    obstacles = obstacles_of(scene, moving)
    if not bodies or any(scene.contents(body.name) for body in bodies):
        return ""
    below, found = bodies[0], None
    top, shift = [prism(hull) for hull in below.hulls], below.top_m
    carriers = [top_of(hull) for hull in below.hulls if max(point[2] for point in hull) >= shift - 0.001]
    for body in bodies[1:]:
        obstacles = obstacles + top
        shape = shape_of(body)
        found = free_place(scene, shape, obstacles, [(shift, carriers)])
        if found is None:
            return ""
        top, shift = occupied(shape, found), found.top_m
        carriers = [one.polygon for one in top]
    return in_words(found) if found else "its present place"


def tidy(operation, scene, targets, references) -> str:
    """Greedily, the largest first, with sides along the edges."""
    standing = sorted(
        (body for body in scene.bodies.values() if body.parent == TABLE), key=lambda body: -math.prod(body.size_m)
    )
    obstacles, found = [prism(hull) for hull in scene.table_hulls], None
    for body in standing:
        shape = shape_of(body)
        for name in scene.contents(body.name):
            shape.prisms += [prism(hull, body.center, body.bottom_m) for hull in scene.bodies[name].hulls]
        yaws = [quarter - shape.yaw_rad for quarter in QUARTERS]
        found = free_place(scene, shape, obstacles, levels_of(scene, TABLE), yaws=yaws)
        if found is None:
            return ""
        obstacles = obstacles + occupied(shape, found)
    return in_words(found) if found else "an empty table"


def clutter(operation, scene, targets, references) -> str:
    shape, obstacles, found = box(CLUTTER_M), obstacles_of(scene), None
    for _ in range(operation.wire["count"]):
        found = free_place(scene, shape, obstacles, levels_of(scene, TABLE))
        if found is None:
            return ""
        obstacles = obstacles + occupied(shape, found)
    return in_words(found)


def remove(operation, scene, targets, references) -> str:
    """What stood on a removed object rests anywhere on the table."""
    for name in targets:
        if operation.wire.get("with_contents"):
            continue
        for inner in scene.contents(name):
            left_out = [name, inner]
            found = free_place(scene, shape_of(scene.bodies[inner]), obstacles_of(scene, left_out),
                               levels_of(scene, TABLE))
            if found is None:
                return ""
    return "the places below"
