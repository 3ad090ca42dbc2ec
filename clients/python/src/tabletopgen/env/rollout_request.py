"""What a rollout is asked for: all that decides its episodes, so that it can be continued."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

import tabletopgen
from tabletopgen.env.control import CONTROLS
from tabletopgen.env.engine import mujoco
from tabletopgen.env.folder import EnvironmentFolder
from tabletopgen.env.folder_digest import digest_of_folder
from tabletopgen.env.policies import default_action_mode, digest_of_policy

FORMAT = "tabletopgen-rollout/1"
# What may differ where a rollout is continued: where folders lie now, and versions that change no motion.
FREE = ("folders", "python", "numpy", "gymnasium")


@dataclass(frozen=True)
class Request:
    """Environments by name, folder and digest, the policy, and how it acts in them."""

    environments: tuple[str, ...]
    folders: tuple[str, ...]
    digests: tuple[str, ...]
    policy: str
    policy_digest: str | None
    episodes: int
    seed: int
    videos: int
    action_mode: str
    images: bool
    object_poses: bool
    chunk: int | None
    max_duration_s: float | None
    rename: Mapping[str, str]

    @classmethod
    def of(
        cls,
        folders: Sequence[str | Path],
        policy: str,
        *,
        episodes: int | None = None,
        seed: int = 0,
        videos: int = 0,
        action_mode: str | None = None,
        images: bool = True,
        object_poses: bool = False,
        chunk: int | None = None,
        max_duration_s: float | None = None,
        rename: Mapping[str, str] | None = None,
    ) -> Request:
        """The request for these environments. Without `episodes`, each start is taken once. `chunk` is that of
        `policy_of`, `rename` gives observations other names, and the rest are arguments of `SceneEnv`. Raises
        `ValueError` for what cannot be run."""
        files = [EnvironmentFolder.read(folder) for folder in folders]
        refuse_unlike(files)
        count = sum(len(one.starts) for one in files) if episodes is None else episodes
        mode = action_mode or default_action_mode(policy)
        if count < 1 or seed < 0 or videos < 0:
            raise ValueError(
                f"{count} episodes with seed {seed} and {videos} videos cannot be run; give one episode or more, and no negative number"
            )
        if mode not in CONTROLS:
            raise ValueError(f"there is no action mode {mode!r}; choose one of {', '.join(CONTROLS)}")
        if max_duration_s is not None and not max_duration_s > 0:
            raise ValueError(f"episodes of {max_duration_s} s have no step; give more than 0")
        return cls(
            environments=tuple(names_of(files)),
            folders=tuple(str(one.folder.resolve()) for one in files),
            digests=tuple(digest_of_folder(one.folder) for one in files),
            policy=policy,
            policy_digest=digest_of_policy(policy),
            episodes=count,
            seed=seed,
            videos=videos,
            action_mode=mode,
            images=images,
            object_poses=object_poses,
            chunk=chunk,
            max_duration_s=max_duration_s,
            rename=dict(rename or {}),
        )

    def document(self) -> dict[str, Any]:
        """The content of `rollout.json`."""
        versions = {
            "tabletopgen": tabletopgen.__version__,
            "mujoco": mujoco.__version__,
            "gymnasium": gymnasium.__version__,
            "numpy": np.__version__,
            "python": platform.python_version(),
        }
        lists = {name: list(getattr(self, name)) for name in ("environments", "folders", "digests")}
        return {"format": FORMAT, **asdict(self), **lists, **versions}

    @classmethod
    def of_document(cls, document: Mapping[str, Any]) -> Request:
        """The request that such a file has."""
        lists = {name: tuple(document[name]) for name in ("environments", "folders", "digests")}
        return cls(**{**{name: document[name] for name in cls.__dataclass_fields__}, **lists})


def names_of(files: Sequence[EnvironmentFolder]) -> list[str]:
    """Names of folders; whole paths where two have the same name."""
    folders = [one.folder.resolve() for one in files]
    names = [folder.name for folder in folders]
    if len(set(folders)) < len(folders):
        raise ValueError(f"an environment is named twice in {', '.join(map(str, folders))}; name each once")
    return names if len(set(names)) == len(names) else [str(folder) for folder in folders]


def refuse_unlike(files: Sequence[EnvironmentFolder]) -> None:
    """Refuses environments that one policy cannot act in: of other robots or rates."""
    if not files:
        raise ValueError("no environment is named; give the folders of one or more that `prepare` wrote")
    first = files[0]
    for other in files[1:]:
        if (other.robot.name, other.robot.joints, other.fps) != (first.robot.name, first.robot.joints, first.fps):
            raise ValueError(
                f"{other.folder} has the robot {other.robot.name!r} at {other.fps} steps per second, {first.folder} {first.robot.name!r} at"
                f" {first.fps}; run a policy in them one by one"
            )
