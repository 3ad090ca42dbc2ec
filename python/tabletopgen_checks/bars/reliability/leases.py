"""Leases: a worker that slept past its lease changes nothing, a dead one is found soon, a slow one is left alone."""

import random
import time

from tabletopgen_checks.bars.reliability import audit
from tabletopgen_checks.bars.reliability.held import held_vendors
from tabletopgen_checks.bars.reliability.part import Finding
from tabletopgen_checks.bars.reliability.scenes import (
    JOB_SECONDS,
    SHORT_LEASE,
    SHORT_LEASE_SECONDS,
    SMALL,
    at_seconds,
    leases_of,
    outcome,
    quantile,
    submit,
    tally,
    undisturbed,
)
from tabletopgen_checks.problem import Problem

PROMISED_PAUSES, PROMISED_RECLAIMS, PROMISED_STAGE_SECONDS = 20, 100, 600
LATE_WORDS = ("the lease was lost", "no longer leased")
JOBS_OF_A_WORKER = 8
DEFAULT_LEASE_SECONDS = 30
MAX_LATER_SECONDS = 5
SCENES = 6


def measure_pauses(bench) -> Finding:
    """SIGSTOP past the lease, then SIGCONT, while another worker has taken the job over or has finished it."""
    rows, wrong = [], []
    stores = bench.stores()
    for store in stores:
        counts = pauses_of(bench, store, bench.given.pauses, wrong)
        rows.append([store, *counts])
        print(f"{store}: {rows[-1]} {wrong[:10]}", flush=True)
    columns = [
        "store",
        "pauses",
        "taken over meanwhile",
        "writes refused",
        "late writes in the database",
        "lost or failed",
        "stages repeated",
        "committed twice",
        "other bytes",
    ]
    words = (
        "On PostgreSQL every process has a database user of its own and triggers note who writes which row; writes "
        "refused are counted by the lines of the log about a lost lease. On SQLite the only process "
        "may claim its own job again."
    )
    if wrong:
        words += "\n\n" + "\n".join(f"- {line}" for line in wrong[:20])
    return Finding(columns, rows, not wrong, words, full=bench.given.pauses >= PROMISED_PAUSES and len(stores) == 2)


def pauses_of(bench, store, pauses, wrong) -> list:
    with bench.service(store, f"calm-{store}", settings=SMALL) as service:
        digests = undisturbed(service, range(SCENES))
    draw, taken_over, refused, late, found = random.Random(1), 0, 0, 0, []
    for k in range(pauses):
        number = k % SCENES
        with bench.service(store, f"pause-{store}", settings=SMALL | SHORT_LEASE, workers_wanted=1) as service:
            audit.install(service)
            scene_id, job_id = submit(service.api, number)
            victim = service.workers[0]
            # A stage has started, and a moment passes, so that the pause falls somewhere into the work.
            wanted = draw.randint(1, 12)
            for event in service.api.events(job_id, deadline=time.monotonic() + JOB_SECONDS):
                wanted -= event["kind"] == "stage_started"
                if wanted <= 0:
                    break
            victim.pause()
            if store == "sqlite":
                time.sleep(SHORT_LEASE_SECONDS + 2)
            else:
                other = service.another_worker()
                service.workers.append(other)
                other.start()
                to_wait_for = ("job_succeeded",) if k % 2 else ("job_started",)
                await_event(service.api, job_id, to_wait_for, after=event["seq"])
            victim.resume()
            service.api.wait(job_id, JOB_SECONDS)
            # The one that slept has its say now, if it has any.
            time.sleep(2)
            events = service.api.events_after(job_id)
            taken_over += sum(event["kind"] == "job_started" for event in events) > 1
            text = victim.log.read_text(encoding="utf-8", errors="replace")
            refused += sum(any(words in line for words in LATE_WORDS) for line in text.splitlines())
            if store == "postgres":
                writes = audit.late_writes(service)
                late += len(writes)
                found += writes
            found += outcome(service.api, scene_id, job_id, digests[number]) + audit.double_commits(service)
    wrong += found
    counts = tally(found)
    return [pauses, taken_over, refused, late, counts["lost"], counts["repeated"], counts["twice"], counts["bytes"]]


