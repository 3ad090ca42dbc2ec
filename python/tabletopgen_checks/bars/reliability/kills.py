"""`kill -9` at every stage boundary, and 0.4 s apart under load: nothing is lost, repeated or committed twice.

A boundary is the moment at which a stage's event arrives: it has started, or it has finished. One scene meets many of
them: the process dies at the first sight of most of them, and another takes its place at once. On SQLite the process
that dies is the whole server; on PostgreSQL it is the worker, and requests are answered meanwhile by another process.
"""

import itertools
import random
import time
from collections import Counter
from dataclasses import dataclass, field

from tabletopgen_checks.bars.reliability import audit
from tabletopgen_checks.bars.reliability.part import Finding
from tabletopgen_checks.bars.reliability.scenes import (
    JOB_SECONDS,
    SHORT_LEASE,
    SHORT_LEASE_SECONDS,
    SMALL,
    at_seconds,
    outcome,
    quantile,
    side_by_side,
    submit,
    tally,
    undisturbed,
    wait_for_all,
)

SETTINGS = SMALL | SHORT_LEASE
KINDS = ("stage_started", "stage_finished")
# On SQLite two scenes keep two cores busy; on PostgreSQL most of the time passes waiting for leases.
LANES = {"sqlite": 2, "postgres": 4}
APART_SECONDS = 0.4
# Of all kills so many are those under load.
SHARE_UNDER_LOAD = 0.3
# So many jobs are open under load, of as many different scenes; fewer where fewer kills are asked for.
JOBS_UNDER_LOAD, KILLS_OF_A_JOB = 16, 4
SHARE_OF_BOUNDARIES = 0.6
PROMISED = 500
MAX_LATER_SECONDS = 5


@dataclass
class Tally:
    """What came of the kills of one store."""

    boundaries: Counter = field(default_factory=Counter)
    under_load: int = 0
    scenes: int = 0
    wrong: list = field(default_factory=list)
    reclaim_seconds: list = field(default_factory=list)

    @property
    def kills(self) -> int:
        return sum(self.boundaries.values()) + self.under_load


def measure(bench) -> Finding:
    stores = bench.stores()
    rows, wrong, kills, reclaims, stages = [], [], 0, {}, set()
    for store in stores:
        wanted = share(bench.given.kills, len(stores), stores.index(store))
        found = kills_of(bench, store, wanted)
        counts = tally(found.wrong)
        rows.append(
            [
                store,
                sum(found.boundaries.values()),
                len(found.boundaries),
                found.under_load,
                found.scenes,
                counts["lost"],
                counts["repeated"],
                counts["twice"],
                counts["bytes"],
            ]
        )
        print(f"{store}: {rows[-1]} {found.wrong[:10]}", flush=True)
        wrong, kills, reclaims[store] = wrong + found.wrong, kills + found.kills, found.reclaim_seconds
        stages |= {stage for _, stage in found.boundaries}
    columns = [
        "store",
        "kills at boundaries",
        "different boundaries",
        "kills 0.4 s apart",
        "scenes",
        "lost or failed",
        "stages repeated",
        "committed twice",
        "other bytes",
    ]
    words = f"Boundaries are start and end of: {', '.join(sorted(stages))}."
    late = False
    if seconds := reclaims.get("postgres"):
        p99 = quantile(seconds, 0.99)
        late = p99 > SHORT_LEASE_SECONDS + MAX_LATER_SECONDS
        words += (
            f" From the kill of a worker to the next claim of its job, with a lease of {SHORT_LEASE_SECONDS} s: median "
            f"{quantile(seconds, 0.5):.1f} s, p99 {p99:.1f} s of {len(seconds)}."
        )
    if wrong:
        words += "\n\n" + "\n".join(f"- {line}" for line in wrong[:20])
    return Finding(columns, rows, not wrong and not late, words, full=kills >= PROMISED and len(stores) == 2)


def share(whole: int, parts: int, index: int) -> int:
    return whole // parts + (index < whole % parts)


def kills_of(bench, store: str, wanted: int) -> Tally:
    under_load = int(SHARE_UNDER_LOAD * wanted)
    found = Tally()
    numbers = range(max(2, min(JOBS_UNDER_LOAD, wanted // KILLS_OF_A_JOB)))
    with bench.service(store, f"kills-{store}-calm", settings=SMALL) as service:
        digests = undisturbed(service, numbers)
    left = Left(wanted - under_load)
    fresh = itertools.count()

    def lane(_):
        while left.any():
            number = next(fresh)
            one_scene(bench, store, number, digests, left, found)

    side_by_side(lane, range(LANES[store]), LANES[store])
    if under_load:
        load(bench, store, under_load, digests, found)
    return found


class Left:
    """How many kills are still to be made; taken one by one."""

    def __init__(self, count):
        self.count = count

    def any(self) -> bool:
        return self.count > 0

    def take(self) -> bool:
        self.count -= 1
        return self.count >= 0


def one_scene(bench, store, draw_number, digests, left, found):
    """Makes a scene; the process that works on it dies at each boundary it meets for the first time."""
    with bench.service(store, f"kills-{store}", settings=SETTINGS) as service:
        audit.install(service)
        number = draw_number % len(digests)
        scene_id, job_id = submit(service.api, number)
        # Whether a boundary is one to die at is drawn, so that few kills also reach late stages.
        draw, met, seen, killed_at = random.Random(draw_number), set(), 0, None
        deadline = time.monotonic() + JOB_SECONDS
        while True:
            boundary = None
            for event in service.api.events(job_id, after=seen, deadline=deadline):
                seen = event["seq"]
                if event["kind"] == "job_started" and killed_at is not None:
                    found.reclaim_seconds.append(at_seconds(event) - killed_at)
                    killed_at = None
                if event["kind"] in KINDS and not event["data"].get("cached"):
                    boundary = event["kind"], event["data"]["stage"]
                    if boundary not in met:
                        met.add(boundary)
                        if draw.random() < SHARE_OF_BOUNDARIES and left.take():
                            break
                boundary = None
            if boundary is None:
                break
            service.workers[0].kill()
            killed_at = time.time()
            found.boundaries[boundary] += 1
            service.replace(service.workers[0]).wait_until_ready()
        found.scenes += 1
        wrong = outcome(service.api, scene_id, job_id, digests[number]) + audit.double_commits(service)
        if wrong:
            wrong[0] += f" (scene {number}, {service.name})"
        found.wrong += wrong


def load(bench, store, kills, digests, found):
    """Many jobs at once while some process dies every 0.4 s; on PostgreSQL the workers in turn, and the API now and
    then.
    """
    with bench.service(store, f"load-{store}", settings=SETTINGS, workers_wanted=2) as service:
        audit.install(service)
        ids = {number: submit(service.api, number) for number in digests}
        for k in range(kills):
            began = time.monotonic()
            victims = service.workers if store == "sqlite" or k % 5 else service.apis
            victim = victims[k % len(victims)]
            victim.kill()
            service.replace(victim)
            found.under_load += 1
            time.sleep(max(0.0, APART_SECONDS - (time.monotonic() - began)))
        for server in service.servers:
            server.wait_until_ready()
        states = wait_for_all(service.api, [job_id for _, job_id in ids.values()])
        found.scenes += len(ids)
        for (number, (scene_id, job_id)), state in zip(ids.items(), states):
            if state not in ("succeeded", "failed", "cancelled"):
                found.wrong.append(f"lost: scene {number} is still {state}")
            else:
                found.wrong += [
                    f"{line} (scene {number} under load)"
                    for line in outcome(service.api, scene_id, job_id, digests[number])
                ]
        found.wrong += audit.double_commits(service)
