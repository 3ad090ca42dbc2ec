"""Durable submissions per second over HTTP, and what the bare store takes of the same transaction in the same run.

The service and the bare store take turns, three times each, at 1 client and at 32. Nothing works on the jobs
meanwhile: on PostgreSQL no worker runs, on SQLite the worker's only slot waits for a vendor that does not answer."""

import time

from tabletopgen_checks.bars.reliability import bare, load
from tabletopgen_checks.bars.reliability.held import held_vendors
from tabletopgen_checks.bars.reliability.part import Finding
from tabletopgen_checks.bars.reliability.scenes import SMALL, quantile, request_of
from tabletopgen_checks.problem import Problem

CLIENTS, TURNS = (1, 32), 3
PROMISED_SECONDS, MIN_SHARE = 10, 0.9
# Nothing of it is to be refused for being too much.
UNBOUNDED = {
    "worker.concurrency": "1",
    "server.max_connections": "4096",
    "queue.max_jobs": "1000000",
    "store.limits.waiting_jobs": "1000000",
}


def measure(bench) -> Finding:
    rows, held = [], True
    statements = statements_of(bench)
    stores = bench.stores()
    for store in stores:
        with held_vendors(bench) as (vendors, _):
            settings = SMALL | (vendors if store == "sqlite" else {}) | UNBOUNDED
            with (
                bench.service(store, f"submits-{store}", settings=settings, workers_wanted=0) as service,
                bench.service(store, f"bare-{store}", settings=settings, workers_wanted=0) as schema,
            ):
                if store == "sqlite":
                    text, seed = request_of(0)
                    service.api.submit_text(text, seed)
                    time.sleep(1)
                for server in schema.servers:
                    server.stop()
                for clients in CLIENTS:
                    row = compared(bench, store, service, schema, statements, clients)
                    print(row, flush=True)
                    rows.append(row)
                    held &= row[-2:] == ["yes", "yes"]
    columns = [
        "store",
        "clients",
        "submissions per second",
        "bare transactions per second",
        "share",
        "p99, ms",
        "bare p99, ms",
        "rate within 10 %",
        "p99 within 10 %",
    ]
    words = (
        f"{TURNS} turns of {bench.given.submit_seconds} s each. The bare store executes the "
        f"{len(statements)} statements of one submission as PostgreSQL's log has them: `pgbench --protocol "
        "prepared`, and Python's `sqlite3` with "
        "WAL and `synchronous = FULL`, one transaction a submission, clients taking turns. A share above 100 % comes "
        "from several submissions in one transaction."
    )
    full = bench.given.submit_seconds >= PROMISED_SECONDS and len(stores) == 2
    return Finding(columns, rows, held, words, full=full)


def statements_of(bench) -> list:
    """Of one submission without idempotency key."""
    with bench.service("postgres", "recorded", settings=SMALL, workers_wanted=0) as service:

        def submit():
            text, seed = request_of(0)
            service.api.submit_text(text, seed)

        submit()
        return bare.recorded(bench.postgres, submit)


def compared(bench, store, service, schema, statements, clients) -> list:
    text, _ = request_of(0)
    base = time.time_ns() % 10**12
    requests = (load.post("/scenes", {"text": text, "seed": base + k}) for k in range(10**9))
    served, served_took, raw, raw_took = [], 0.0, [], 0.0
    for _ in range(TURNS):
        ports = [api.port for api in service.apis]
        durations, took, statuses = load.run(ports, clients, bench.given.submit_seconds, lambda _: next(requests))
        if set(statuses) != {202}:
            raise Problem(f"submissions were answered with {dict(statuses)}\n{service.api.words()}")
        served, served_took = served + durations, served_took + took
        if store == "sqlite":
            path = schema.data_folder / "tabletopgen.sqlite"
            durations, took = bare.on_sqlite(path, statements, clients, bench.given.submit_seconds)
        else:
            durations, took = bare.on_postgres(
                bench.postgres, schema.database, statements, clients, bench.given.submit_seconds, schema.folder
            )
        raw, raw_took = raw + durations, raw_took + took
    rate, bare_rate = len(served) / served_took, len(raw) / raw_took
    p99, bare_p99 = 1000 * quantile(served, 0.99), 1000 * quantile(raw, 0.99)
    return [
        store,
        clients,
        f"{rate:.0f}",
        f"{bare_rate:.0f}",
        f"{100 * rate / bare_rate:.0f} %",
        f"{p99:.1f}",
        f"{bare_p99:.1f}",
        "yes" if rate >= MIN_SHARE * bare_rate else "no",
        "yes" if MIN_SHARE * p99 <= bare_p99 else "no",
    ]
