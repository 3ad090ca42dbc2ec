"""What differs between the starts of episodes, and may decide whether a policy succeeds."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from tabletopgen.env.appearance import LIGHT
from tabletopgen.env.folder import EnvironmentFolder
from tabletopgen.env.judge import SCENE
from tabletopgen.env.scene_env import SceneEnv
from tabletopgen.env.start import Start

# Names of objects in a predicate: the one that is moved, and those that say where to.
MOVED, TARGETS = "object", ("target", "second_target")


class StartFactors:
    """Factors of the starts of an environment."""

    def __init__(self, env: SceneEnv, files: EnvironmentFolder):
        self.env, self.files = env, files
        scene = json.loads((files.scene / SCENE).read_text(encoding="utf-8"))
        self.categories = {instance["name"]: str(instance["category"]) for instance in scene["instances"]}
        self.sizes_m = {instance["name"]: list(instance["size_m"]) for instance in scene["instances"]}
        self.goal: list[Mapping[str, Any]] = list(files.task["goal"])
        # The goal by categories, so that the same task in other scenes has the same text.
        self.task = ", ".join(self._text(predicate) for predicate in self.goal)

    def _text(self, predicate: Mapping[str, Any]) -> str:
        names = [str(predicate[key]) for key in (MOVED, *TARGETS) if predicate.get(key)]
        return f"{predicate['predicate']}({', '.join(self.categories.get(name, name) for name in names)})"

    def of(self, start: Start) -> dict[str, Any]:
        """What an episode's record states about its start, after the environment was reset to it."""
        named = [predicate[key] for predicate in self.goal for key in (MOVED, *TARGETS) if predicate.get(key)]
        objects = {name: self._object(name, start) for name in dict.fromkeys(named) if name in start.objects}
        moved = [self._moved(predicate, start) for predicate in self.goal]
        light = {**vars(start.light), "direction": self.env.simulation.model.light(LIGHT).dir.tolist()}
        cameras = {camera.name: vars(own) for camera, own in zip(self.files.cameras, start.cameras, strict=True)}
        return {
            "task": self.task,
            "wording": self.env.task_description,
            "moved": moved,
            "objects": objects,
            "light": light,
            "cameras": cameras,
            "table_tint": list(start.table_tint),
            "factors": {**self._of_moved(moved, objects), **self._of_surroundings(start)},
        }

    def _object(self, name: str, start: Start) -> dict[str, Any]:
        simulation, drawn = self.env.simulation, start.objects[name]
        geoms = simulation.geoms[name]
        # Others are drawn, and touch nothing.
        touching = [geom for geom in geoms if simulation.model.geom_contype[geom]] or geoms
        return {
            "category": self.categories[name],
            "world_from_object": drawn.world_from_object,
            "mass_kg": float(simulation.model.body_mass[simulation.body[name]]),
            "friction": float(simulation.model.geom_friction[touching[0], 0]),
            "tint": list(drawn.tint),
            "color": self.env.appearance.color(name),
            "size_m": self.sizes_m[name],
        }

    def _moved(self, predicate: Mapping[str, Any], start: Start) -> dict[str, Any]:
        name = predicate[MOVED]
        own, places = place_m(name, start), [place_m(predicate[key], start) for key in TARGETS if predicate.get(key)]
        distance_m = None
        if own is not None and places and all(place is not None for place in places):
            distance_m = float(np.linalg.norm(np.mean(places, axis=0) - own))
        return {"object": name, "category": self.categories.get(name, name), "predicate": predicate["predicate"], "distance_m": distance_m}

    def _of_moved(self, moved: list[dict[str, Any]], objects: Mapping[str, Any]) -> dict[str, float | None]:
        """Numbers of the objects to move; of several, the greatest."""
        distances_m = [one["distance_m"] for one in moved if one["distance_m"] is not None]
        own = [objects[one["object"]] for one in moved if one["object"] in objects]
        return {
            "distance_m": max(distances_m, default=None),
            "mass_kg": max((one["mass_kg"] for one in own), default=None),
            "friction": max((one["friction"] for one in own), default=None),
            "object_tint": max((float(np.mean(one["tint"])) for one in own), default=None),
        }

    def _of_surroundings(self, start: Start) -> dict[str, float | None]:
        """Numbers of clutter, light, table and cameras."""
        found: dict[str, float | None] = {
            "objects_present": float(len(self.env.simulation.present)),
            "light_brightness": float(self.env.simulation.model.light(LIGHT).diffuse.mean()),
            "light_brightness_factor": start.light.brightness_factor,
            "light_turn_rad": start.light.turn_rad,
            "light_raise_rad": start.light.raise_rad,
            "table_tint": float(np.mean(start.table_tint)),
        }
        for camera, own in zip(self.files.cameras, start.cameras, strict=True):
            found[f"camera_{camera.name}_offset_m"] = float(np.linalg.norm(own.offset_m))
            found[f"camera_{camera.name}_turn_rad"] = float(np.linalg.norm(own.turn_rad))
            found[f"camera_{camera.name}_focal_factor"] = own.focal_factor
        return found


def place_m(name: str, start: Start) -> Any:
    """Where an object is on the table, two coordinates; `None` for an absent one."""
    drawn = start.objects.get(name)
    pose = drawn.world_from_object if drawn is not None else None
    return np.array(pose["translation_m"][:2]) if pose is not None else None
