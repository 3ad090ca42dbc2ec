# Written by generate.py from `_async`.
"""Demonstrations of a robot in a scene, recorded as a dataset."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tabletopgen import _archive, _requests, models
from tabletopgen._progress import Bar
from tabletopgen._requests import escaped, get, post
from tabletopgen._sync.connection import Connection
from tabletopgen.errors import WorkFailedError

RECORDING_ENDED = ("finished", "failed", "cancelled")
LEROBOT = "lerobot-"


class Recording:
    """A recording as the server knew it when it was asked last; `refresh` asks again."""

    def __init__(self, connection: Connection, data: models.Recording):
        self._connection = connection
        #: Everything that the server says of it.
        self.data = data

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.id} {self.state}>"

    @property
    def id(self) -> str:
        """The UUID of the recording."""
        return str(self.data.id)

    @property
    def state(self) -> str:
        """`finished`, `failed` and `cancelled` are final."""
        return self.data.state

    @property
    def formats(self) -> list[str]:
        """Formats of the finished dataset."""
        return [one.format for one in self.data.dataset.formats] if self.data.dataset else []

    def refresh(self) -> Recording:
        """The same recording, as it is now."""
        self.data = self._connection.ask(get(f"/episodes/{self.id}"), models.Recording)
        return self

    def events(self, after: int = 0, timeout_secs: float | None = None) -> Iterator[models.RecordingEvent]:
        """Events as they happen, until the recording has ended; `after` is the `seq` of the last one seen."""
        return self._connection.events(
            f"/episodes/{self.id}/events",
            models.RecordingEvent,
            lambda event: event.kind in RECORDING_ENDED,
            after,
            timeout_secs,
        )

    def wait(self, timeout_secs: float | None = None, *, progress: bool | None = None) -> Recording:
        """The recording once it is finished. Raises `WorkFailedError` where it failed or was cancelled."""
        shown, attempts = self._connection.progress if progress is None else progress, 0
        with Bar(shown, "attempts") as bar:
            for event in self.events(timeout_secs=timeout_secs):
                attempts += event.kind == "attempt"
                bar.show(attempts, event.kind)
        self.refresh()
        if self.state != "finished":
            raise WorkFailedError(f"recording {self.id}", self.data.failure, self.state)
        return self

    def files(self) -> Iterator[models.DatasetFile]:
        """The files of the dataset, in every format."""
        path, parse = f"/episodes/{self.id}/files", models.RecordingFilePage.model_validate_json
        return self._connection.pages(path, parse, lambda page: page.files)

    def download(self, folder: str | Path, format: str | None = None) -> Path:
        """The dataset in a format, or in its first one, unpacked into a folder; that folder."""
        path = f"/episodes/{self.id}/archives/{escaped(format or self.formats[0])}"
        return self._connection.unpacked(path, folder, _archive.unpack_tar)

    def to_lerobot(self, folder: str | Path) -> Path:
        """The dataset for LeRobot, in a folder to give as `root` to `LeRobotDataset`."""
        format = next((name for name in self.formats if name.startswith(LEROBOT)), None)
        if format is None:
            raise ValueError(f"recording {self.id} has no format for LeRobot but {', '.join(self.formats) or 'none yet'}")
        return self.download(folder, format)

    def cancel(self) -> Recording:
        """Cancels a recording that has not ended; its episodes so far are dropped."""
        self.data = self._connection.ask(post(f"/episodes/{self.id}/cancel", repeatable=True), models.Recording)
        return self

    def delete(self) -> None:
        """Deletes the recording with its dataset; deleting twice is fine."""
        self._connection.send(_requests.Request("DELETE", f"/episodes/{self.id}"))
