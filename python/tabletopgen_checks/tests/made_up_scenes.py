"""Made-up scenes: boxes, and containers of five boxes."""

import copy
import math

from tabletopgen_checks.scene.scene import Scene, wrapped_rad

OUTLINE = [[-0.6, -0.3], [0.6, -0.3], [0.6, 0.3], [-0.6, 0.3]]


def body(name, x, y, z=0.0, size=(0.1, 0.1, 0.1), yaw_deg=0.0, parent="table", relation="on", tilt_deg=0.0,
         **more):
    """A box whose bottom center is at x, y, z (meters); the tilt is about its x axis, before the yaw."""
    half, lean = math.radians(yaw_deg) / 2, math.radians(tilt_deg) / 2
    instance = {
        "name": name, "label": name.rsplit("_", 1)[0], "category": name.rsplit("_", 1)[0], "size_m": list(size),
        "translation_m": [x, y, z], "rotation_xyzw": [
            math.cos(half) * math.sin(lean), math.sin(half) * math.sin(lean), math.sin(half) * math.cos(lean),
            math.cos(half) * math.cos(lean),
        ],
        "yaw_rad": wrapped_rad(math.radians(yaw_deg)), "symmetry_order": 1, "mass_kg": 0.2,
        "friction": {"static": 0.5, "dynamic": 0.4}, "center_of_mass_m": [0.0, 0.0, 0.5 * size[2]],
        "support": {"parent": parent, "relation": relation},
    }
    return instance | more


def cup(name, x, y, width=0.12, height=0.1, wall=0.01):
    """A square container of four walls and a floor: its instance and its hulls."""
    half = 0.5 * width
    spans = [((-half, half), (-half, half), (0.0, wall))]
    for low, high in ((-half, wall - half), (half - wall, half)):
        spans += [((low, high), (-half, half), (wall, height)), ((-half, half), (low, high), (wall, height))]
    hulls = [[(a, b, c) for a in along for b in across for c in up] for along, across, up in spans]
    return body(name, x, y, size=(width, width, height)), hulls


def scene(*bodies, moved=(), operations=0, verdict="pass", col_s=0, shape="rectangular", folder=None, hulls=()):
    """A scene; with a number of operations it is the child of the scene `parent`."""
    table = {"shape": shape, "outline_m": OUTLINE, "size_m": [1.2, 0.6, 0.75], "height_m": 0.75}
    source = {"kind": "edit", "parent": "parent", "operations": [{"op": "x"}] * operations}
    content = {"id": "parent", "table": table, "request": {"input": source if operations else {"kind": "text"}},
            "instances": list(bodies)}
    report = {"verdict": verdict, "metrics": {"col_s": col_s}, "edit": {"moved": list(moved)}, "reasons": []}
    return Scene(content, dict(hulls), report, folder)


MUG, PLATE, BOOK = body("mug_1", -0.3, 0.0), body("plate_1", 0.3, 0.0), body("book_1", 0.0, 0.2)


def changed(instance, **more):
    return copy.deepcopy(instance) | more
