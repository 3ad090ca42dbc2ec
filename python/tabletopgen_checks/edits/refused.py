"""Edits that must be refused, each with words that the reason has to contain.

Every one is impossible for a reason that is certain without a search: these need no trust in the search.
"""

from collections import defaultdict

from tabletopgen_checks.catalog import CATEGORIES
from tabletopgen_checks.edits.comparison import Operation
from tabletopgen_checks.edits.places import has_own_label
from tabletopgen_checks.scene.polygons import area_m2, bounds
from tabletopgen_checks.scene.scene import TABLE

BALLS = ("apple", "orange", "lemon", "tennis_ball", "egg")
LARGE = {"laptop": "a laptop", "monitor": "a monitor", "toaster": "a toaster"}


def chosen(names, chance):
    return chance.choice(sorted(names)) if names else None


def unknown_object(parent, chance):
    """An object that is not there, as the target or in a place."""
    name = chosen(parent.scene.bodies, chance)
    wires = [
        {"op": "move", "target": "the giraffe", "where": {"relation": "at_center"}},
        {"op": "remove", "target": "giraffe_7"},
        {"op": "move", "target": name, "where": {"relation": "left_of", "target": "the giraffe"}},
        {"op": "rotate", "target": name, "facing": "the giraffe"},
    ]
    return Operation(chance.choice(wires)), ("giraffe",)


def ambiguous(parent, chance):
    """A phrase that fits several; the reason names them."""
    alike = defaultdict(list)
    for body in parent.scene.bodies.values():
        if has_own_label(body):
            alike[body.label].append(body.name)
    labels = [label for label, names in alike.items() if len(names) > 1]
    if label := chosen(labels, chance):
        wires = [
            {"op": "rotate", "target": f"the {label}", "by_rad": 0.5},
            {"op": "resize", "target": f"the {label}", "factor": 0.9},
            {"op": "move", "target": f"the {label}", "where": {"relation": "at_center"}},
        ]
        return Operation(chance.choice(wires)), tuple(sorted(alike[label]))
    return None


def cycle(parent, chance):
    """Into or onto what stands in or on the target, or the target itself."""
    scene = parent.scene
    carriers = [name for name in scene.bodies if scene.contents(name)]
    if name := chosen(carriers, chance):
        inner = chosen(scene.contents(name), chance)
        relation = chance.choice(["in", "on"])
        return Operation({"op": "move", "target": name, "where": {"relation": relation, "target": inner}}), ()
    name = chosen(scene.bodies, chance)
    return Operation({"op": "move", "target": name, "where": {"relation": "on", "target": name}}), ()


def on_ball(parent, chance):
    """Onto a ball."""
    balls = [body.name for body in parent.scene.bodies.values() if body.category in BALLS]
    if ball := chosen(balls, chance):
        return Operation({"op": "add", "object": "a book", "where": {"relation": "on", "target": ball}}), ()
    return None


def beyond_table(parent, chance):
    """The center of the object a quarter of a meter outside the table."""
    low, high = bounds(parent.scene.outline)
    axis, side = chance.choice([0, 1]), chance.choice([0, 1])
    at = [round(0.5 * (low[k] + high[k]), 3) for k in (0, 1)]
    at[axis] = round(high[axis] + 0.25 if side else low[axis] - 0.25, 3)
    bodies = [body.name for body in parent.scene.bodies.values() if body.parent == TABLE]
    return Operation({"op": "move", "target": chosen(bodies, chance), "where": {"position_m": at}}), ()


def the_table(parent, chance):
    """The table is no object."""
    wires = [
        {"op": "replace", "target": "table", "object": "a mug"},
        {"op": "replace", "target": "the table", "object": "a round table"},
        {"op": "remove", "target": "table"},
        {"op": "move", "target": "the table", "where": {"relation": "at_center"}},
    ]
    return Operation(chance.choice(wires)), ("table",)


def small_container(parent, chance):
    """Into a container that is narrower than the shortest side of the object."""
    bodies = list(parent.scene.bodies.values())
    pairs = []
    for host in bodies:
        can = host.category in CATEGORIES and "container" in CATEGORIES[host.category].affordances
        room = max(host.size_m[:2])
        if not can or host.category == "tray":
            continue
        for body in bodies:
            # Neither lying nor on its edge.
            smallest, second, _ = sorted(body.size_m)
            is_apart = body is not host and host.name not in parent.scene.contents(body.name)
            if is_apart and smallest > 0.6 * room and second > room + 0.02:
                pairs.append(({"op": "move", "target": body.name}, host.name))
        for name, phrase in LARGE.items():
            if sorted(CATEGORIES[name].low_m)[1] > room + 0.02:
                pairs.append(({"op": "add", "object": phrase}, host.name))
    if not pairs:
        return None
    wire, host = chance.choice(sorted(pairs, key=str))
    return Operation(wire | {"where": {"relation": "in", "target": host}}), ()


def full_table(parent, chance):
    """More large objects than the table has area for."""
    area = area_m2(parent.scene.outline)
    fitting = [name for name in LARGE if 32 * CATEGORIES[name].low_m[0] * CATEGORIES[name].low_m[1] > 1.05 * area]
    if category := chosen(fitting, chance):
        return Operation({"op": "add", "object": LARGE[category], "count": 32}), ()
    return None


REFUSED = {
    "unknown object": unknown_object, "ambiguous": ambiguous, "support cycle": cycle, "on a ball": on_ball,
    "beyond the table": beyond_table, "the table itself": the_table, "container too small": small_container,
    "no room on the table": full_table,
}
