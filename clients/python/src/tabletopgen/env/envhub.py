"""An environment as a package of LeRobot's EnvHub: a repository whose `env.py` has the function `make_env`.

    from lerobot.envs.factory import make_env

    environments = make_env("me/can_on_plate", n_envs=2, trust_remote_code=True)
"""

from __future__ import annotations

import re
import shutil
from functools import partial
from pathlib import Path
from typing import Any, cast

import gymnasium
from gymnasium import spaces
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv, VectorEnv

from tabletopgen._media import imported
from tabletopgen.env.folder import DESCRIPTION, EnvironmentFolder
from tabletopgen.env.scene_env import IMAGES, OBJECTS, STATE, Observation, SceneEnv
from tabletopgen.env.vectors import Vector, action_names, state_names

# What LeRobot's evaluation calls states.
NAMES = {STATE: "agent_pos", OBJECTS: "environment_state"}
# The folder of a snapshot in the cache of the Hub.
COMMIT = re.compile(r"[0-9a-f]{40}")
ENTRY = '''"""The environment of the task "{task}" for LeRobot's EnvHub."""

from pathlib import Path

from tabletopgen.env import envhub

REPOSITORY = "{repository}"


def make_env(n_envs=1, use_async_envs=False, cfg=None):
    """Environments of the task, as `lerobot.envs.factory.make_env` wants them."""
    return envhub.make_env(Path(__file__).parent, REPOSITORY, n_envs, use_async_envs)
'''
CARD = """---
library_name: lerobot
tags: [robotics, lerobot, simulation]
---

# {task}

An environment for [EnvHub](https://huggingface.co/docs/lerobot/envhub): the {robot} in a scene of tabletopgen, simulated by
MuJoCo, with {starts} recorded starts at {fps} steps per second. It needs `pip install "tabletopgen[env]"` with the program,
which decides when the task is done.

```python
from lerobot.envs.factory import make_env

environments = make_env("{repository}", n_envs=2, trust_remote_code=True)
```

States are `{state}` ({states} numbers), images those of {cameras}. Actions are all {actions} numbers of the datasets' `action`.
"""


class LeRobotEnv(gymnasium.Wrapper[Observation, Vector, Observation, Vector]):
    """An environment whose observations have the names that LeRobot's evaluation turns into those of its datasets."""

    def __init__(self, env: SceneEnv):
        super().__init__(env)
        self.task_description, self._max_episode_steps = env.task_description, env._max_episode_steps
        own = env.observation_space
        assert isinstance(own, spaces.Dict)
        parts: dict[str, spaces.Space[Any]] = {name: own[key] for key, name in NAMES.items() if key in own.spaces}
        if images := {key.removeprefix(IMAGES): own[key] for key in own.spaces if key.startswith(IMAGES)}:
            parts["pixels"] = spaces.Dict(images)
        self.observation_space = cast("spaces.Space[Observation]", spaces.Dict(parts))

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        observed, info = self.env.reset(seed=seed, options=options)
        return renamed(observed), info

    def step(self, action: Vector) -> tuple[Observation, Any, bool, bool, dict[str, Any]]:
        observed, reward, is_done, is_cut, info = self.env.step(action)
        return renamed(observed), reward, is_done, is_cut, info


def renamed(observed: Observation) -> Observation:
    """An observation under the names of LeRobot's evaluation."""
    parts: dict[str, Any] = {name: observed[key] for key, name in NAMES.items() if key in observed}
    if images := {key.removeprefix(IMAGES): image for key, image in observed.items() if key.startswith(IMAGES)}:
        parts["pixels"] = images
    return parts


def made(folder: Path) -> LeRobotEnv:
    """One environment of a folder. Its actions are those of the datasets as a whole, which policies are trained on."""
    return LeRobotEnv(SceneEnv(folder=folder, action_mode="recorded", render_mode="rgb_array"))


def make_env(place: Path, repository: str, n_envs: int, use_async_envs: bool) -> dict[str, dict[int, VectorEnv[Any, Any, Any]]]:
    """The environments of a package whose `env.py` lies in `place`. EnvHub fetches that file alone; the others are
    fetched from the same commit of the repository."""
    folder = place
    if not (place / DESCRIPTION).is_file():
        revision = place.name if COMMIT.fullmatch(place.name) else None
        folder = Path(imported("huggingface_hub").snapshot_download(repository, revision=revision))
    makers = [partial(made, folder)] * n_envs
    # LeRobot reads the success of an episode from the step that ends it.
    mode = AutoresetMode.SAME_STEP
    vector: VectorEnv[Any, Any, Any]
    if use_async_envs:
        vector = AsyncVectorEnv(makers, autoreset_mode=mode, context="forkserver")
    else:
        vector = SyncVectorEnv(makers, autoreset_mode=mode)
    return {"tabletopgen": {0: vector}}


def write_package(files: EnvironmentFolder, folder: str | Path, repository: str) -> Path:
    """Writes the files of a repository for EnvHub, which is to have the name `repository`; their folder."""
    folder = Path(folder)
    shutil.copytree(files.folder, folder)
    task = files.task["instruction"]
    (folder / "env.py").write_text(ENTRY.format(task=task, repository=repository), encoding="utf-8")
    card = CARD.format(
        task=task,
        repository=repository,
        robot=files.robot.name,
        starts=len(files.starts),
        fps=files.fps,
        state=STATE,
        states=len(state_names(files.robot.joints)),
        cameras=", ".join(f"`{camera.name}`" for camera in files.cameras) or "no cameras",
        actions=len(action_names(files.robot.joints)),
    )
    (folder / "README.md").write_text(card, encoding="utf-8")
    (folder / "requirements.txt").write_text("tabletopgen[env]\n", encoding="utf-8")
    return folder
