"""Scenes per hour with more workers: against slow vendors on one PostgreSQL, and with embedded models on two cores."""

import os
import shutil
import subprocess
import time
from pathlib import Path

from tabletopgen_checks.bars.reliability.bench import cores
from tabletopgen_checks.bars.reliability.part import Finding
from tabletopgen_checks.bars.reliability.scenes import JOB_SECONDS, SMALL, at_seconds, request_of, side_by_side, submit, wait_for_all
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.service.mock_vendors import MockVendors

WORKERS = (1, 2, 4, 8)
PROMISED_SCENES, MIN_EFFICIENCY = 4, 0.85
PROMISED_EMBEDDED, MIN_SPEEDUP = 8, 1.8
ONE_THREAD = {"worker.concurrency": "1", "worker.cpu_threads": "1"}
# Scenes of each program that runs without a service.
ALONE = 4


def measure_vendors(bench) -> Finding:
    """Every worker has one slot and makes the same number of scenes; all are different."""
    rows, rate_of_one = [], None
    counts = [count for count in WORKERS if count <= bench.given.workers]
    for count in counts:
        with MockVendors(bench.binary, bench.given.latency_ms) as providers:
            settings = SMALL | providers.vendors() | {"worker.concurrency": "1"}
            with bench.service("postgres", f"workers{count}", settings=settings, workers_wanted=count) as service:
                rate, seconds = rate_of(service, count * bench.given.scenes_each)
        rate_of_one = rate_of_one or rate
        efficiency = rate / (count * rate_of_one)
        rows.append(
            [count, count * bench.given.scenes_each, f"{seconds:.0f}", f"{rate:.0f}", f"{100 * efficiency:.0f} %"]
        )
        print(rows[-1], flush=True)
    columns = ["worker processes", "scenes", "seconds", "scenes per hour", "efficiency"]
    seconds = bench.given.latency_ms / 1000
    words = f"Every vendor call takes {seconds:.1f} s; at 8 workers {MIN_EFFICIENCY:.0%} is promised."
    full = counts == list(WORKERS) and bench.given.scenes_each >= PROMISED_SCENES
    return Finding(columns, rows, efficiency >= MIN_EFFICIENCY, words, full=full)


def rate_of(service, scenes: int, first=0) -> tuple:
    """Scenes per hour and seconds, from the first claim to the last end."""
    jobs = [submit(service.api, first + number)[1] for number in range(scenes)]
    states = wait_for_all(service.api, jobs, JOB_SECONDS * scenes)
    if states != ["succeeded"] * scenes:
        raise Problem(f"scenes were not made: {states}")
    events = [service.api.events_after(job) for job in jobs]
    began = min(at_seconds(event) for one in events for event in one if event["kind"] == "job_started")
    ended = max(at_seconds(one[-1]) for one in events)
    return 3600 * scenes / (ended - began), ended - began


def measure_cores(bench) -> Finding:
    """Everything that belongs to the service, PostgreSQL and S3 included, on one core with one worker, then on two
    with two. Scenes have previews of the usual size: of the smallest size they are made in less than a second, most of
    which PostgreSQL, S3 and the API take.

    One is measured before and after two, and the better one counts. What the two cores give to programs that share
    nothing is measured beside it: scenes of `tabletopgen generate` on one core, and on both at once.
    """
    if len(cores()) < 2:
        raise Problem("two cores are needed for this part: --only names others")
    rows, rates = [], {1: [], 2: []}
    try:
        for count in (1, 2, 1):
            chosen = cores()[:count]
            for process in (bench.postgres.process, bench.s3.process):
                pin(process.pid, chosen)
            within = ("taskset", "--cpu-list", ",".join(map(str, chosen)))
            with bench.service(
                "postgres", f"cores{count}", settings=ONE_THREAD, workers_wanted=count, within=within
            ) as service:
                rate, seconds = rate_of(service, count * bench.given.embedded_each)
            rates[count].append(rate)
            rows.append([count, count, count * bench.given.embedded_each, f"{seconds:.0f}", f"{rate:.0f}"])
            print(rows[-1], flush=True)
    finally:
        for process in (bench.postgres.process, bench.s3.process):
            pin(process.pid, cores())
    speedup = max(rates[2]) / max(rates[1])
    columns = ["cores", "workers", "scenes", "seconds", "scenes per hour"]
    words = (
        f"Two workers on two cores are {speedup:.2f} times as fast as one on one; {MIN_SPEEDUP} is promised. Two "
        f"programs that share nothing but the machine are {speedup_without_service(bench):.2f} times as fast."
    )
    return Finding(columns, rows, speedup >= MIN_SPEEDUP, words, full=bench.given.embedded_each >= PROMISED_EMBEDDED)


def speedup_without_service(bench) -> float:
    """Of scenes made on both cores at once, over those made on one."""

    def seconds_on(chosen: list) -> float:
        began = time.monotonic()
        side_by_side(lambda core: [generated(bench, core, number) for number in range(ALONE)], chosen, len(chosen))
        return time.monotonic() - began

    one = min(seconds_on(cores()[:1]) for _ in range(2))
    return 2 * one / seconds_on(cores()[:2])


def generated(bench, core: int, number: int):
    """Makes a scene of one object on one core."""
    text, seed = request_of(number)
    folder = bench.folder / f"alone{core}"
    shutil.rmtree(folder, ignore_errors=True)
    settings = [part for key, value in ONE_THREAD.items() for part in ("--set", f"{key}={value}")]
    within = ["taskset", "--cpu-list", core]
    command = [*within, bench.binary, "generate", "--text", text, "--seed", seed, "--out", folder, *settings]
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        raise Problem(f"tabletopgen generate ended with {done.returncode}: {done.stderr[-500:]}")


def pin(pid: int, chosen: list):
    """Every thread of a process; what it forks later inherits that. Those that end meanwhile are left out."""
    try:
        for thread in Path(f"/proc/{pid}/task").iterdir():
            os.sched_setaffinity(int(thread.name), chosen)
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except (FileNotFoundError, ProcessLookupError):
        return
    for child in children:
        pin(int(child), chosen)
