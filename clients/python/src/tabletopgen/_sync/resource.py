# Written by generate.py from `_async`.
"""What scenes, batches, datasets, recordings, executions and webhooks have in common."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, ClassVar, Generic, TypeVar

from typing_extensions import Self

from tabletopgen import models
from tabletopgen._progress import Bar
from tabletopgen._requests import Query, Request, delete, get, post
from tabletopgen._sync import io
from tabletopgen._sync.connection import Connection, check_deadline

D = TypeVar("D", models.Batch, models.Dataset, models.Job, models.Recording, models.Scene, models.Webhook)
POLL_SECS = 0.5


class Resource(Generic[D]):
    """Something of the server as it was when the server was asked last; `refresh` asks again."""

    # The path of all of its kind.
    _paths: ClassVar[str]
    _model: type[D]

    def __init__(self, connection: Connection, data: D):
        self._connection = connection
        #: Everything that the server says of it.
        self.data: D = data

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.id} {self.state}>"

    @property
    def id(self) -> str:
        """Its UUID."""
        return str(self.data.id)

    @property
    def state(self) -> str:
        """Its state; which ones there are, the field `state` of `data` says."""
        return self.data.state

    @property
    def _path(self) -> str:
        return f"{self._paths}/{self.id}"

    @classmethod
    def _of(cls, connection: Connection, identifier: str) -> Self:
        """The one with this UUID."""
        return cls._asked(connection, get(f"{cls._paths}/{identifier}"))

    @classmethod
    def _asked(cls, connection: Connection, request: Request) -> Self:
        """The one that answers a request."""
        return cls(connection, connection.ask(request, cls._model))

    def refresh(self) -> Self:
        """The same one, as it is now."""
        return self._changed(get(self._path))

    def _changed(self, request: Request) -> Self:
        self.data = self._connection.ask(request, self._model)
        return self

    def _cancelled(self) -> Self:
        return self._changed(post(f"{self._path}/cancel", repeatable=True))

    def _deleted(self, query: Query | None = None) -> None:
        self._connection.send(delete(self._path, query))

    def _bar(self, progress: bool | None, title: str, total: int | None = None) -> Bar:
        """Progress of waiting, shown as the caller or the client says."""
        return Bar(self._connection.progress if progress is None else progress, title, total)

    def _polled(self, bar: Bar, timeout_secs: float | None, is_ended: Callable[[], bool], show: Callable[[], Any]) -> None:
        """Asks again until it has ended. Raises `WaitTimeoutError`."""
        deadline = None if timeout_secs is None else time.monotonic() + timeout_secs
        with bar:
            while not is_ended():
                check_deadline(deadline, self._path)
                io.sleep(POLL_SECS)
                self.refresh()
                show()
