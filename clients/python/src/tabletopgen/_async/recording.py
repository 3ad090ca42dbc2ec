"""Demonstrations of a robot in a scene, recorded as a dataset."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

from typing_extensions import Self

from tabletopgen import _archive, hub, models, rrd
from tabletopgen._async import io
from tabletopgen._async.resource import AsyncResource
from tabletopgen._requests import escaped
from tabletopgen.errors import WorkFailedError

RECORDING_ENDED = ("finished", "failed", "cancelled")
LEROBOT = "lerobot-"


class AsyncRecording(AsyncResource[models.Recording]):
    """A recording; of its states `finished`, `failed` and `cancelled` are final."""

    _paths, _model = "/episodes", models.Recording

    @property
    def formats(self) -> list[str]:
        """Formats of the finished dataset."""
        return [one.format for one in self.data.dataset.formats] if self.data.dataset else []

    def events(self, after: int = 0, timeout_secs: float | None = None) -> AsyncIterator[models.RecordingEvent]:
        """Events as they happen, until the recording has ended; `after` is the `seq` of the last one seen."""
        return self._connection.events(
            f"{self._path}/events",
            models.RecordingEvent,
            lambda event: event.kind in RECORDING_ENDED,
            after,
            timeout_secs,
        )

    async def wait(self, timeout_secs: float | None = None, *, progress: bool | None = None) -> Self:
        """The recording once it is finished. Raises `WorkFailedError` where it failed or was cancelled."""
        attempts = 0
        with self._bar(progress, "attempts") as bar:
            async for event in self.events(timeout_secs=timeout_secs):
                attempts += event.kind == "attempt"
                bar.show(attempts, event.kind)
        await self.refresh()
        if self.state != "finished":
            raise WorkFailedError(f"recording {self.id}", self.data.failure, self.state)
        return self

    def files(self) -> AsyncIterator[models.DatasetFile]:
        """The files of the dataset, in every format."""
        parse = models.RecordingFilePage.model_validate_json
        return self._connection.pages(f"{self._path}/files", parse, lambda page: page.files)

    async def download(self, folder: str | Path, format: str | None = None) -> Path:
        """The dataset in a format, or in its first one, unpacked into a folder; that folder."""
        path = f"{self._path}/archives/{escaped(format or self.formats[0])}"
        return await self._connection.unpacked(path, folder, _archive.unpack_tar)

    async def to_lerobot(self, folder: str | Path) -> Path:
        """The dataset for LeRobot, in a folder to give as `root` to `LeRobotDataset`."""
        return await self.download(folder, self._lerobot_format())

    def _lerobot_format(self) -> str:
        format = next((name for name in self.formats if name.startswith(LEROBOT)), None)
        if format is None:
            raise ValueError(f"recording {self.id} has no format for LeRobot but {', '.join(self.formats) or 'none yet'}")
        return format

    async def to_rerun(self, path: str | Path, episode: int = 0) -> Path:
        """An episode as a file `.rrd` for the viewer Rerun, from a format for LeRobot; the path of the file."""
        return await io.blocking_call(rrd.write_episode, await self._downloaded(self._lerobot_format()), episode, path)

    async def _downloaded(self, format: str) -> Path:
        """The dataset in a folder that the client removes when it is closed; downloaded once."""
        name, kept = f"{self.id}/{format}", self._connection.kept
        if name not in kept:
            kept[name] = await self.download(self._connection.place(name), format)
        return kept[name]

    async def push_to_hub(self, repo_id: str, format: str | None = None, *, private: bool | None = None, token: str | None = None) -> str:
        """Uploads the dataset in a format, or in its first one, to a dataset repository of the Hugging Face Hub
        (`hub.push`); the repository's address."""
        folder = await self._downloaded(format or self.formats[0])
        return await io.blocking_call(hub.push, folder, repo_id, private=private, token=token)

    async def cancel(self) -> Self:
        """Cancels a recording that has not ended; its episodes so far are dropped."""
        return await self._cancelled()

    async def delete(self) -> None:
        """Deletes the recording with its dataset; deleting twice is fine."""
        await self._deleted()
