"""The file of a suite: scenes, tasks and variations, of which each combination becomes an environment."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from tabletopgen.env.counterexample_axes import AXES, FACTOR, Axis, Change, axes_named

# The word that names the file of the package.
DEFAULT = "default"
DEFAULT_FILE = Path(__file__).with_name("suite_default.json")

Name = Annotated[str, Field(pattern=r"^[a-z0-9_]{1,40}$")]
Text = Annotated[str, Field(min_length=1)]


class Strict(BaseModel):
    """A part of the file, which has no other members."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class SceneOrder(Strict):
    """A text that a scene is generated from with a seed, or the folder of a bundle, relative to the file."""

    text: Text | None = None
    seed: int = Field(default=0, ge=0)
    bundle: Text | None = None

    @model_validator(mode="after")
    def _is_one(self) -> SceneOrder:
        if (self.text is None) == (self.bundle is None):
            raise ValueError("a scene has either a text or a bundle")
        return self


class VariationOrder(Strict):
    """How starts are drawn, as `tabletopgen episodes --randomize` takes it, and what of the scene is changed before:
    values of axes of `counterexamples`, in their units."""

    randomize: Literal["usual", "wide", "none"] | dict[str, float] = "usual"
    change: dict[str, float | str] = {}


class SuiteOrder(Strict):
    """What a suite is made from. A task has an instruction for all scenes, or one for each of some."""

    name: Name
    version: Text
    seed: int = Field(default=0, ge=0)
    robot: str = "panda"
    starts: int = Field(default=5, ge=1)
    fps: int = Field(default=15, ge=1)
    cameras: list[str] = ["front", "wrist"]
    size_px: int = Field(default=224, ge=1)
    scenes: dict[Name, SceneOrder] = Field(min_length=1)
    tasks: dict[Name, Text | dict[Name, Text]] = Field(min_length=1)
    variations: dict[Name, VariationOrder] = {"usual": VariationOrder()}

    @model_validator(mode="after")
    def _is_makeable(self) -> SuiteOrder:
        named = {scene for instructions in self.tasks.values() if isinstance(instructions, dict) for scene in instructions}
        if unknown := sorted(named - set(self.scenes)):
            raise ValueError(f"tasks name the scenes {', '.join(unknown)}, which are not among {', '.join(self.scenes)}")
        for variation in self.variations.values():
            axes_named(list(variation.change), has_cameras=bool(self.cameras))
            levels_of(variation.change)
        return self

    @classmethod
    def read(cls, path: Path) -> SuiteOrder:
        if not path.is_file():
            raise ValueError(f"{path} is no file of a suite; name one, or the suite {DEFAULT!r} of the package")
        try:
            return cls.model_validate_json(path.read_bytes())
        except ValidationError as error:
            faults = "; ".join(f"{'.'.join(map(str, one['loc'])) or 'document'}: {one['msg']}" for one in error.errors())
            raise ValueError(f"{path} describes no suite: {faults}; docs/environments.md has an example") from error

    def document(self) -> dict[str, Any]:
        """The same as JSON, with all defaults."""
        return self.model_dump(mode="json", exclude_none=True)

    def combinations(self) -> list[Combination]:
        """All of them, in the order of the file."""
        found = []
        for scene in self.scenes:
            for task, instructions in self.tasks.items():
                instruction = instructions if isinstance(instructions, str) else instructions.get(scene)
                if instruction is not None:
                    found += [Combination(scene, task, variation, instruction) for variation in self.variations]
        return found


@dataclass(frozen=True)
class Combination:
    """A task in a scene with a variation."""

    scene: str
    task: str
    variation: str
    instruction: str

    @property
    def name(self) -> str:
        """The name of its environment."""
        return f"{self.scene}-{self.task}-{self.variation}"


def file_of(words: str | Path) -> Path:
    """The file that these words name."""
    return DEFAULT_FILE if str(words) == DEFAULT else Path(words)


def levels_of(values: Mapping[str, float | str]) -> Change:
    """The change of a scene that has these values."""
    return {name: level_of(AXES[name], value) for name, value in values.items()}


def level_of(axis: Axis, value: float | str) -> float | str:
    """The level of an axis that has a value: the inverse of `Axis.value`."""
    if isinstance(value, str) or axis.words:
        if value not in axis.words:
            raise ValueError(f"{axis.name} is no {value!r}; give {', '.join(axis.words) or f'a number from {axis.low} to {axis.high}'}")
        return value
    if not axis.low <= value <= axis.high:
        raise ValueError(f"{axis.name} of {value} is beyond {axis.low} to {axis.high}; stay within")
    if axis.kind == FACTOR:
        return math.log(value) / math.log(axis.high) if value >= 1 else -math.log(value) / math.log(axis.low)
    return value / axis.high if value >= 0 else -value / axis.low
