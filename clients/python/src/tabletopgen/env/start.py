"""What one episode of a recorded dataset starts from: the sample that its randomization drew."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

# Objects that a wide randomization adds are in no file of the scene.
ADDED = "distractor_"


@dataclass(frozen=True)
class ObjectStart:
    """One object: `world_from_object` where it is at rest before the robot moves, as `translation_m` and
    `rotation_xyzw`, and factors of what the scene states. `None` for an object that is absent."""

    world_from_object: Mapping[str, Any] | None
    mass_factor: float
    friction_factor: float
    tint: tuple[float, float, float]


@dataclass(frozen=True)
class CameraStart:
    """How a camera deviates from its description, in its own axes."""

    offset_m: tuple[float, float, float]
    turn_rad: tuple[float, float, float]
    focal_factor: float


# A camera that does not deviate.
AS_DESCRIBED = CameraStart((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1.0)


@dataclass(frozen=True)
class LightStart:
    """How the light deviates: about the vertical, in elevation, and in brightness."""

    turn_rad: float
    raise_rad: float
    brightness_factor: float


@dataclass(frozen=True)
class Start:
    """The start of an episode. `positions_rad` and `opening_m` are those of its first frame."""

    episode: int
    objects: Mapping[str, ObjectStart]
    positions_rad: tuple[float, ...]
    opening_m: float
    tool_quaternion_wxyz: tuple[float, ...]
    cameras: tuple[CameraStart, ...]
    table_tint: tuple[float, float, float]
    light: LightStart

    def to_json(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> Start:
        objects = {name: ObjectStart(**{**drawn, "tint": tuple(drawn["tint"])}) for name, drawn in document["objects"].items()}
        cameras = tuple(camera_start(drawn) for drawn in document["cameras"])
        numbers = {key: tuple(document[key]) for key in ("positions_rad", "tool_quaternion_wxyz", "table_tint")}
        return cls(**{**document, **numbers, "objects": objects, "cameras": cameras, "light": LightStart(**document["light"])})

    @classmethod
    def of_record(cls, episode: int, record: Mapping[str, Any], positions_rad: Any, opening_m: float, tool_quaternion_wxyz: Any) -> Start:
        """From an episode's record, and from numbers of its first state."""
        sample, at_rest = record["sample"], dict(record["initial_poses"])
        objects = {
            drawn["name"]: ObjectStart(at_rest.get(drawn["name"]), drawn["mass_factor"], drawn["friction_factor"], tuple(drawn["tint"]))
            for drawn in sample["objects"]
            if not drawn["name"].startswith(ADDED)
        }
        return cls(
            episode=episode,
            objects=objects,
            positions_rad=tuple(map(float, positions_rad)),
            opening_m=float(opening_m),
            tool_quaternion_wxyz=tuple(map(float, tool_quaternion_wxyz)),
            cameras=tuple(camera_start(drawn) for drawn in sample["cameras"]),
            table_tint=tuple(sample["table_tint"]),
            light=LightStart(**sample["light"]),
        )


def camera_start(drawn: Mapping[str, Any]) -> CameraStart:
    return CameraStart(tuple(drawn["offset_m"]), tuple(drawn["turn_rad"]), drawn["focal_factor"])
