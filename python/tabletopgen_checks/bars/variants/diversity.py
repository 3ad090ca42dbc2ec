"""How much the variants of one scene differ, axis by axis: a number that is 0 where they are alike."""

import itertools
import math
import statistics

from tabletopgen_checks.edits.appearance import parts
from tabletopgen_checks.scene.scene import Scene, wrapped_rad


def diversity(parent: Scene, variants: list) -> dict:
    """Axis to its measure, over all pairs of variants, or over all variants and objects."""
    pairs = list(itertools.combinations(variants, 2))
    rooted = [name for name, body in parent.bodies.items() if body.parent not in parent.bodies]
    names = [name for name in parent.bodies if all(name in one.bodies for one in variants)]
    return {
        "place, mm": mean(1000 * distance_m(a, b, rooted) for a, b in pairs),
        "nearest pair, mm": min((1000 * distance_m(a, b, rooted) for a, b in pairs), default=0.0),
        "yaw, degrees": mean(
            math.degrees(abs(turn_rad(a.bodies[name], b.bodies[name]))) for a, b in pairs for name in rooted
        ),
        "other mesh, %": mean(
            100.0 * is_other_mesh(parent.bodies[name], one.bodies[name]) for one in variants for name in names
        ),
        "size, %": mean(
            100.0 * abs(size_m(one.bodies[name]) / size_m(parent.bodies[name]) - 1.0)
            for one in variants
            for name in names
        ),
        "color, of 255": mean(255.0 * math.dist(color(a, name), color(b, name)) for a, b in pairs for name in names),
        "table color, of 255": mean(255.0 * math.dist(color(a, "table"), color(b, "table")) for a, b in pairs),
        "mass, %": mean(
            100.0 * abs(one.bodies[name].mass_kg / parent.bodies[name].mass_kg - 1.0)
            for one in variants
            for name in names
        ),
        "friction, %": mean(
            100.0 * abs(one.bodies[name].friction["static"] / parent.bodies[name].friction["static"] - 1.0)
            for one in variants
            for name in names
        ),
        "light, degrees": mean(angle_deg(light(a), light(b)) for a, b in pairs),
        "camera, degrees": mean(angle_deg(eye(a), eye(b)) for a, b in pairs),
    }


def mean(values) -> float:
    values = list(values)
    return statistics.fmean(values) if values else 0.0


def distance_m(a: Scene, b: Scene, names) -> float:
    """Mean distance of the places of the objects on the table."""
    return mean(math.dist(a.bodies[name].center, b.bodies[name].center) for name in names)


def turn_rad(a, b) -> float:
    if a.yaw_rad is None or b.yaw_rad is None:
        return 0.0
    return wrapped_rad(a.yaw_rad - b.yaw_rad, a.symmetry_order)


def size_m(body) -> float:
    return math.prod(body.size_m) ** (1 / 3)


def is_other_mesh(before, after) -> bool:
    """Whether the proportions of its hulls, or their number, differ: another size alone changes neither."""
    if len(before.local_hulls) != len(after.local_hulls):
        return True
    ratios = [b / a for a, b in zip(before.size_m, after.size_m)]
    return max(ratios) / min(ratios) > 1.002


def color(scene: Scene, name: str) -> tuple:
    assert scene.folder is not None
    found = parts(scene.folder, name)
    area_m2 = sum(part.area_m2 for part in found)
    return tuple(sum(part.area_m2 * part.color[k] for part in found) / area_m2 for k in range(3))


def light(scene: Scene) -> tuple:
    """Toward the key light; above the front edge where the scene has the usual one."""
    light = scene.scene.get("light") or {"azimuth_rad": 0.0, "elevation_rad": 1.0}
    azimuth, elevation = light["azimuth_rad"], light["elevation_rad"]
    return math.sin(azimuth) * math.cos(elevation), -math.cos(azimuth) * math.cos(elevation), math.sin(elevation)


def eye(scene: Scene) -> tuple:
    """From the center of the table top to the reference camera."""
    return tuple(scene.scene["camera"]["world_from_camera"]["translation_m"])


def angle_deg(a, b) -> float:
    dot = sum(p * q for p, q in zip(a, b)) / (math.hypot(*a) * math.hypot(*b))
    return math.degrees(math.acos(max(-1.0, min(1.0, dot))))
