"""What single operations state, checked on the finished scene. What a later operation moves is not checked."""

import math
from dataclasses import dataclass

from tabletopgen_checks.edits.appearance import parts
from tabletopgen_checks.scene.colors import is_color
from tabletopgen_checks.scene.polygons import area_m2, depth_m, distance_m
from tabletopgen_checks.scene.relations import DISTANCE_TOLERANCE_M, POSITION_TOLERANCE_M, YAW_TOLERANCE_RAD, holds
from tabletopgen_checks.scene.scene import TABLE, Body, Scene, angle_rad, inverse_placed, wrapped_rad

# What stands on or in a moved object keeps its place there up to this.
CARRIED_M = 0.02
# Of a resized object.
SIZE_TOLERANCE, MASS_TOLERANCE = 0.02, 0.1
# What grows may have to step aside.
RESIZED_M = 0.05
# Distance of colors that a reader tells apart.
OTHER_COLOR = 0.1
# A new material changes the mass; the pose settles by no more than this.
SETTLED_M, SETTLED_RAD = 0.002, 0.02
# Tidied objects are at least this far apart.
TIDY_GAP_M = 0.005
# A part of a surface that shows the color of an object.
COLORED_SHARE = 0.15


@dataclass
class Context:
    """The parent, the bodies of the child by the names of the parent, and the names of what operations added."""

    parent: Scene
    bodies: dict
    child: Scene
    added: dict
    # What earlier operations move; what later ones move or remove.
    earlier: set
    later: set
    # Whether this operation is about any of it.
    superseded: bool

    def of(self, names: list) -> list:
        """The bodies that are there; what is missing is a complaint of its own."""
        found = []
        for name in names:
            found += self.added.get(int(name[1:]), []) if name.startswith("+") else [name]
        return [self.bodies[name] for name in found if name in self.bodies]

    def before(self, body: Body) -> Body | None:
        """The body in the parent; `None` for what an operation added."""
        return self.parent.bodies.get(known_name(body, self))


def statement(operation, index: int, context: Context) -> list:
    """What the child does not have of what the operation states."""
    return {
        "add": added, "remove": removed, "replace": replaced, "move": moved, "rotate": rotated, "resize": resized,
        "recolor": recolored, "relabel": relabeled, "restyle_table": restyled, "stack": stacked, "tidy": tidied,
        "clutter": cluttered,
    }[operation.name](operation, index, context)


def added(operation, index, context) -> list:
    wrong = []
    for body in context.of([f"+{index}"]):
        if operation.color and not has_color(context.child.folder, body.name, operation.color):
            wrong.append(f"{body.name} is not {operation.color}")
        if context.superseded:
            continue
        if place := operation.wire.get("where"):
            wrong += place_complaints(body, place, operation.references, context)
        elif body.parent != TABLE:
            wrong.append(f"{body.name} stands on {body.parent}, not on the table")
    return wrong


def removed(operation, index, context) -> list:
    """That the target is gone is checked for all of them; what stood on it must stand elsewhere."""
    left = [body.name for body in context.child.bodies.values() if body.parent in operation.targets]
    return [f"{name} still stands on what was removed" for name in left]


def replaced(operation, index, context) -> list:
    wrong = []
    for name, body in zip(operation.targets, context.of([f"+{index}"])):
        before = context.parent.bodies.get(name)
        if before is None or context.superseded:
            continue
        away_m = math.dist(before.center, body.center)
        # A plate instead of a mug at the edge may need a step inward.
        inside = max(depth_m(before.footprint, body.center), depth_m(body.footprint, before.center))
        if away_m > POSITION_TOLERANCE_M and inside < -DISTANCE_TOLERANCE_M:
            wrong.append(f"{body.name} is {100 * away_m:.1f} cm from the place of {name}")
        if body.parent != before.parent:
            wrong.append(f"{body.name} stands on {body.parent}, {name} stood on {before.parent}")
    return wrong


def moved(operation, index, context) -> list:
    wrong = []
    if context.superseded:
        return wrong
    for body in context.of(operation.targets):
        wrong += place_complaints(body, operation.wire["where"], operation.references, context)
        wrong += carried_complaints(body, context)
    return wrong


def place_complaints(body, place, references, context) -> list:
    if "position_m" in place:
        wanted = place["position_m"]
        origin = body.pose[0][:2]
        away_m = min(math.dist(wanted, body.center), math.dist(wanted, origin))
        wrong = [] if away_m <= POSITION_TOLERANCE_M else [f"{body.name} is {100 * away_m:.1f} cm from {wanted}"]
    elif "offset_m" in place:
        before, by = context.before(body), place["offset_m"]
        shift = [body.center[k] - before.center[k] for k in (0, 1)] if before else by
        away_m = math.dist(shift, by)
        wrong = [] if away_m <= POSITION_TOLERANCE_M else [f"{body.name} moved by {shift}, not by {by}"]
    else:
        wrong = relation_complaints(body, place, references, context)
    if "yaw_rad" in place and body.yaw_rad is not None:
        off = abs(wrapped_rad(body.yaw_rad - place["yaw_rad"], body.symmetry_order))
        if off > YAW_TOLERANCE_RAD:
            wrong.append(f"the yaw of {body.name} is {body.yaw_rad:.3f} rad, not {place['yaw_rad']:.3f}")
    return wrong


