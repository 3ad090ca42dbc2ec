"""The table of a sensitivity analysis: what differed between the starts of finished episodes, one column a factor."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Record = Mapping[str, Any]
Column = NDArray[Any]

# Channels of a color.
CHANNELS = ("red", "green", "blue")
# Colors with less difference between their channels, as a share of the brightest, have no hue.
GRAY, DARK, BRIGHT = 0.15, 0.15, 0.75
# Hues in degrees, each up to its bound.
HUES = ((15.0, "red"), (45.0, "orange"), (70.0, "yellow"), (165.0, "green"), (200.0, "cyan"), (260.0, "blue"), (330.0, "purple"))


@dataclass(frozen=True)
class Factor:
    """One column: numbers (NaN where an episode has none), or words (empty where it has none)."""

    name: str
    values: Column
    is_number: bool

    @property
    def present(self) -> NDArray[np.bool_]:
        """Episodes that have a value."""
        found: NDArray[np.bool_] = ~np.isnan(self.values) if self.is_number else self.values != ""
        return found

    @property
    def is_constant(self) -> bool:
        return len(np.unique(self.values[self.present])) < 2


@dataclass(frozen=True)
class Table:
    """Episodes as rows: whether each failed, which start it has, its environment, and its factors. `constant` names
    factors with one value, `merged` those that order episodes as a factor before them does, by its name."""

    failed: NDArray[np.bool_]
    starts: NDArray[np.int64]
    environments: NDArray[np.str_]
    factors: tuple[Factor, ...]
    constant: tuple[str, ...]
    merged: Mapping[str, tuple[str, ...]]


def table_of(records: Sequence[Record], environments: Sequence[str]) -> Table:
    """The table of episodes' records. Factors with one value in all episodes explain nothing, and are only named.

    `environments` names that of each record: those of several rollouts may have one name, and one may have several."""
    places = [(name, record["start"]) for name, record in zip(environments, records, strict=True)]
    starts = {start: number for number, start in enumerate(dict.fromkeys(places))}
    rows = [values_of(record) for record in records]
    columns = [column(name, rows) for name in dict.fromkeys(name for row in rows for name in row)]
    varied: list[Factor] = []
    merged: dict[str, tuple[str, ...]] = {}
    for one in (one for one in columns if not one.is_constant):
        first = next((other for other in varied if is_same_order(other, one)), None)
        if first is None:
            varied.append(one)
        else:
            merged[first.name] = (*merged.get(first.name, ()), one.name)
    return Table(
        failed=np.array([not record["success"] for record in records], dtype=bool),
        starts=np.array([starts[place] for place in places], dtype=np.int64),
        environments=np.array(environments, dtype=np.str_),
        factors=tuple(varied),
        constant=tuple(one.name for one in columns if one.is_constant),
        merged=merged,
    )


def is_same_order(one: Factor, other: Factor) -> bool:
    """Whether both divide episodes in the same ways: numbers in the same order, or words that change together."""
    return one.is_number == other.is_number and bool(np.array_equal(places(one), places(other)))


def places(factor: Factor) -> NDArray[np.int64]:
    """The place of each value among the distinct ones, in order; words by where they are first."""
    distinct, first, found = np.unique(factor.values, return_index=True, return_inverse=True)
    if factor.is_number:
        # Numbers that are missing are the last of `np.unique`.
        return np.where(factor.present, found, len(distinct)).astype(np.int64)
    return first[found].astype(np.int64)


def column(name: str, rows: Sequence[Mapping[str, float | str | None]]) -> Factor:
    """A factor by its name."""
    values = [row.get(name) for row in rows]
    is_number = not any(isinstance(value, str) for value in values)
    if is_number:
        return Factor(name, np.array([np.nan if value is None else float(value) for value in values]), True)
    return Factor(name, np.array(["" if value is None else str(value) for value in values], dtype=np.str_), False)


def values_of(record: Record) -> dict[str, float | str | None]:
    """Values of an episode's factors: those that its record counts, poses and colors of the objects that the task
    names, the direction toward the light, and words."""
    found: dict[str, float | str | None] = dict(record["factors"])
    moved = {one["object"]: "moved" for one in record["moved"][:1]}
    others = [name for name in record["objects"] if name not in moved]
    for name, role in {**moved, **{name: f"target_{place + 1}" if place else "target" for place, name in enumerate(others)}}.items():
        if (own := record["objects"].get(name)) is not None:
            found |= {f"{role}_{key}": value for key, value in of_object(own).items()}
    found |= dict(zip((f"table_{channel}_factor" for channel in CHANNELS), record["table_tint"], strict=True))
    x, y, z = record["light"]["direction"]
    found |= {"light_azimuth_rad": math.atan2(-y, -x), "light_elevation_rad": math.atan2(-z, math.hypot(x, y))}
    found["wording"] = str(record["wording"])
    found["task"] = str(record["task"])
    return found


def of_object(own: Mapping[str, Any]) -> dict[str, float | str | None]:
    """Pose, size, mass, friction and color of one object."""
    found: dict[str, float | str | None] = {"category": str(own["category"]), "mass_kg": own["mass_kg"], "friction": own["friction"]}
    if (pose := own["world_from_object"]) is not None:
        x, y, z, w = pose["rotation_xyzw"]
        found |= {"x_m": pose["translation_m"][0], "y_m": pose["translation_m"][1]}
        found["yaw_rad"] = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    found |= dict(zip((f"{channel}_factor" for channel in CHANNELS), own["tint"], strict=True))
    if (color := own.get("color")) is not None:
        found["color"] = color_name(color)
    if (size_m := own.get("size_m")) is not None:
        found["size_m"] = max(size_m)
    return found


def color_name(color: Iterable[float]) -> str:
    """The name of a color with channels from 0 to 1: that of its hue, or black, gray or white."""
    red, green, blue = color
    low, high = min(red, green, blue), max(red, green, blue)
    if high < DARK:
        return "black"
    if high - low < GRAY * high:
        return "white" if high > BRIGHT else "gray"
    if high == red:
        hue = 60 * ((green - blue) / (high - low) % 6)
    elif high == green:
        hue = 60 * ((blue - red) / (high - low) + 2)
    else:
        hue = 60 * ((red - green) / (high - low) + 4)
    return next((name for bound, name in HUES if hue < bound), "red")
