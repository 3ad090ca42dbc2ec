"""A task that a simulated robot does in a scene."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

from typing_extensions import Self

from tabletopgen import _archive, models
from tabletopgen._async.resource import AsyncResource
from tabletopgen._requests import get
from tabletopgen.errors import WorkFailedError


class AsyncExecution(AsyncResource[models.Job]):
    """An execution, which is a job of its own and has its UUID."""

    _paths, _model = "/jobs", models.Job

    def events(self, after: int = 0, timeout_secs: float | None = None) -> AsyncIterator[models.Event]:
        """Events as they happen, until the execution has ended."""
        return self._connection.job_events(self.id, after, timeout_secs)

    async def wait(self, timeout_secs: float | None = None, *, progress: bool | None = None) -> Self:
        """The execution once it has ended. A task that was attempted in vain has a result like one that was done.

        Raises `WorkFailedError` where the execution was cancelled or could not go on, and `ApiError` with the reason
        for a task that cannot be attempted.
        """
        with self._bar(progress, "execution") as bar:
            async for event in self.events(timeout_secs=timeout_secs):
                bar.show_event(event)
        await self.refresh()
        if self.state == "failed":
            # The answer is the problem of the task, which says more.
            await self._connection.send(get(f"/executions/{self.id}"))
        if self.state != "succeeded":
            raise WorkFailedError(f"execution {self.id}", self.data.failure, self.state)
        return self

    async def result(self) -> models.ExecutedTask:
        """Verdict, task and motion; not of an execution with `files`, whose archive has them."""
        return await self._connection.ask(get(f"/executions/{self.id}"), models.ExecutedTask)

    async def download(self, folder: str | Path) -> Path:
        """The files of an execution that was asked for with `files`, in a folder."""
        return await self._connection.unpacked(f"/executions/{self.id}", folder, _archive.unpack_zip)

    async def cancel(self) -> Self:
        """Asks the execution to stop."""
        return await self._cancelled()
