"""What a policy is to a rollout: it begins an episode, and gives an action for each observation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, TypedDict

from tabletopgen.env.folder import EnvironmentFolder
from tabletopgen.env.scene_env import Observation, SceneEnv
from tabletopgen.env.vectors import Vector
from tabletopgen.errors import TabletopgenError


class PolicyFailedError(TabletopgenError):
    """A policy without an action for an observation. It ends the episode."""


class PolicyUnavailableError(TabletopgenError):
    """A policy that cannot be asked at all. It ends the rollout, which can be continued."""


class Policy(Protocol):
    """A policy in a process. A method `close()`, where there is one, is called in the end."""

    def reset(self, info: Mapping[str, Any]) -> None:
        """Begins an episode. `info` has its number (`episode`), a `seed` for all that the policy draws by chance, the
        `instruction`, the folder of the `environment`, the `start`, and the `recorded_episode` that the start is of."""

    def act(self, observation: Observation) -> Vector:
        """The action for an observation, numbers in the order of `action_names`."""
        ...


class Description(TypedDict):
    """What a policy is made for: an environment as observed and acted upon."""

    environment: str
    instruction: str
    robot: str
    fps: int
    max_steps: int
    action_mode: str
    action_names: list[str]
    action_low: list[float]
    action_high: list[float]
    state_names: list[str]
    observation_shapes: dict[str, list[int]]
    objects: list[str]


def description_of(env: SceneEnv, files: EnvironmentFolder, action_mode: str, rename: Mapping[str, str]) -> Description:
    """The description of an environment, with other names of observations where some are given."""
    space: Any = env.observation_space
    bounds: Any = env.action_space
    return {
        "environment": str(files.folder),
        "instruction": env.task_description,
        "robot": files.robot.name,
        "fps": files.fps,
        "max_steps": env._max_episode_steps,
        "action_mode": action_mode,
        "action_names": env.action_names,
        "action_low": bounds.low.tolist(),
        "action_high": bounds.high.tolist(),
        "state_names": env.state_names,
        "observation_shapes": {rename.get(name, name): list(part.shape) for name, part in space.spaces.items()},
        "objects": list(files.objects),
    }
