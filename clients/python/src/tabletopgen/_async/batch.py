"""Many requests for scenes that were submitted together."""

from __future__ import annotations

from collections.abc import AsyncIterator

from typing_extensions import Self

from tabletopgen import models
from tabletopgen._async.resource import AsyncResource
from tabletopgen._async.scene import AsyncScene
from tabletopgen._requests import get, given, post

BATCH_ENDED = ("finished", "cancelled")


class AsyncBatch(AsyncResource[models.Batch]):
    """A batch, which is `running`, `cancelling`, `finished` or `cancelled`."""

    _paths, _model = "/batches", models.Batch

    async def wait(self, timeout_secs: float | None = None, *, progress: bool | None = None) -> Self:
        """The batch once all of its requests have ended, whichever way: `data.request_counts` counts them."""
        bar = self._bar(progress, "batch", 100)

        def show() -> None:
            left = self.data.estimate
            bar.show(int(100 * self.data.progress), f"% {left.time_left_s:.0f} s left" if left else "%")

        await self._polled(bar, timeout_secs, lambda: self.state in BATCH_ENDED, show)
        return self

    async def results(self) -> list[models.BatchResult]:
        """Results of the requests with a scene, so far."""
        return await self._lines("output")

    async def errors(self) -> list[models.BatchResult]:
        """Results of the requests without one, so far, with the reason."""
        return await self._lines("errors")

    async def _lines(self, name: str) -> list[models.BatchResult]:
        answer = await self._connection.send(get(f"{self._path}/{name}"))
        return [models.BatchResult.model_validate_json(line) for line in answer.content.split(b"\n") if line]

    async def scenes(self) -> AsyncIterator[AsyncScene]:
        """The scenes of the batch, newest first, by the label that they have."""
        pages = self._connection.pages(
            "/scenes", models.ScenePage.model_validate_json, lambda page: page.scenes, {"label": f"batch:{self.id}"}
        )
        async for scene in pages:
            yield AsyncScene(self._connection, scene)

    async def cancel(self) -> Self:
        """Cancels what has not ended; results so far stay."""
        return await self._cancelled()

    async def retry(self, budget_usd: float | None = None) -> Self:
        """Has the scenes made of requests that failed or were cancelled."""
        return await self._changed(post(f"{self._path}/retry", given(budget_usd=budget_usd)))

    async def delete(self, *, scenes: bool = False) -> None:
        """Deletes the batch with its results; its scenes stay unless `scenes` is true."""
        await self._deleted({"scenes": "delete" if scenes else "keep"})
