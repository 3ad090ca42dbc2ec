"""A frozen set of finished scenes."""

from __future__ import annotations

from pathlib import Path

from typing_extensions import Self

from tabletopgen import _archive, hub, models
from tabletopgen._async import io
from tabletopgen._async.connection import digest_of
from tabletopgen._async.resource import AsyncResource
from tabletopgen._requests import escaped, get, post
from tabletopgen.errors import DownloadDamagedError, WorkFailedError

WAITING = ("queued", "running")


class AsyncDataset(AsyncResource[models.Dataset]):
    """A version of a dataset, which is `queued`, `running`, `finished` or `failed`."""

    _paths, _model = "/datasets", models.Dataset

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.id} {self.data.name} {self.data.version} {self.state}>"

    async def wait(self, timeout_secs: float | None = None, *, progress: bool | None = None) -> Self:
        """The dataset once it is frozen and no verification waits. Raises `WorkFailedError` where it failed."""
        bar = self._bar(progress, "dataset")

        def show() -> None:
            if step := self.data.progress:
                bar.show(step.done, f"of {step.all}")

        await self._polled(bar, timeout_secs, lambda: not self._is_worked_on(), show)
        if self.state == "failed":
            raise WorkFailedError(f"dataset {self.id}", self.data.failure, self.state)
        return self

    def _is_worked_on(self) -> bool:
        verification = self.data.verification
        return self.state in WAITING or (verification is not None and verification.state in WAITING)

    async def verify(self) -> Self:
        """Has every byte read again and compared with the manifest; `wait` waits for it, and
        `data.verification.found` has the result."""
        return await self._changed(post(f"{self._path}/verify"))

    async def files(self) -> list[models.DatasetFile]:
        """Manifest, licenses, statistics and shards."""
        return (await self._connection.ask(get(f"{self._path}/files"), models.DatasetFiles)).files

    async def file(self, path: str) -> bytes:
        """A file, byte for byte."""
        return (await self._connection.send(get(f"{self._path}/files/{escaped(path)}"))).content

    async def download(self, folder: str | Path) -> Path:
        """All files, unpacked into a folder and compared with their digests; that folder."""
        folder = await self._connection.unpacked(f"{self._path}/archive", folder, _archive.unpack_tar, is_tag_digest=False)
        for file in await self.files():
            if await io.blocking_call(digest_of, folder / file.path) != file.sha256:
                raise DownloadDamagedError(f"{folder / file.path} has other bytes than dataset {self.id}; download it again")
        return folder

    async def push_to_hub(self, repo_id: str, *, private: bool | None = None, token: str | None = None) -> str:
        """Uploads all files to a dataset repository of the Hugging Face Hub (`hub.push`); the repository's address."""
        kept = self._connection.kept
        if self.id not in kept:
            kept[self.id] = await self.download(self._connection.place(self.id))
        message = f"{self.data.name}, version {self.data.version}"
        return await io.blocking_call(hub.push, kept[self.id], repo_id, private=private, token=token, message=message)

    async def delete(self) -> None:
        """Deletes the version and frees its files; scenes and other versions stay."""
        await self._deleted()
