"""Many requests for scenes that were submitted together."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator

from tabletopgen import _requests, models
from tabletopgen._async import io
from tabletopgen._async.connection import AsyncConnection, check_deadline
from tabletopgen._async.scene import AsyncScene
from tabletopgen._progress import Bar
from tabletopgen._requests import get, given, post

POLL_SECS = 0.5
BATCH_ENDED = ("finished", "cancelled")


class AsyncBatch:
    """A batch as the server knew it when it was asked last; `refresh` asks again."""

    def __init__(self, connection: AsyncConnection, data: models.Batch):
        self._connection = connection
        #: Everything that the server says of it.
        self.data = data

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.id} {self.state}>"

    @property
    def id(self) -> str:
        """The UUID of the batch."""
        return str(self.data.id)

    @property
    def state(self) -> str:
        """`running`, `cancelling`, `finished` or `cancelled`."""
        return self.data.state

    async def refresh(self) -> AsyncBatch:
        """The same batch, as it is now."""
        self.data = await self._connection.ask(get(f"/batches/{self.id}"), models.Batch)
        return self

    async def wait(self, timeout_secs: float | None = None, *, progress: bool | None = None) -> AsyncBatch:
        """The batch once all of its requests have ended, whichever way: `data.request_counts` counts them."""
        deadline = None if timeout_secs is None else time.monotonic() + timeout_secs
        with Bar(self._connection.progress if progress is None else progress, "batch", 100) as bar:
            while self.state not in BATCH_ENDED:
                check_deadline(deadline, f"batch {self.id}")
                await io.sleep(POLL_SECS)
                await self.refresh()
                left = self.data.estimate
                bar.show(int(100 * self.data.progress), f"% {left.time_left_s:.0f} s left" if left else "%")
        return self

    async def results(self) -> list[models.BatchResult]:
        """Results of the requests with a scene, so far."""
        return await self._lines("output")

    async def errors(self) -> list[models.BatchResult]:
        """Results of the requests without one, so far, with the reason."""
        return await self._lines("errors")

    async def _lines(self, name: str) -> list[models.BatchResult]:
        answer = await self._connection.send(get(f"/batches/{self.id}/{name}"))
        return [models.BatchResult.model_validate_json(line) for line in answer.content.split(b"\n") if line]

    async def scenes(self) -> AsyncIterator[AsyncScene]:
        """The scenes of the batch, newest first, by the label that they have."""
        pages = self._connection.pages(
            "/scenes", models.ScenePage.model_validate_json, lambda page: page.scenes, {"label": f"batch:{self.id}"}
        )
        async for scene in pages:
            yield AsyncScene(self._connection, scene)

    async def cancel(self) -> AsyncBatch:
        """Cancels what has not ended; results so far stay."""
        self.data = await self._connection.ask(post(f"/batches/{self.id}/cancel", repeatable=True), models.Batch)
        return self

    async def retry(self, budget_usd: float | None = None) -> AsyncBatch:
        """Has the scenes made of requests that failed or were cancelled."""
        body = given(budget_usd=budget_usd)
        self.data = await self._connection.ask(post(f"/batches/{self.id}/retry", body), models.Batch)
        return self

    async def delete(self, *, scenes: bool = False) -> None:
        """Deletes the batch with its results; its scenes stay unless `scenes` is true."""
        query = {"scenes": "delete" if scenes else "keep"}
        await self._connection.send(_requests.Request("DELETE", f"/batches/{self.id}", query))
