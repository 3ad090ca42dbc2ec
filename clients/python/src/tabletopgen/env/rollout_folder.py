"""The folder of a rollout, which a stop at any time leaves whole.

    rollout.json          what was asked for
    episodes.jsonl        one record of a finished episode a line, in the order in which they finished
    actions/NNNNNN.npz    actions of each episode, and the positions of all joints in its last state
    videos/NNNNNN.png     animated images of the first episodes
    summary.json, summary.md
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tabletopgen.env.record_folder import PARTS, RecordFolder
from tabletopgen.env.rollout_request import FREE

REQUEST, RECORDS, ACTIONS, VIDEOS = "rollout.json", "episodes.jsonl", "actions", "videos"


class RolloutFolder(RecordFolder):
    """Files of a rollout."""

    work, request, lines, number, free = "rollout", REQUEST, RECORDS, "episode", FREE

    def _begin(self, document: Mapping[str, Any]) -> None:
        super()._begin(document)
        for name in (ACTIONS, VIDEOS):
            (self.folder / name).mkdir(exist_ok=True)
            for part in (self.folder / name).glob(PARTS):
                part.unlink(missing_ok=True)

    def write_actions(self, number: int, actions: NDArray[np.float32], final_qpos: NDArray[np.float64]) -> None:
        content = io.BytesIO()
        np.savez(content, actions=actions, final_qpos=final_qpos)
        self.write(f"{ACTIONS}/{number:06d}.npz", content.getvalue())

    def actions(self, number: int) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        """The actions of an episode, (steps, numbers), and the positions of all joints in its last state."""
        path = self.folder / ACTIONS / f"{number:06d}.npz"
        if not path.is_file():
            raise ValueError(f"{path} does not exist; copy all of {ACTIONS}/ with a rollout")
        with np.load(path) as found:
            return found["actions"], found["final_qpos"]
