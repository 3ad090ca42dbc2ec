"""A thousand scenes are created and deleted: the disk is used as before."""

import stat
import time

from tabletopgen_checks.bars.reliability.part import Finding
from tabletopgen_checks.bars.reliability.scenes import JOB_SECONDS, SMALL, submit, wait_for_all
from tabletopgen_checks.problem import Problem

PROMISED = 1000
AT_ONCE = 20
# Deleted scenes are swept within two minutes; no stage of these scenes takes a minute.
GRACE_SECONDS, INTERVAL_SECONDS = 60, 10
SWEPT_SOON = {
    "worker.stage_timeout_secs": str(GRACE_SECONDS - 1),
    "store.retention.sweep_interval_secs": str(INTERVAL_SECONDS),
    "store.retention.grace_secs": str(GRACE_SECONDS),
    "store.retention.deleted_hours": "0",
}
# What may be left: a database keeps pages for later use.
MAX_LEFT_MB = 8


def measure(bench) -> Finding:
    rows, held = [], True
    stores = bench.stores()
    for store in stores:
        with bench.service(store, f"churn-{store}", settings=SMALL | SWEPT_SOON, workers_wanted=2) as service:
            # The first scenes also make tables, logs and pages that stay; the comparison begins after them.
            create_and_delete(service, 0, AT_ONCE)
            before = usage(service, swept=True)
            peak, scenes = before, 0
            while scenes < bench.given.churn:
                count = min(AT_ONCE, bench.given.churn - scenes)
                full = create_and_delete(service, AT_ONCE + scenes, count)
                peak = [max(a, b) for a, b in zip(peak, full)]
                scenes += count
            after = usage(service, swept=True)
        rows.append([store, scenes, *(shown(part) for part in zip(before, peak, after))])
        held &= after[0] <= before[0] and after[1] <= before[1] + MAX_LEFT_MB and after[2] <= before[2]
        print(rows[-1], flush=True)
    columns = ["store", "scenes", "blobs, MB", "database, MB", "files or objects"]
    words = "Each cell: before, the most meanwhile, after the last was deleted and swept."
    return Finding(columns, rows, held, words, full=bench.given.churn >= PROMISED and len(stores) == 2)


def shown(part) -> str:
    return " / ".join(f"{value:.1f}" if isinstance(value, float) else str(value) for value in part)


def create_and_delete(service, first: int, count: int) -> list:
    """The disk's usage when all are made; then they are deleted."""
    ids = [submit(service.api, first + k) for k in range(count)]
    states = wait_for_all(service.api, [job_id for _, job_id in ids], JOB_SECONDS)
    if states != ["succeeded"] * count:
        raise Problem(f"scenes were not made: {states}")
    full = usage(service)
    for scene_id, _ in ids:
        status, _, content = service.api.request("DELETE", f"/scenes/{scene_id}")
        if status not in (200, 202, 204):
            raise Problem(f"DELETE /scenes/{scene_id} was answered with {status}: {content[:200]!r}")
    return full


def usage(service, swept=False) -> list:
    """MB of blobs, MB of the database, number of blobs; with `swept`, when it does not shrink any more."""
    if swept:
        time.sleep(GRACE_SECONDS + 2 * INTERVAL_SECONDS)
    last, same = None, 0
    while True:
        now = usage_now(service)
        same = same + 1 if last is not None and now[2] >= last[2] else 0
        if not swept or same >= 10:
            return now
        last = now
        time.sleep(2)


def usage_now(service) -> list:
    if service.store == "sqlite":
        blobs = sizes(service.data_folder.joinpath("blobs").rglob("*"))
        database = sum(sizes(service.data_folder.glob("tabletopgen.sqlite*")))
    else:
        blobs = list(service.bench.s3.objects(service.bucket).values())
        database = int(service.rows("SELECT pg_database_size(current_database())")[0][0])
    return [sum(blobs) / 1e6, database / 1e6, len(blobs)]


def sizes(paths) -> list:
    """Of the files among them; one that vanishes meanwhile is none."""
    found = []
    for path in paths:
        try:
            facts = path.stat()
        except FileNotFoundError:
            continue
        if stat.S_ISREG(facts.st_mode):
            found.append(facts.st_size)
    return found
