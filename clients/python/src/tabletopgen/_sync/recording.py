# Written by generate.py from `_async`.
"""Demonstrations of a robot in a scene, recorded as a dataset."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from typing_extensions import Self

from tabletopgen import _archive, hub, models, rrd
from tabletopgen._requests import escaped
from tabletopgen._sync import io
from tabletopgen._sync.resource import Resource
from tabletopgen.errors import WorkFailedError

RECORDING_ENDED = ("finished", "failed", "cancelled")
LEROBOT = "lerobot-"


class Recording(Resource[models.Recording]):
    """A recording; of its states `finished`, `failed` and `cancelled` are final."""

    _paths, _model = "/episodes", models.Recording

    @property
    def formats(self) -> list[str]:
        """Formats of the finished dataset."""
        return [one.format for one in self.data.dataset.formats] if self.data.dataset else []

    def events(self, after: int = 0, timeout_secs: float | None = None) -> Iterator[models.RecordingEvent]:
        """Events as they happen, until the recording has ended; `after` is the `seq` of the last one seen."""
        return self._connection.events(
            f"{self._path}/events",
            models.RecordingEvent,
            lambda event: event.kind in RECORDING_ENDED,
            after,
            timeout_secs,
        )

    def wait(self, timeout_secs: float | None = None, *, progress: bool | None = None) -> Self:
        """The recording once it is finished. Raises `WorkFailedError` where it failed or was cancelled."""
        attempts = 0
        with self._bar(progress, "attempts") as bar:
            for event in self.events(timeout_secs=timeout_secs):
                attempts += event.kind == "attempt"
                bar.show(attempts, event.kind)
        self.refresh()
        if self.state != "finished":
            raise WorkFailedError(f"recording {self.id}", self.data.failure, self.state)
        return self

    def files(self) -> Iterator[models.DatasetFile]:
        """The files of the dataset, in every format."""
        parse = models.RecordingFilePage.model_validate_json
        return self._connection.pages(f"{self._path}/files", parse, lambda page: page.files)

    def download(self, folder: str | Path, format: str | None = None) -> Path:
        """The dataset in a format, or in its first one, unpacked into a folder; that folder."""
        path = f"{self._path}/archives/{escaped(format or self.formats[0])}"
        return self._connection.unpacked(path, folder, _archive.unpack_tar)

    def to_lerobot(self, folder: str | Path) -> Path:
        """The dataset for LeRobot, in a folder to give as `root` to `LeRobotDataset`."""
        return self.download(folder, self._lerobot_format())

    def _lerobot_format(self) -> str:
        format = next((name for name in self.formats if name.startswith(LEROBOT)), None)
        if format is None:
            raise ValueError(f"recording {self.id} has no format for LeRobot but {', '.join(self.formats) or 'none yet'}")
        return format

    def to_rerun(self, path: str | Path, episode: int = 0) -> Path:
        """An episode as a file `.rrd` for the viewer Rerun, from a format for LeRobot; the path of the file."""
        return io.blocking_call(rrd.write_episode, self._downloaded(self._lerobot_format()), episode, path)

    def _downloaded(self, format: str) -> Path:
        """The dataset in a folder that the client removes when it is closed; downloaded once."""
        name, kept = f"{self.id}/{format}", self._connection.kept
        if name not in kept:
            kept[name] = self.download(self._connection.place(name), format)
        return kept[name]

    def push_to_hub(self, repo_id: str, format: str | None = None, *, private: bool | None = None, token: str | None = None) -> str:
        """Uploads the dataset in a format, or in its first one, to a dataset repository of the Hugging Face Hub
        (`hub.push`); the repository's address."""
        folder = self._downloaded(format or self.formats[0])
        return io.blocking_call(hub.push, folder, repo_id, private=private, token=token)

    def cancel(self) -> Self:
        """Cancels a recording that has not ended; its episodes so far are dropped."""
        return self._cancelled()

    def delete(self) -> None:
        """Deletes the recording with its dataset; deleting twice is fine."""
        self._deleted()
