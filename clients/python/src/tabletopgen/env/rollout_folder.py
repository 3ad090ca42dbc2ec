"""The folder of a rollout, which a stop at any time leaves whole.

    rollout.json          what was asked for
    episodes.jsonl        one record of a finished episode a line, in the order in which they finished
    actions/NNNNNN.npz    actions of each episode, and the positions of all joints in its last state
    videos/NNNNNN.png     animated images of the first episodes
    summary.json, summary.md
"""

from __future__ import annotations

import fcntl
import io
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tabletopgen.env.rollout_request import Request, differences

REQUEST, RECORDS, ACTIONS, VIDEOS, LOCK = "rollout.json", "episodes.jsonl", "actions", "videos", ".lock"
# Files that are being written.
PARTS = ".*.part"


class RolloutFolder:
    """Files of a rollout."""

    def __init__(self, folder: str | Path):
        self.folder = Path(folder)

    @contextmanager
    def held(self, request: Request) -> Iterator[None]:
        """Keeps other processes from running the rollout, begins it or continues it."""
        document = request.document()
        if self.folder.exists() and not self.folder.is_dir():
            raise ValueError(f"{self.folder} is a file; name a folder for the rollout")
        if self.folder.is_dir() and not (self.folder / REQUEST).is_file() and any(path.name != LOCK for path in self.folder.iterdir()):
            raise ValueError(f"{self.folder} has files, but is no rollout; name another folder")
        self.folder.mkdir(parents=True, exist_ok=True)
        with open(self.folder / LOCK, "w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                raise ValueError(f"another process runs the rollout in {self.folder}; wait for it, or name another folder") from error
            self._begin(document)
            yield

    def _begin(self, document: Mapping[str, Any]) -> None:
        if not (self.folder / REQUEST).is_file():
            for name in (ACTIONS, VIDEOS):
                (self.folder / name).mkdir(exist_ok=True)
            self.write(REQUEST, (json.dumps(document, indent=1) + "\n").encode())
        elif others := differences(self.document(), document):
            raise ValueError(
                f"{self.folder} has the rollout of another request ({'; '.join(others)}); name another folder, or ask for the same"
            )
        self._cut_torn_line()
        for part in self.folder.rglob(PARTS):
            part.unlink(missing_ok=True)

    def document(self) -> dict[str, Any]:
        """What was asked for."""
        path = self.folder / REQUEST
        if not path.is_file():
            raise ValueError(f"{self.folder} is no rollout: it has no {REQUEST}; name the folder of --out of `rollout`")
        document: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return document

    def records(self) -> list[dict[str, Any]]:
        """Records of the finished episodes, by their numbers. A line that a stop left without its end is none."""
        path = self.folder / RECORDS
        lines = path.read_bytes().split(b"\n")[:-1] if path.is_file() else []
        return sorted((json.loads(line) for line in lines), key=lambda record: int(record["episode"]))

    def append(self, record: Mapping[str, Any]) -> None:
        """Adds the record of a finished episode, once its other files are written."""
        line = json.dumps(record, allow_nan=False) + "\n"
        with open(self.folder / RECORDS, "ab") as file:
            file.write(line.encode())
            file.flush()
            os.fsync(file.fileno())

    def _cut_torn_line(self) -> None:
        path = self.folder / RECORDS
        if path.is_file():
            content = path.read_bytes()
            if not content.endswith(b"\n"):
                os.truncate(path, content.rfind(b"\n") + 1)

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

    def write(self, name: str, content: bytes) -> None:
        """Writes a file, which exists as a whole or not at all."""
        path = self.folder / name
        part = path.with_name(PARTS.replace("*", f"{path.name}.{os.getpid()}"))
        with open(part, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            # A record names the file: its name has to last as long.
            os.fsync(folder)
        finally:
            os.close(folder)
