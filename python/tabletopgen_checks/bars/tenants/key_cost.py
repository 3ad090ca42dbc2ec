"""What a key costs: durable submissions per second with one, against the mode `none`.

Two services of the same program take turns. No job is worked on meanwhile: on PostgreSQL there is no worker, and the
queue is paused."""

import statistics
import time

from tabletopgen_checks.bars.reliability import load
from tabletopgen_checks.bars.reliability.bench import STORES
from tabletopgen_checks.bars.reliability.part import Finding, yes
from tabletopgen_checks.bars.reliability.scenes import SMALL, quantile, request_of
from tabletopgen_checks.bars.reliability.submits import UNBOUNDED
from tabletopgen_checks.bars.tenants.bench import command
from tabletopgen_checks.problem import Problem

CLIENTS, TURNS, PROMISED_TURN_SECONDS = (1, 32), 15, 2
MIN_SHARE = 0.9


def measure(bench) -> Finding:
    rows, held = [], True
    for store in bench.stores():
        with (
            bench.service(store, f"open-{store}", settings=SMALL | UNBOUNDED, workers_wanted=0) as anyone,
            bench.keyed(store, f"keyed-{store}", SMALL | UNBOUNDED, workers_wanted=0) as keyed,
        ):
            for service in (anyone, keyed):
                command(service, "queue", "pause", "--reason", "submissions are measured")
            client = bench.client(keyed)
            for clients in CLIENTS:
                row = compared(bench.given.turn_seconds, anyone.api, client, clients)
                held &= row[-1] == yes(True)
                rows.append([store, *row])
                print(rows[-1], flush=True)
    words = (
        f"{TURNS} turns of {bench.given.turn_seconds} s each of both, one after the other, in another order every time. Rates and "
        f"the share are medians of the turns, as other programs of the machine disturb some. Every "
        f"submission is a new scene, durable when it is answered, with its row in the record of changes in both modes. Promised are "
        f"{100 * MIN_SHARE:.0f} % of the rate without a key."
    )
    columns = ["store", "clients", "without a key, per second", "with a key", "share", "p99 without, ms", "p99 with, ms", ""]
    full = bench.given.turn_seconds >= PROMISED_TURN_SECONDS and len(bench.stores()) == len(STORES)
    return Finding(columns, rows, held, words, full=full)


def compared(seconds: float, anyone, client, clients: int) -> list:
    """A row: rates, the median of their shares in each turn, and p99 of both."""
    text, base = request_of(0)[0], time.time_ns() % 10**12
    bodies = ({"text": text, "seed": base + k} for k in range(10**9))
    durations, rates = {anyone: [], client: []}, {anyone: [], client: []}
    for turn in range(TURNS):
        for server in (anyone, client) if turn % 2 else (client, anyone):
            header = server.credential()
            found, took, statuses = load.run(
                [server.port], clients, seconds, lambda _, header=header: load.post("/scenes", next(bodies), header)
            )
            if set(statuses) != {202}:
                raise Problem(f"submissions were answered with {dict(statuses)}\n{server.words()}")
            durations[server] += found
            rates[server].append(len(found) / took)
    share = statistics.median(keyed / open_ for open_, keyed in zip(rates[anyone], rates[client]))
    shown = [f"{statistics.median(rates[server]):.0f}" for server in (anyone, client)]
    p99 = [f"{1000 * quantile(durations[server], 0.99):.1f}" for server in (anyone, client)]
    return [clients, *shown, f"{100 * share:.0f} %", *p99, yes(share >= MIN_SHARE)]
