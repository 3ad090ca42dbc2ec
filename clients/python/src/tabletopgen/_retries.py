"""When a request is sent again, and after which pause.

An answer of 429 or 503 says that nothing was done: any request is repeated. After a connection that broke, only a
request that may arrive twice is. Pauses are random below a bound that doubles, and never shorter than `Retry-After`.
"""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from email.utils import parsedate_to_datetime

import httpx

REFUSED_FOR_NOW = (429, 503)
# Of proxies: the request may have arrived.
LOST = (502, 504)
NEVER_SENT = (httpx.ConnectError, httpx.ConnectTimeout, httpx.PoolTimeout)
FIRST_PAUSE_SECS = 0.2
MAX_PAUSE_SECS = 10.0


class Attempts:
    """The attempts of one request within the patience of the client."""

    def __init__(self, patience_secs: float, repeatable: bool, clock: Callable[[], float] = time.monotonic):
        self.repeatable = repeatable
        self.patience_secs = patience_secs
        self.clock = clock
        self.renew(is_progress=True)

    def renew(self, is_progress: bool) -> None:
        """The server is there: the patience begins anew, and after progress the short pauses, too."""
        self.ends = self.clock() + self.patience_secs
        if is_progress:
            self.bound_secs = FIRST_PAUSE_SECS

    def pause_secs(self, failure: httpx.Response | httpx.TransportError) -> float | None:
        """The pause before the next attempt; none where this was the last one."""
        if not self._may_repeat(failure):
            return None
        pause = random.uniform(0, self.bound_secs)
        self.bound_secs = min(2 * self.bound_secs, MAX_PAUSE_SECS)
        if isinstance(failure, httpx.Response):
            pause += retry_after_secs(failure)
        return pause if self.clock() + pause <= self.ends else None

    def _may_repeat(self, failure: httpx.Response | httpx.TransportError) -> bool:
        if isinstance(failure, httpx.Response):
            return failure.status_code in REFUSED_FOR_NOW or (self.repeatable and failure.status_code in LOST)
        return self.repeatable or isinstance(failure, NEVER_SENT)


def retry_after_secs(response: httpx.Response) -> float:
    """Seconds of `Retry-After`, which is a number or a date; 0 without one."""
    words = response.headers.get("retry-after", "0")
    try:
        return max(0.0, float(words))
    except ValueError:
        pass
    try:
        return max(0.0, parsedate_to_datetime(words).timestamp() - time.time())
    except ValueError:
        return 0.0
