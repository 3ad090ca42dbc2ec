"""A folder of records that come one by one, which a stop at any time leaves whole, and which is continued later.

A file states what was asked for, and a file of lines has one record each. One process at a time adds to them.
"""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

LOCK = ".lock"
# Files that are being written.
PARTS = ".*.part"
# Characters of a value that a message has.
SHORT = 60


class RecordFolder:
    """The folder of one kind of work. Its subclasses say what the work is, in a word, the names of both files, by which
    number records are in order, and what of a request may differ when it is continued."""

    work: str
    request: str
    lines: str
    number: str
    free: tuple[str, ...]

    def __init__(self, folder: str | Path):
        self.folder = Path(folder)

    @contextmanager
    def held(self, document: Mapping[str, Any]) -> Iterator[None]:
        """Keeps other processes from the folder, and begins or continues what the document asks for."""
        if self.folder.exists() and not self.folder.is_dir():
            raise ValueError(f"{self.folder} is a file; name a folder for the {self.work}")
        if self.folder.is_dir() and not (self.folder / self.request).is_file() and any(path.name != LOCK for path in self.folder.iterdir()):
            raise ValueError(f"{self.folder} has files, but is no {self.work}; name another folder")
        self.folder.mkdir(parents=True, exist_ok=True)
        with open(self.folder / LOCK, "w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                raise ValueError(f"another process runs the {self.work} in {self.folder}; wait for it, or name another folder") from error
            self._begin(document)
            yield

    def _begin(self, document: Mapping[str, Any]) -> None:
        if not (self.folder / self.request).is_file():
            self.write(self.request, (json.dumps(document, indent=1) + "\n").encode())
        elif others := differences(self.document(), document, self.free):
            raise ValueError(
                f"{self.folder} has the {self.work} of another request ({'; '.join(others)}); name another folder, or ask for the same"
            )
        self._cut_torn_line()
        for part in self.folder.glob(PARTS):
            part.unlink(missing_ok=True)

    def document(self) -> dict[str, Any]:
        """The content of the file that states what was asked for."""
        path = self.folder / self.request
        if not path.is_file():
            raise ValueError(f"{self.folder} is no {self.work}: it has no {self.request}; name the folder of --out of one")
        document: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return document

    def records(self) -> list[dict[str, Any]]:
        """The records by their numbers. A line that a stop left without its end is none."""
        path = self.folder / self.lines
        lines = path.read_bytes().split(b"\n")[:-1] if path.is_file() else []
        return sorted((json.loads(line) for line in lines), key=lambda record: int(record[self.number]))

    def append(self, record: Mapping[str, Any]) -> None:
        """Adds a record, once its other files are written."""
        line = json.dumps(record, allow_nan=False) + "\n"
        with open(self.folder / self.lines, "ab") as file:
            file.write(line.encode())
            file.flush()
            os.fsync(file.fileno())

    def _cut_torn_line(self) -> None:
        path = self.folder / self.lines
        if path.is_file():
            content = path.read_bytes()
            if not content.endswith(b"\n"):
                os.truncate(path, content.rfind(b"\n") + 1)

    def write(self, name: str, content: bytes) -> None:
        """Writes a file of the folder, which exists as a whole or not at all."""
        write_whole(self.folder / name, content)


def write_whole(path: Path, content: bytes) -> None:
    """Writes a file, which exists as a whole or not at all."""
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


def differences(before: Mapping[str, Any], now: Mapping[str, Any], free: tuple[str, ...]) -> list[str]:
    """Differences between two documents that decide the work, in words; `free` names what may differ."""
    names = [name for name in {**before, **now} if name not in free]
    return [f"{name}: {short(before.get(name))} before, {short(now.get(name))} now" for name in names if before.get(name) != now.get(name)]


def short(value: Any) -> str:
    """A value in words that fit into a message."""
    text = str(value)
    return text if len(text) <= SHORT else f"{text[:SHORT]}..."
