# Written by generate.py from `_async`.
"""A frozen set of finished scenes."""

from __future__ import annotations

import time
from pathlib import Path

from tabletopgen import _archive, _requests, models
from tabletopgen._progress import Bar
from tabletopgen._requests import escaped, get, post
from tabletopgen._sync import io
from tabletopgen._sync.connection import Connection, check_deadline, digest_of
from tabletopgen.errors import DownloadDamagedError, WorkFailedError

POLL_SECS = 0.5
WAITING = ("queued", "running")


class Dataset:
    """A version of a dataset as the server knew it when it was asked last; `refresh` asks again."""

    def __init__(self, connection: Connection, data: models.Dataset):
        self._connection = connection
        #: Everything that the server says of it.
        self.data = data

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.id} {self.data.name} {self.data.version} {self.state}>"

    @property
    def id(self) -> str:
        """The UUID of the version."""
        return str(self.data.id)

    @property
    def state(self) -> str:
        """`queued`, `running`, `finished` or `failed`."""
        return self.data.state

    def refresh(self) -> Dataset:
        """The same dataset, as it is now."""
        self.data = self._connection.ask(get(f"/datasets/{self.id}"), models.Dataset)
        return self

    def wait(self, timeout_secs: float | None = None, *, progress: bool | None = None) -> Dataset:
        """The dataset once it is frozen and no verification waits. Raises `WorkFailedError` where it failed."""
        deadline = None if timeout_secs is None else time.monotonic() + timeout_secs
        with Bar(self._connection.progress if progress is None else progress, "dataset") as bar:
            while self._is_worked_on():
                check_deadline(deadline, f"dataset {self.id}")
                io.sleep(POLL_SECS)
                self.refresh()
                if step := self.data.progress:
                    bar.show(step.done, f"of {step.all}")
        if self.state == "failed":
            raise WorkFailedError(f"dataset {self.id}", self.data.failure, self.state)
        return self

    def _is_worked_on(self) -> bool:
        verification = self.data.verification
        return self.state in WAITING or (verification is not None and verification.state in WAITING)

    def verify(self) -> Dataset:
        """Has every byte read again and compared with the manifest; `wait` waits for it, and
        `data.verification.found` has the result."""
        self.data = self._connection.ask(post(f"/datasets/{self.id}/verify"), models.Dataset)
        return self

    def files(self) -> list[models.DatasetFile]:
        """Manifest, licenses, statistics and shards."""
        return (self._connection.ask(get(f"/datasets/{self.id}/files"), models.DatasetFiles)).files

    def file(self, path: str) -> bytes:
        """A file, byte for byte."""
        return (self._connection.send(get(f"/datasets/{self.id}/files/{escaped(path)}"))).content

    def download(self, folder: str | Path) -> Path:
        """All files, unpacked into a folder and compared with their digests; that folder."""
        path = f"/datasets/{self.id}/archive"
        folder = self._connection.unpacked(path, folder, _archive.unpack_tar, is_tag_digest=False)
        for file in self.files():
            if io.blocking_call(digest_of, folder / file.path) != file.sha256:
                raise DownloadDamagedError(f"{folder / file.path} has other bytes than dataset {self.id}; download it again")
        return folder

    def delete(self) -> None:
        """Deletes the version and frees its files; scenes and other versions stay."""
        self._connection.send(_requests.Request("DELETE", f"/datasets/{self.id}"))