def await_event(api, job_id, kinds, after=0):
    for event in api.events(job_id, after=after, deadline=time.monotonic() + JOB_SECONDS):
        if event["kind"] in kinds:
            return event
    raise Problem(f"job {job_id} ended without {' or '.join(kinds)}")


def measure_reclaims(bench) -> Finding:
    """From `kill -9` of a worker to the next claim of each of its jobs, with the default lease. The jobs wait for a
    vendor that does not answer, so that eight fit into one worker and cost nothing."""
    seconds, rounds = [], 0
    lease = bench.given.lease
    settings = SMALL | {"worker.concurrency": str(JOBS_OF_A_WORKER)}
    settings |= leases_of(lease)
    with held_vendors(bench) as (vendors, _):
        with bench.service("postgres", "reclaim", settings=settings | vendors, workers_wanted=1) as service:
            while len(seconds) < bench.given.reclaims:
                # Jobs of a worker that died twice wait for turns of their own, so that each kill meets other ones.
                numbers = range(rounds * JOBS_OF_A_WORKER, (rounds + 1) * JOBS_OF_A_WORKER)
                jobs = [submit(service.api, number)[1] for number in numbers]
                epochs = {job: await_event(service.api, job, ("job_started",))["seq"] for job in jobs}
                # One that is there already, as where several workers run.
                other = service.another_worker()
                service.workers.append(other)
                other.start()
                # Somewhere between two heartbeats.
                time.sleep(random.Random(rounds).uniform(0, max(1, lease // 6)))
                dead = service.workers.pop(0)
                dead.kill()
                killed_at = time.time()
                for job in jobs:
                    started = await_event(service.api, job, ("job_started",), after=epochs[job])
                    seconds.append(at_seconds(started) - killed_at)
                for job in jobs:
                    service.api.json("POST", f"/jobs/{job}/cancel")
                    service.api.wait(job, JOB_SECONDS)
                rounds += 1
                print(f"{len(seconds)} claims after {rounds} kills: p99 {quantile(seconds, 0.99):.1f} s", flush=True)
    p99, limit = quantile(seconds, 0.99), lease + MAX_LATER_SECONDS
    rows = [[lease, rounds, len(seconds), f"{quantile(seconds, 0.5):.1f}", f"{p99:.1f}", f"{max(seconds):.1f}", limit]]
    columns = ["lease, s", "workers killed", "jobs claimed again", "median, s", "p99, s", "longest, s", "at most, s"]
    full = bench.given.reclaims >= PROMISED_RECLAIMS and lease == DEFAULT_LEASE_SECONDS
    return Finding(columns, rows, p99 <= limit, full=full)


def measure_slow_stage(bench) -> Finding:
    """A stage that waits for a vendor for many times the lease, beside an idle worker that would like the job."""
    rows, rescues, failures = [], 0, []
    stores = bench.stores()
    for store in stores:
        with held_vendors(bench) as (vendors, proxy):
            with bench.service(store, f"slow-{store}", settings=SMALL | vendors, workers_wanted=2) as service:
                jobs = [submit(service.api, number)[1] for number in range(2)]
                for job in jobs:
                    await_event(service.api, job, ("stage_started",))
                time.sleep(bench.given.stage_seconds)
                proxy.release()
                states = [service.api.wait(job, JOB_SECONDS)["state"] for job in jobs]
                claims = [
                    sum(event["kind"] == "job_started" for event in service.api.events_after(job)) for job in jobs
                ]
        rows.append(
            [
                store,
                DEFAULT_LEASE_SECONDS,
                bench.given.stage_seconds,
                len(jobs),
                sum(claims) - len(jobs),
                sum(state == "succeeded" for state in states),
            ]
        )
        print(f"{store}: {rows[-1]}", flush=True)
        rescues += sum(claims) - len(jobs)
        failures += [state for state in states if state != "succeeded"]
    columns = ["store", "lease, s", "stage, s", "jobs", "false rescues", "succeeded"]
    full = bench.given.stage_seconds >= PROMISED_STAGE_SECONDS and len(stores) == 2
    return Finding(columns, rows, rescues == 0 and not failures, full=full)
