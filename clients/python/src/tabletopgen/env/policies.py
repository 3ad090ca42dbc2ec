"""Kinds of policies, by the words that name one.

    random              actions drawn evenly between their bounds
    recorded:DATASET    the recorded actions of the episode whose start it gets
    lerobot:FOLDER      a checkpoint of LeRobot
    ws://HOST:PORT      a server of openpi's websocket protocol
    MODULE:FUNCTION     what a function of a module or of a file `path/file.py` returns, given a `Description`
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tabletopgen._sync.connection import digest_of
from tabletopgen.env.folder_digest import digest_of_folder
from tabletopgen.env.lerobot_policy import LeRobotPolicy
from tabletopgen.env.policy import Description, Policy
from tabletopgen.env.policy_server import ServerPolicy
from tabletopgen.env.recorded_dataset import RECORDS, RecordedDataset
from tabletopgen.env.scene_env import Observation
from tabletopgen.env.vectors import Vector, action_names

RANDOM, RECORDED, LEROBOT, SERVERS = "random", "recorded:", "lerobot:", ("ws://", "wss://")


def policy_of(name: str, description: Description, chunk: int | None = None) -> Policy:
    """Makes a policy for an environment. `chunk` is the number of actions that are carried out of each answer of a
    server, all if absent."""
    if name.startswith(SERVERS):
        return ServerPolicy(name, description, chunk)
    if name.startswith(LEROBOT):
        return LeRobotPolicy(name.removeprefix(LEROBOT), description)
    if name.startswith(RECORDED):
        return RecordedPolicy(name.removeprefix(RECORDED), description)
    if name == RANDOM:
        return RandomPolicy(description)
    made = function_of(name)(description)
    missing = [method for method in ("reset", "act") if not callable(getattr(made, method, None))]
    if missing:
        raise ValueError(f"{name} returned a {type(made).__name__} without {' and '.join(missing)}; return a policy that has both")
    policy: Policy = made
    return policy


def default_action_mode(name: str) -> str:
    """The mode of actions of such policies: those of LeRobot are trained on all numbers of a dataset's action."""
    return "recorded" if name.startswith(LEROBOT) else "joint"


def digest_of_policy(name: str) -> str | None:
    """The digest of the files that make a policy, so that a rollout continues with no other. A server has none."""
    if name.startswith(LEROBOT):
        return digest_of_folder(Path(name.removeprefix(LEROBOT)))
    if name.startswith(RECORDED):
        return digest_of(RecordedDataset(name.removeprefix(RECORDED)).folder / RECORDS)
    if name.startswith(SERVERS) or name == RANDOM:
        return None
    function_of(name)
    path = module_of(name.rpartition(":")[0]).__file__
    return digest_of(Path(path)) if path is not None else None


def function_of(name: str) -> Callable[[Description], Any]:
    """The function that makes a policy."""
    place, _, function = name.rpartition(":")
    if not place or not function:
        raise ValueError(
            f"{name!r} names no policy; give {RANDOM}, {RECORDED}DATASET, {LEROBOT}FOLDER, {SERVERS[0]}HOST:PORT, MODULE:FUNCTION or"
            " path/file.py:FUNCTION"
        )
    module = module_of(place)
    found = getattr(module, function, None)
    if not callable(found):
        raise ValueError(f"{place} has no function {function!r} that makes a policy")
    made: Callable[[Description], Any] = found
    return made


def module_of(place: str) -> Any:
    """A module by its name, or that of a file `path/file.py`."""
    try:
        return module_of_file(Path(place)) if place.endswith(".py") else importlib.import_module(place)
    except (ImportError, OSError) as error:
        raise ValueError(f"{place or 'a module without a name'}, which is to make the policy, cannot be imported: {error}") from error


def module_of_file(path: Path) -> Any:
    """The module of a file, imported once."""
    name = f"tabletopgen_policy_{hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:12]}"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, path)
        if spec is None or spec.loader is None:
            raise ImportError(f"{path} is no file of Python")
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
    return sys.modules[name]


class RandomPolicy:
    """Actions drawn evenly between their bounds: what succeeds without any skill."""

    def __init__(self, description: Description):
        self.low, self.high = np.array(description["action_low"]), np.array(description["action_high"])
        self._random = np.random.default_rng(0)

    def reset(self, info: Mapping[str, Any]) -> None:
        self._random = np.random.default_rng(int(info["seed"]))

    def act(self, observation: Observation) -> Vector:
        drawn: Vector = self._random.uniform(self.low, self.high).astype(np.float32)
        return drawn


class RecordedPolicy:
    """The recorded actions of the episode whose start it gets, of which the last one is repeated: what the best policy
    that learns from the dataset can be expected to reach."""

    def __init__(self, dataset: str, description: Description):
        self.dataset = RecordedDataset(dataset)
        joints = [name.removesuffix("_rad") for name in description["state_names"] if name.endswith("_rad")]
        names = action_names(joints)
        self.columns = [names.index(name) for name in description["action_names"]]
        self._rows: Vector = np.empty((0, len(self.columns)), dtype=np.float32)
        self._step = 0

    def reset(self, info: Mapping[str, Any]) -> None:
        self._rows = self.dataset.frames(int(info["recorded_episode"]), ["action"])["action"][:, self.columns]
        self._step = 0

    def act(self, observation: Observation) -> Vector:
        row: Vector = self._rows[min(self._step, len(self._rows) - 1)]
        self._step += 1
        return row
