"""What every variant keeps: the objects, what carries what, and what the text states of places and colors."""

from tabletopgen_checks.edits.statements import has_color
from tabletopgen_checks.scene.relations import holds
from tabletopgen_checks.scene.scene import Scene

SUPPORTS = ("on", "in", "stacked_on")
# Of these the account of a text names no more than the objects, so that there is nothing to measure.
UNMEASURED = ("around", "parallel_to")


def complaints(parent: Scene, variant: Scene, colors: dict) -> list:
    """What a variant does not keep, in words."""
    wrong = []
    if sorted(parent.bodies) != sorted(variant.bodies):
        return [f"objects {sorted(variant.bodies)} instead of {sorted(parent.bodies)}"]
    for name, body in parent.bodies.items():
        after = variant.bodies[name]
        if (body.parent, body.relation) != (after.parent, after.relation):
            wrong.append(f"{name} is {after.relation} {after.parent}, not {body.relation} {body.parent}")
        if body.category != after.category or body.label != after.label:
            wrong.append(f"{name} is {after.label} ({after.category}), not {body.label} ({body.category})")
    for kind, name, target, second in relations(parent):
        if is_met(parent, kind, name, target, second) and not is_met(variant, kind, name, target, second):
            wrong.append(f"{name} is no more {kind} {target or 'of the table'}")
    for name, color in colors.items():
        if name in variant.bodies and has_color(parent.folder, name, color):
            if not has_color(variant.folder, name, color):
                wrong.append(f"{name} is no more {color}")
    if variant.scene["metrics"]["col_s"] != 0.0:
        wrong.append(f"col_s is {variant.scene['metrics']['col_s']}")
    if variant.report.get("verdict") != "pass":
        wrong.append(f"the certificate says {variant.report.get('verdict')}: {variant.report.get('summary')}")
    return wrong


def relations(scene: Scene) -> list:
    """(kind, object, target, second target) of every relation that the text states."""
    found = []
    for part in (scene.scene.get("text") or {}).get("understood", ()):
        if part["kind"] != "relation" or part["relation"] in SUPPORTS + UNMEASURED:
            continue
        targets = [name for name in part["targets"] if name in scene.bodies]
        target = targets[0] if targets else None
        second = targets[1] if part["relation"] == "between" and len(targets) > 1 else None
        if len(targets) <= (2 if second else 1):
            found += [(part["relation"], name, target, second) for name in part["objects"] if name in scene.bodies]
    return found


def is_met(scene: Scene, kind, name, target, second) -> bool:
    body = scene.bodies
    return holds(
        kind,
        body[name],
        scene.outline,
        body[target] if target else None,
        body[second] if second else None,
    )