def relation_complaints(body, place, references, context) -> list:
    kind, others = place["relation"], context.of(references)
    if len(others) != len(references):
        return [f"the objects of the place are not all there: {', '.join(references)}"]
    target, second = (others + [None, None])[:2]
    words = " and ".join(other.name for other in others) or "the table"
    wrong = []
    if not holds(kind, body, context.child.outline, target, second, place.get("distance_m")):
        stated = f" at {100 * place['distance_m']:g} cm" if "distance_m" in place else ""
        wrong.append(f"{body.name} is not {kind} {words}{stated}")
    if kind in ("on", "in"):
        if target is None and body.parent != TABLE:
            wrong.append(f"{body.name} stands on {body.parent}, not on the table")
        elif target is not None and target.name not in context.child.supporters(body.name):
            wrong.append(f"{target.name} does not carry {body.name}, {body.parent} does")
    return wrong


def carried_complaints(body, context) -> list:
    """Whether what stood on or in the object is still there, at the same place of it."""
    before, wrong = context.before(body), []
    for name in context.parent.contents(before.name) if before else []:
        inner, inner_before = context.bodies.get(name), context.parent.bodies[name]
        if inner is None or name in context.later:
            continue
        shift_m = math.dist(
            inverse_placed(before.pose, inner_before.pose[0]), inverse_placed(body.pose, inner.pose[0])
        )
        if body.name not in context.child.supporters(inner.name):
            wrong.append(f"{name} was left behind by {body.name}")
        elif shift_m > CARRIED_M:
            wrong.append(f"{name} moved {100 * shift_m:.1f} cm in {body.name}")
    return wrong


def rotated(operation, index, context) -> list:
    wrong = []
    if context.superseded:
        return wrong
    for body in context.of(operation.targets):
        before = context.before(body)
        # A turn is relative to the pose that earlier operations left, which the end does not show.
        is_first = known_name(body, context) not in context.earlier
        if facing := context.of(operation.references):
            if body.symmetry_order == 1 and not holds("facing", body, context.child.outline, facing[0]):
                wrong.append(f"{body.name} does not face {facing[0].name}")
        elif body.yaw_rad is not None and before is not None and (is_first or "to_rad" in operation.wire):
            wanted = operation.wire.get("to_rad")
            wanted = before.yaw_rad + operation.wire["by_rad"] if wanted is None else wanted
            if abs(wrapped_rad(body.yaw_rad - wanted, body.symmetry_order)) > YAW_TOLERANCE_RAD:
                wrong.append(f"the yaw of {body.name} is {body.yaw_rad:.3f} rad, not {wrapped_rad(wanted):.3f}")
        if before is not None and is_first:
            wrong += place_kept_complaints(before, body) + carried_complaints(body, context)
    return wrong


def place_kept_complaints(before, after, tolerance_m=POSITION_TOLERANCE_M) -> list:
    away_m = min(math.dist(before.center, after.center), math.dist(before.pose[0][:2], after.pose[0][:2]))
    if away_m > tolerance_m:
        return [f"{after.name} is {100 * away_m:.1f} cm from its place"]
    return [f"{after.name} stands on {after.parent}, not on {before.parent}"] if before.parent != after.parent else []


def resized(operation, index, context) -> list:
    wrong, factor = [], operation.wire["factor"]
    for body in context.of(operation.targets):
        before = context.before(body)
        if before is None:
            continue
        for axis, old, new in zip("xyz", before.size_m, body.size_m):
            if abs(new / (factor * old) - 1.0) > SIZE_TOLERANCE:
                wrong.append(f"{axis} of {body.name} is {new / old:.3f} times as long, not {factor} times")
        if abs(math.log(body.mass_kg / before.mass_kg) - 3 * math.log(factor)) > MASS_TOLERANCE:
            wrong.append(f"{body.name} weighs {body.mass_kg / before.mass_kg:.3f} times as much, not {factor**3:.3f}")
        if not context.superseded:
            wrong += place_kept_complaints(before, body, RESIZED_M)
    return wrong


