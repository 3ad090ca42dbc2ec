"""Policies with planted weaknesses: the recorded expert, which does nothing from starts that it is to fail from.

The recorded episodes lie beside the folder of an environment, as `episodes`. A policy reads what decides from that
folder: what the simulation has at the start, which a policy with eyes would have to see.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from tabletopgen.env import SceneEnv
from tabletopgen.env.policies import RecordedPolicy
from tabletopgen.env.policy import Description
from tabletopgen.env.rollout_factors import StartFactors
from tabletopgen.env.scene_env import Observation
from tabletopgen.env.sensitivity_table import color_name
from tabletopgen.env.vectors import Vector

# MuJoCo's light of a scene is usually 0.6 bright, and a can of soda weighs 0.42 kg.
DARK_BELOW, HEAVY_ABOVE_KG, REFUSED_COLOR = 0.5, 0.5, "red"

# Whether to fail from a start, by what it has and by the seed of the episode.
Weakness = Callable[[dict[str, Any], int], bool]


class Planted:
    """The expert, which stays where it is from starts with a weakness."""

    def __init__(self, description: Description, fails: Weakness):
        self.description, self.fails = description, fails
        self.expert: RecordedPolicy | None = None
        self.place: Path | None = None
        self.stays = False
        self.first: Vector | None = None

    def reset(self, info: Mapping[str, Any]) -> None:
        folder = Path(info["environment"])
        if self.expert is None or folder != self.place:
            self.expert, self.place = RecordedPolicy(str(folder.parent / "episodes"), self.description), folder
        self.expert.reset(info)
        self.first = None
        self.stays = self.fails(begun(folder, int(info["start"])), int(info["seed"]))

    def act(self, observation: Observation) -> Vector:
        assert self.expert is not None
        if self.first is None or not self.stays:
            self.first = self.expert.act(observation)
        return self.first


@cache
def opened(folder: Path) -> tuple[SceneEnv, StartFactors]:
    """The environment of a folder, which only starts are read from."""
    env = SceneEnv(folder=folder, images=False)
    return env, StartFactors(env, env.files)


def begun(folder: Path, start: int) -> dict[str, Any]:
    """The record of a start, as the simulation has it."""
    env, factors = opened(folder)
    env.reset(options={"start": start})
    return factors.of(env.starts[start])


def moved(record: Mapping[str, Any]) -> dict[str, Any]:
    """The object that is moved."""
    found: dict[str, Any] = record["objects"][record["moved"][0]["object"]]
    return found


def dark(description: Description) -> Planted:
    """Fails in low light."""
    return Planted(description, lambda start, _: start["factors"]["light_brightness"] < DARK_BELOW)


def heavy(description: Description) -> Planted:
    """Fails for heavy objects."""
    return Planted(description, lambda start, _: moved(start)["mass_kg"] > HEAVY_ABOVE_KG)


def red(description: Description) -> Planted:
    """Fails for objects of one color."""
    return Planted(description, lambda start, _: color_name(moved(start)["color"]) == REFUSED_COLOR)


def chance(description: Description) -> Planted:
    """Fails from about three of ten starts, which nothing about them decides."""
    return Planted(description, lambda _, seed: np.random.default_rng(seed).uniform() < 0.3)
