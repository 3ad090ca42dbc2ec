"""Half an hour of steady work on both stores: memory, descriptors, write-ahead log and tables stay as they are.

Scenes are submitted one after the other, a few at a time, downloaded and deleted, on both stores at the same time.
Every few seconds the processes and the database are measured; a line through the second half of each series has to be
flat."""

import contextlib
import os
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tabletopgen_checks.bars.reliability import plot
from tabletopgen_checks.bars.reliability.churn import SWEPT_SOON, sizes, usage_now
from tabletopgen_checks.bars.reliability.part import Finding
from tabletopgen_checks.bars.reliability.scenes import JOB_SECONDS, SMALL, digest_of, submit
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import RESULTS

PROMISED_MINUTES = 30
SAMPLE_SECONDS = 5
USERS = 3
# Growth of the second half that is taken for flat, of the mean.
FLAT_SHARE = 0.10
# PostgreSQL keeps a gigabyte of its write-ahead log if it is left alone, which half an hour does not fill.
LOG_OF_POSTGRES = {"min_wal_size": "32MB", "max_wal_size": "48MB", "checkpoint_timeout": "60s"}
TABLES = ("scenes", "jobs", "events", "stages", "checkpoints", "artifacts", "bundle_files")


def measure(bench) -> Finding:
    rows, held, plots = [], True, []
    stores = bench.stores()
    for store, (samples, scenes) in zip(stores, soaked_side_by_side(bench, stores)):
        for name, unit in (
            ("memory", "MB"),
            ("descriptors", ""),
            ("write-ahead log", "MB"),
            ("database", "MB"),
            ("blobs", "MB"),
            ("rows", ""),
        ):
            series = [(minutes, values[name]) for minutes, values in samples]
            growth = growth_of(series)
            flat = growth <= FLAT_SHARE
            held &= flat
            halfway, end = series[len(series) // 2][1], series[-1][1]
            rows.append(
                [
                    store,
                    name + (f", {unit}" if unit else ""),
                    scenes,
                    f"{series[0][1]:.1f}",
                    f"{halfway:.1f}",
                    f"{end:.1f}",
                    f"{100 * growth:+.1f} %",
                    "yes" if flat else "NO",
                ]
            )
            print(rows[-1], flush=True)
        plots.append(plot_of(store, samples, bench.given.soak_minutes, bench.given.page))
    columns = ["store", "what", "scenes", "at start", "half way", "at the end", "growth of the second half", "flat"]
    words = (
        f"{bench.given.soak_minutes} minutes, both stores at once, {USERS} clients each that submit, wait, download and delete. Growth is "
        f"that of a line through the second half, over that half, of the mean; at most {FLAT_SHARE:.0%} is flat. "
        f"PostgreSQL's `max_wal_size` is {LOG_OF_POSTGRES['max_wal_size']}, which half an hour of this work fills."
    )
    return Finding(
        columns,
        rows,
        held,
        words,
        bench.given.soak_minutes >= PROMISED_MINUTES and len(stores) == 2,
        [name for name in plots if name],
    )


def soaked_side_by_side(bench, stores) -> list:
    """What `soaked` returns of each store, in their order."""
    with contextlib.ExitStack() as stack:
        if "postgres" in stores:
            for name, value in LOG_OF_POSTGRES.items():
                bench.postgres.sql(f"ALTER SYSTEM SET {name} = '{value}'")
            bench.postgres.sql("SELECT pg_reload_conf()")
        services = [
            stack.enter_context(
                bench.service(store, f"soak-{store}", settings=SMALL | SWEPT_SOON, workers_wanted=2)
            )
            for store in stores
        ]
        with ThreadPoolExecutor(len(services)) as pool:
            return list(pool.map(lambda service: soaked(service, 60 * bench.given.soak_minutes), services))


def soaked(service, seconds: float) -> tuple:
    """[(minutes, values by name)], and the number of scenes that were made."""
    over, lock, numbers, made, problems = threading.Event(), threading.Lock(), iter(range(10**9)), [], []

    def user():
        try:
            while not over.is_set():
                with lock:
                    number = next(numbers)
                scene_id, job_id = submit(service.api, number)
                job = service.api.wait(job_id, JOB_SECONDS)
                if job["state"] != "succeeded":
                    raise Problem(f"scene {number} is {job['state']}: {job.get('failure')}")
                digest_of(service.api, scene_id)
                service.api.request("DELETE", f"/scenes/{scene_id}")
                made.append(number)
        except Problem as problem:
            problems.append(problem)

    users = [threading.Thread(target=user, daemon=True) for _ in range(USERS)]
    for thread in users:
        thread.start()
    began, samples = time.monotonic(), []
    while time.monotonic() - began < seconds and not problems:
        samples.append(((time.monotonic() - began) / 60, sample(service)))
        time.sleep(SAMPLE_SECONDS)
    over.set()
    for thread in users:
        thread.join(JOB_SECONDS)
    if problems:
        raise problems[0]
    if len(samples) < 4:
        raise Problem("the soak was too short to tell anything: give it at least half a minute")
    return samples, len(made)


def sample(service) -> dict:
    pids = [server.pid for server in service.servers]
    blobs, database, _ = usage_now(service)
    return {
        "memory": sum(resident_mb(pid) for pid in pids),
        "descriptors": float(sum(len(os.listdir(f"/proc/{pid}/fd")) for pid in pids)),
        "write-ahead log": log_mb(service),
        "database": database,
        "blobs": blobs,
        "rows": float(sum(int(service.rows(f"SELECT count(*) FROM {table}")[0][0]) for table in TABLES)),
    }


def resident_mb(pid: int) -> float:
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024
    return 0.0


def log_mb(service) -> float:
    if service.store == "sqlite":
        log = service.data_folder / "tabletopgen.sqlite-wal"
        return sum(sizes([log])) / 1e6
    return int(service.rows("SELECT coalesce(sum(size), 0) FROM pg_ls_waldir()")[0][0]) / 1e6


def growth_of(series: list) -> float:
    """Of the line of least squares through the second half, from its start to its end, as a share of the mean."""
    half = series[len(series) // 2 :]
    mean_x = sum(x for x, _ in half) / len(half)
    mean_y = sum(y for _, y in half) / len(half)
    spread = sum((x - mean_x) ** 2 for x, _ in half)
    if spread == 0 or mean_y == 0:
        return 0.0
    slope = sum((x - mean_x) * (y - mean_y) for x, y in half) / spread
    return slope * (half[-1][0] - half[0][0]) / mean_y


def plot_of(store: str, samples: list, minutes: float, page: str) -> str:
    """Its name in docs/results, where a page is written."""
    if page != "yes":
        return ""
    units = {
        "memory": "MB",
        "descriptors": "open",
        "write-ahead log": "MB",
        "database": "MB",
        "blobs": "MB",
        "rows": "of all tables",
    }
    panels = [(name, unit, [(store, [(at, values[name]) for at, values in samples])]) for name, unit in units.items()]
    name = f"reliability_soak_{store}.svg"
    plot.draw(RESULTS / name, f"{minutes} minutes on {store}", panels)
    return name