def recolored(operation, index, context) -> list:
    wrong, color, material = [], operation.wire.get("color"), operation.wire.get("material")
    for body in context.of(operation.targets):
        before = context.before(body)
        if color and not has_color(context.child.folder, body.name, color):
            wrong.append(f"{body.name} is not {color}")
        if before is None:
            continue
        if before.size_m != body.size_m or before.label != body.label:
            wrong.append(f"the size or the label of {body.name} changed")
        same_substance = before.mass_kg == body.mass_kg and before.friction == body.friction
        # Categories with a density of their own keep it, and two substances may have one friction: then it shows.
        if material and same_substance and not has_other_color(context, before, body):
            wrong.append(f"mass and friction of {body.name} are those of before, not those of {material}")
        if not material and not same_substance:
            wrong.append(f"mass or friction of {body.name} changed with its color")
        if not context.superseded and material and known_name(body, context) not in context.earlier:
            if math.dist(before.pose[0], body.pose[0]) > SETTLED_M or angle_rad(before, body) > SETTLED_RAD:
                wrong.append(f"{body.name} moved although only its material changed")
    return wrong


def known_name(body: Body, context: Context) -> str:
    """The name by which the operations know a body."""
    return next((name for name, other in context.bodies.items() if other is body), body.name)


def has_other_color(context: Context, before: Body, after: Body) -> bool:
    """Whether the largest part of a body has another color than before; without files it has not."""
    if context.parent.folder is None or context.child.folder is None:
        return False
    folders = (context.parent.folder, before), (context.child.folder, after)
    colors = [parts(folder, body.name)[0].color for folder, body in folders]
    return math.dist(*colors) > OTHER_COLOR


def has_color(folder, name: str, color: str) -> bool:
    """Whether a large enough part of the surface shows the color."""
    found = parts(folder, name)
    whole = sum(part.area_m2 for part in found)
    return any(part.area_m2 >= COLORED_SHARE * whole and is_color(part.color, color) for part in found)


def relabeled(operation, index, context) -> list:
    wrong, label = [], operation.wire["label"]
    for body in context.of(operation.targets):
        before = context.before(body)
        if body.label != label:
            wrong.append(f"the label of {body.name} is {body.label!r}, not {label!r}")
        if before is not None and (before.size_m, before.mass_kg) != (body.size_m, body.mass_kg):
            wrong.append(f"the size or the mass of {body.name} changed with its label")
    return wrong


def restyled(operation, index, context) -> list:
    before, after = context.parent.table, context.child.table
    wrong = [f"{key} of the table changed" for key in ("shape", "outline_m", "size_m", "height_m")
             if before[key] != after[key]]
    found = parts(context.child.folder, TABLE)
    material, color = operation.wire.get("material"), operation.wire.get("color")
    if color and not has_color(context.child.folder, TABLE, color):
        wrong.append(f"the table is not {color}")
    elif material and not color and all(part.material != material for part in found):
        wrong.append(f"the table has {', '.join(part.material for part in found)}, and no {material}")
    return wrong


def stacked(operation, index, context) -> list:
    if context.superseded:
        return []
    bodies, wrong = context.of(operation.targets), []
    # From the bottom: what a phrase of several means comes in any order, the largest at the bottom.
    is_phrase = len(operation.wire["targets"]) == 1
    if is_phrase:
        bodies = sorted(bodies, key=lambda body: len(context.child.supporters(body.name)))
    for below, above in zip(bodies, bodies[1:]):
        if above.parent != below.name:
            wrong.append(f"{above.name} stands on {above.parent}, not on {below.name}")
        elif not holds("stacked_on", above, context.child.outline, below):
            wrong.append(f"{above.name} is not above {below.name}")
        sizes = [(math.prod(body.size_m), area_m2(body.footprint)) for body in (below, above)]
        if is_phrase and all(large < 0.98 * small for large, small in zip(*sizes)):
            wrong.append(f"{above.name} is larger than {below.name} below it")
    return wrong


def tidied(operation, index, context) -> list:
    """Sides along the edges of the table, on tables that have straight edges, and gaps between the footprints."""
    if context.superseded:
        return []
    wrong, standing = [], [body for body in context.child.bodies.values() if body.parent == TABLE]
    if context.child.table["shape"] in ("rectangular", "square"):
        for body in standing:
            order = body.symmetry_order and math.lcm(4, body.symmetry_order)
            off = None if body.yaw_rad is None else abs(wrapped_rad(body.yaw_rad, order))
            if off is not None and off > YAW_TOLERANCE_RAD:
                wrong.append(f"{body.name} is {math.degrees(off):.0f} degrees off the edges of the table")
    for k, one in enumerate(standing):
        for other in standing[k + 1 :]:
            apart_m = distance_m(one.footprint, other.footprint)
            beside = min(one.top_m, other.top_m) > max(one.bottom_m, other.bottom_m)
            if beside and apart_m < TIDY_GAP_M:
                wrong.append(f"{one.name} and {other.name} are {1e3 * apart_m:.1f} mm apart")
    for body in standing:
        wrong += carried_complaints(body, context)
    return wrong


def cluttered(operation, index, context) -> list:
    """The count is checked with what appeared; a theme is no property of the finished scene."""
    return []
