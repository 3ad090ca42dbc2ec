"""Which two scenes of one description are nearest to each other."""

import json
import math
import zipfile
from collections import defaultdict
from pathlib import Path


def read(path: Path) -> dict:
    """`scene.json` of a bundle's archive."""
    with zipfile.ZipFile(path) as bundle:
        name = next(name for name in bundle.namelist() if name.endswith("/scene.json"))
        return json.loads(bundle.read(name))


def nearest_mm(scenes: list) -> float:
    """The smallest distance of two scenes of one text: the mean distance between the places of the objects of the same
    name, in millimeters. Scenes with different objects are not compared."""
    groups = defaultdict(list)
    for scene in scenes:
        places = {instance["name"]: (instance["category"], instance["translation_m"]) for instance in scene["instances"]}
        kinds = tuple(sorted((name, category) for name, (category, _) in places.items()))
        groups[scene["request"]["input"]["text"], kinds].append([places[name][1] for name, _ in kinds])
    nearest = math.inf
    for group in groups.values():
        for k, one in enumerate(group):
            for other in group[:k]:
                total = 0.0
                for a, b in zip(one, other):
                    total += math.dist(a, b)
                    if 1000.0 * total / len(one) >= nearest:
                        break
                else:
                    nearest = min(nearest, 1000.0 * total / len(one))
    return nearest
