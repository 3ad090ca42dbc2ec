# Written by generate.py from `_async`.
"""A task that a simulated robot does in a scene."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tabletopgen import _archive, models
from tabletopgen._progress import Bar
from tabletopgen._requests import get, post
from tabletopgen._sync.connection import Connection
from tabletopgen.errors import WorkFailedError


class Execution:
    """An execution, which is a job of its own."""

    def __init__(self, connection: Connection, job: models.Job):
        self._connection = connection
        #: The job, as the server knew it when it was asked last.
        self.job = job

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.id} {self.job.state}>"

    @property
    def id(self) -> str:
        """The UUID of the execution, which is that of its job."""
        return str(self.job.id)

    def refresh(self) -> Execution:
        """The same execution, as it is now."""
        self.job = self._connection.ask(get(f"/jobs/{self.id}"), models.Job)
        return self

    def events(self, after: int = 0, timeout_secs: float | None = None) -> Iterator[models.Event]:
        """Events as they happen, until the execution has ended."""
        return self._connection.job_events(self.id, after, timeout_secs)

    def wait(self, timeout_secs: float | None = None, *, progress: bool | None = None) -> Execution:
        """The execution once it has ended. A task that was attempted in vain has a result like one that was done.

        Raises `WorkFailedError` where the execution was cancelled or could not go on, and `ApiError` with the reason
        for a task that cannot be attempted.
        """
        with Bar(self._connection.progress if progress is None else progress, "execution") as bar:
            for event in self.events(timeout_secs=timeout_secs):
                bar.show_event(event)
        self.refresh()
        if self.job.state == "failed":
            # The answer is the problem of the task, which says more.
            self._connection.send(get(f"/executions/{self.id}"))
        if self.job.state != "succeeded":
            raise WorkFailedError(f"execution {self.id}", self.job.failure, self.job.state)
        return self

    def result(self) -> models.ExecutedTask:
        """Verdict, task and motion; not of an execution with `files`, whose archive has them."""
        return self._connection.ask(get(f"/executions/{self.id}"), models.ExecutedTask)

    def download(self, folder: str | Path) -> Path:
        """The files of an execution that was asked for with `files`, in a folder."""
        return self._connection.unpacked(f"/executions/{self.id}", folder, _archive.unpack_zip)

    def cancel(self) -> Execution:
        """Asks the execution to stop."""
        self.job = self._connection.ask(post(f"/jobs/{self.id}/cancel", repeatable=True), models.Job)
        return self
