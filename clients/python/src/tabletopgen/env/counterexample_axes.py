"""Changes of a scene in a search for counterexamples: one axis a factor, with the operations that make a change.

A change of a number has a level from -1 to 1: 0 leaves it as it is in the base scene, -1 and 1 are the ends of its
range, and factors are even in their logarithm. A change of a color is a word. A `Change` names what is changed, and all
else is as in the base scene.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from tabletopgen.env.judge import SCENE
from tabletopgen.env.start import CameraStart

Change: TypeAlias = Mapping[str, float | str]

OFFSET, FACTOR, COUNT, WORDS = "offset", "factor", "count", "words"
COLORS = ("red", "green", "blue", "yellow", "white", "black")
# Levels are rounded to this, so that equal changes have equal numbers.
DIGITS = 6
# Limits of the elevation of a light that an edit takes, and the light of a scene that states none.
ELEVATION_RAD = (0.2, 1.5)
USUAL_LIGHT = {"azimuth_rad": math.atan2(-0.2, 0.35), "elevation_rad": math.atan2(1.0, math.hypot(0.2, 0.35)), "intensity": 1.0}


@dataclass(frozen=True)
class Axis:
    """A part that is changed, between its ends. Counts begin at 0, and words are taken from a list."""

    name: str
    kind: str
    low: float = 0.0
    high: float = 0.0
    words: tuple[str, ...] = ()

    @property
    def ends(self) -> tuple[float | str, ...]:
        """The farthest changes."""
        return self.words or ((1.0,) if self.kind == COUNT else (1.0, -1.0))

    def rounded(self, level: float | str) -> float | str:
        """The level that a scene can have."""
        if isinstance(level, str):
            return level
        return round(round(level * self.high) / self.high if self.kind == COUNT else level, DIGITS)

    def value(self, level: float | str) -> float | str:
        """The number of a level in the axis's unit, or the word."""
        if isinstance(level, str):
            return level
        if self.kind == FACTOR:
            return float(self.high**level if level >= 0 else self.low**-level)
        return float(self.high * level if level >= 0 else -self.low * level)


# Of the object to move, unless the name says another.
AXES = {
    axis.name: axis
    for axis in (
        Axis("mass_factor", FACTOR, 0.25, 4.0),
        Axis("friction_factor", FACTOR, 0.25, 4.0),
        Axis("size_factor", FACTOR, 0.7, 1.4),
        Axis("color", WORDS, words=COLORS),
        Axis("x_m", OFFSET, -0.15, 0.15),
        Axis("y_m", OFFSET, -0.15, 0.15),
        Axis("yaw_rad", OFFSET, -1.5, 1.5),
        Axis("light_intensity", FACTOR, 0.3, 1.6),
        Axis("light_azimuth_rad", OFFSET, -3.1, 3.1),
        Axis("light_elevation_rad", OFFSET, -0.9, 0.3),
        Axis("table_color", WORDS, words=COLORS),
        Axis("clutter", COUNT, 0, 4),
        Axis("camera_offset_m", OFFSET, -0.2, 0.2),
        Axis("camera_turn_rad", OFFSET, -0.2, 0.2),
        Axis("camera_focal_factor", FACTOR, 0.8, 1.25),
    )
}
# Axes that only cameras have.
OF_CAMERAS = ("camera_offset_m", "camera_turn_rad", "camera_focal_factor")


def axes_named(names: Sequence[str], *, has_cameras: bool) -> list[Axis]:
    """The axes of these names; without names all that the environment has."""
    if unknown := sorted(set(names) - set(AXES)):
        raise ValueError(f"there is no axis {', '.join(unknown)}; choose among {', '.join(AXES)}")
    if not has_cameras and (without := sorted(set(names) & set(OF_CAMERAS))):
        raise ValueError(f"{', '.join(without)} change what no camera observes; prepare the environment with cameras, or leave them out")
    return [axis for axis in AXES.values() if axis.name in names or (not names and (has_cameras or axis.name not in OF_CAMERAS))]


def change_of(levels: Mapping[str, float | str]) -> dict[str, float | str]:
    """The change of such levels, without those that change nothing, in the order of the axes."""
    rounded = {name: AXES[name].rounded(levels[name]) for name in AXES if name in levels}
    return {name: level for name, level in rounded.items() if level != 0}


def distance_of(change: Change, apart: Mapping[str, float]) -> float:
    """The distance of a change from the base scene: the root of the sum of its squared levels. Of a word, `apart` has
    what counts in place of a level."""
    levels = (apart.get(name, 1.0) if isinstance(level, str) else level for name, level in change.items())
    return math.sqrt(sum(level**2 for level in levels))


def operations_of(change: Change, target: str, light: Mapping[str, float]) -> list[dict[str, Any]]:
    """The operations of `tabletopgen edit` that make a change of an object in a scene with this light."""
    values = {name: AXES[name].value(level) for name, level in change.items()}
    found: list[dict[str, Any]] = []
    if "size_factor" in values:
        found.append({"op": "resize", "target": target, "factor": values["size_factor"]})
    if "color" in values:
        found.append({"op": "recolor", "target": target, "color": values["color"]})
    physics: dict[str, Any] = {name: value for name, value in values.items() if name in ("mass_factor", "friction_factor")}
    if physics:
        found.append({"op": "set_physics", "target": target, **physics})
    if "x_m" in values or "y_m" in values:
        offset_m = [values.get("x_m", 0.0), values.get("y_m", 0.0)]
        found.append({"op": "move", "target": target, "where": {"offset_m": offset_m}})
    if "yaw_rad" in values:
        found.append({"op": "rotate", "target": target, "by_rad": values["yaw_rad"]})
    if "table_color" in values:
        found.append({"op": "restyle_table", "color": values["table_color"]})
    if "clutter" in values:
        found.append({"op": "clutter", "count": round(float(values["clutter"]))})
    if any(name.startswith("light_") for name in values):
        found.append({"op": "relight", **light_of(values, light)})
    return found


def light_of(values: Mapping[str, float | str], light: Mapping[str, float]) -> dict[str, float]:
    """The light after a change, as an edit takes it."""
    raised_rad = light["elevation_rad"] + float(values.get("light_elevation_rad", 0.0))
    turned_rad = light["azimuth_rad"] + float(values.get("light_azimuth_rad", 0.0))
    return {
        "azimuth_rad": math.remainder(turned_rad, 2 * math.pi),
        "elevation_rad": min(max(raised_rad, ELEVATION_RAD[0]), ELEVATION_RAD[1]),
        "intensity": min(max(light["intensity"] * float(values.get("light_intensity", 1.0)), 0.3), 2.0),
    }


def base_light(bundle: Path) -> dict[str, float]:
    """The light of a bundle's scene."""
    stated = json.loads((bundle / SCENE).read_text(encoding="utf-8")).get("light")
    return {name: float((stated or USUAL_LIGHT)[name]) for name in USUAL_LIGHT}


def camera_of(change: Change) -> CameraStart:
    """The deviation of cameras in a change: along their own x axis, and about their own y axis."""
    values = {name: float(AXES[name].value(change[name])) for name in OF_CAMERAS if name in change}
    return CameraStart(
        (values.get("camera_offset_m", 0.0), 0.0, 0.0),
        (0.0, values.get("camera_turn_rad", 0.0), 0.0),
        values.get("camera_focal_factor", 1.0),
    )
