# Written by generate.py from `_async`.
"""Many requests for scenes that were submitted together."""

from __future__ import annotations

import time
from collections.abc import Iterator

from tabletopgen import _requests, models
from tabletopgen._progress import Bar
from tabletopgen._requests import get, given, post
from tabletopgen._sync import io
from tabletopgen._sync.connection import Connection, check_deadline
from tabletopgen._sync.scene import Scene

POLL_SECS = 0.5
BATCH_ENDED = ("finished", "cancelled")


class Batch:
    """A batch as the server knew it when it was asked last; `refresh` asks again."""

    def __init__(self, connection: Connection, data: models.Batch):
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

    def refresh(self) -> Batch:
        """The same batch, as it is now."""
        self.data = self._connection.ask(get(f"/batches/{self.id}"), models.Batch)
        return self

    def wait(self, timeout_secs: float | None = None, *, progress: bool | None = None) -> Batch:
        """The batch once all of its requests have ended, whichever way: `data.request_counts` counts them."""
        deadline = None if timeout_secs is None else time.monotonic() + timeout_secs
        with Bar(self._connection.progress if progress is None else progress, "batch", 100) as bar:
            while self.state not in BATCH_ENDED:
                check_deadline(deadline, f"batch {self.id}")
                io.sleep(POLL_SECS)
                self.refresh()
                left = self.data.estimate
                bar.show(int(100 * self.data.progress), f"% {left.time_left_s:.0f} s left" if left else "%")
        return self

    def results(self) -> list[models.BatchResult]:
        """Results of the requests with a scene, so far."""
        return self._lines("output")

    def errors(self) -> list[models.BatchResult]:
        """Results of the requests without one, so far, with the reason."""
        return self._lines("errors")

    def _lines(self, name: str) -> list[models.BatchResult]:
        answer = self._connection.send(get(f"/batches/{self.id}/{name}"))
        return [models.BatchResult.model_validate_json(line) for line in answer.content.split(b"\n") if line]

    def scenes(self) -> Iterator[Scene]:
        """The scenes of the batch, newest first, by the label that they have."""
        pages = self._connection.pages(
            "/scenes", models.ScenePage.model_validate_json, lambda page: page.scenes, {"label": f"batch:{self.id}"}
        )
        for scene in pages:
            yield Scene(self._connection, scene)

    def cancel(self) -> Batch:
        """Cancels what has not ended; results so far stay."""
        self.data = self._connection.ask(post(f"/batches/{self.id}/cancel", repeatable=True), models.Batch)
        return self

    def retry(self, budget_usd: float | None = None) -> Batch:
        """Has the scenes made of requests that failed or were cancelled."""
        body = given(budget_usd=budget_usd)
        self.data = self._connection.ask(post(f"/batches/{self.id}/retry", body), models.Batch)
        return self

    def delete(self, *, scenes: bool = False) -> None:
        """Deletes the batch with its results; its scenes stay unless `scenes` is true."""
        query = {"scenes": "delete" if scenes else "keep"}
        self._connection.send(_requests.Request("DELETE", f"/batches/{self.id}", query))
