"""A vendor whose answers are held back until they are wanted: `tabletopgen-lab mock-vendors` behind a proxy."""

import contextlib

from tabletopgen_checks.bars.reliability.proxy import Proxy
from tabletopgen_checks.service.mock_vendors import MockVendors

# However long an answer takes, it is waited for.
PATIENT = {
    "providers.chat.attempt_timeout_secs": "3600",
    "providers.chat.total_timeout_secs": "7200",
    "providers.chat.concurrency": "64",
    "providers.chat.calls_per_minute": "1000000",
    "worker.stage_timeout_secs": "10000",
    "store.retention.grace_secs": "20000",
}


@contextlib.contextmanager
def held_vendors(bench):
    """Settings of a service that asks it, and the proxy, which holds the analyst's answers back until `release`. The
    analyst is asked first, so that jobs wait in their first stage."""
    with MockVendors(bench.binary, 0) as providers, Proxy(providers.port) as proxy:
        proxy.hold()
        yield providers.vendors() | PATIENT | {"providers.chat.base_url": f"http://127.0.0.1:{proxy.port}/v1"}, proxy
