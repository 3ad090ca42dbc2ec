"""Scenes, recordings, datasets and batches are made and deleted: rows of every table and bytes on disk are as before.

Scenes repeat some contents, so that a thousand of them take minutes: a scene of the same content finds its stages in
the store, and shares blobs and checkpoints with the others, which have to stay until the last of them is deleted."""

import sqlite3
import time
from collections.abc import Callable

from tabletopgen_checks.bars.recordings import CAMERAS, FORMAT, SCENE_SEED, SENTENCE, SIZE_PX, TASK
from tabletopgen_checks.bars.reliability.bench import STORES
from tabletopgen_checks.bars.reliability.churn import usage_now
from tabletopgen_checks.bars.reliability.part import Finding
from tabletopgen_checks.bars.reliability.scenes import JOB_SECONDS, SMALL, request_of, side_by_side, wait_for_all
from tabletopgen_checks.problem import Problem

PROMISED_SCENES, PROMISED_OTHERS, CONTENTS = 1000, 20, 20
SCENES_OF_A_BATCH, CLIENTS, AT_ONCE = 2, 4, 100
# Rows that stay by design: the record of changes, and what is written over and over.
BY_DESIGN = ("audit",)
# No stage of these scenes takes as long.
PROMISED_GRACE_SECONDS, SWEEP_SECONDS, SWEEP_PATIENCE_SECONDS, POLL_SECONDS = 30, 5, 240, 1
# Beside the rows of the record of changes: a page for each of the many indexes may be another.
MAX_LEFT_BYTES, BYTES_OF_A_RECORD = 1 << 20, 600


def measure(bench) -> Finding:
    rows, held, words, grace = [], True, [], bench.given.grace_seconds
    for store in bench.stores():
        with bench.keyed(store, f"deletion-{store}", SMALL | swept_after(grace), workers_wanted=2) as service:
            client = bench.client(service)
            # The first of everything also makes rows and pages that stay.
            delete(client, make(client, 1, 1)[0])
            before = swept(service, grace, {})
            made, peak = make(client, bench.given.scenes, bench.given.others, lambda: counts(service))
            full = counts(service)
            peak = {name: max(peak.get(name, 0), count) for name, count in full.items()}
            disk_at_peak = disk(service)
            delete(client, made)
            after = swept(service, grace, before[0])
        left = {name: after[0].get(name, 0) - count for name, count in before[0].items()}
        grown = {name: count for name, count in left.items() if count > 0 and name not in BY_DESIGN}
        allowed = MAX_LEFT_BYTES + BYTES_OF_A_RECORD * max(0, left.get("audit", 0))
        fits = after[1]["database, bytes"] <= before[1]["database, bytes"] + allowed
        fits &= after[1]["blobs, bytes"] <= before[1]["blobs, bytes"] and after[1]["files of blobs"] <= before[1]["files of blobs"]
        held &= not grown and fits
        for name in sorted(peak):
            if peak[name] or after[0].get(name):
                stays = "stays by design" if name in BY_DESIGN else "holds" if name not in grown else "DOES NOT HOLD"
                rows.append([store, f"rows of `{name}`", before[0].get(name, 0), peak[name], after[0].get(name, 0), stays])
        for name in before[1]:
            rows.append([store, name, before[1][name], disk_at_peak[name], after[1][name], "holds" if fits else "DOES NOT HOLD"])
        words.append(
            f"On {store} the database may be {allowed} bytes larger: {MAX_LEFT_BYTES}, and {BYTES_OF_A_RECORD} for each row of `audit`."
        )
        print(f"{store}: grown {grown}, {before[1]}, {after[1]}", flush=True)
    given = bench.given
    lead = (
        f"{given.scenes} scenes of {min(CONTENTS, given.scenes)} contents, {given.others} recordings of an episode, "
        f"{given.others} datasets and {given.others} batches of {SCENES_OF_A_BATCH} scenes, made and deleted with "
        f"`store.retention.deleted_hours = 0` and `grace_secs = {grace}`. Bytes of the database are those after a vacuum: "
        "of a copy by `VACUUM INTO` on SQLite, by `VACUUM FULL` on PostgreSQL. Rows of `audit` are only ever added to."
    )
    full = given.scenes >= PROMISED_SCENES and given.others >= PROMISED_OTHERS and len(bench.stores()) == len(STORES)
    return Finding(["store", "", "before", "at peak", "after", ""], rows, held, " ".join([lead, *words]), full=full)


def swept_after(grace: int) -> dict:
    """Settings by which what is deleted goes soon."""
    return {
        "worker.stage_timeout_secs": str(grace - 1),
        "store.retention.sweep_interval_secs": str(SWEEP_SECONDS),
        "store.retention.grace_secs": str(grace),
        "store.retention.deleted_hours": "0",
    }


def make(client, scenes: int, others: int, count: Callable[[], dict] = dict) -> tuple:
    """Paths of all that was made, in an order in which it may be deleted; and the peak rows of each table meanwhile."""
    paths, peak = [], {}
    for first in range(0, scenes, AT_ONCE):
        numbers = [k % CONTENTS for k in range(first, min(scenes, first + AT_ONCE))]
        made = side_by_side(lambda number: submit(client, *request_of(number)), numbers, CLIENTS)
        ended(client, [job for _, job in made])
        paths += [f"/scenes/{scene}" for scene, _ in made]
    recorded, job = submit(client, SENTENCE, SCENE_SEED)
    ended(client, [job])
    order = {"task": TASK, "count": 1, "formats": [FORMAT], "title": "deleted", "record": {"cameras": CAMERAS, "size_px": SIZE_PX}}
    orders = [("/batches", {"templates": [request_of(k)[0]], "seeds": {"first": 1, "count": SCENES_OF_A_BATCH}}) for k in range(others)]
    orders += [(f"/scenes/{recorded}/episodes", order | {"seed": k}) for k in range(others)]
    orders += [
        ("/datasets", {"name": f"deleted{k}", "scenes": [recorded, paths[0].split("/")[2]], "splits": {"train": 1.0}})
        for k in range(others)
    ]
    made = [(path, client.json("POST", path, body)["id"]) for path, body in orders]
    others_made = [f"/{'episodes' if path.endswith('/episodes') else path[1:]}/{one}" for path, one in made]
    for path in others_made:
        finished(client, path)
        now = count()
        peak = {name: max(peak.get(name, 0), rows) for name, rows in now.items()}
    with_scenes = [f"{path}?scenes=delete" if path.startswith("/batches") else path for path in others_made]
    return [*with_scenes, *paths, f"/scenes/{recorded}"], peak


def submit(client, text: str, seed: int) -> tuple:
    scene = client.submit_text(text, seed)
    return scene["id"], scene["job"]["id"]


def ended(client, jobs: list):
    states = wait_for_all(client, jobs, JOB_SECONDS)
    if set(states) != {"succeeded"}:
        raise Problem(f"scenes were not made: {sorted(set(states))}\n{client.words()}")


def finished(client, path: str):
    deadline = time.monotonic() + JOB_SECONDS
    while (state := client.json("GET", path)["state"]) != "finished":
        if state in ("failed", "cancelled") or time.monotonic() > deadline:
            raise Problem(f"{path} is {state}\n{client.words()}")
        time.sleep(0.2)


def delete(client, paths: list):
    for path in paths:
        status, _, content = client.request("DELETE", path)
        if status not in (200, 202, 204):
            raise Problem(f"DELETE {path} was answered with {status}: {content[:300]!r}")


def swept(service, grace: int, wanted: dict) -> tuple:
    """Rows by table and the disk, once no table has more rows than wanted and nothing changes, or the time is over."""
    deadline, last, same = time.monotonic() + grace + SWEEP_PATIENCE_SECONDS, None, 0
    time.sleep(grace + SWEEP_SECONDS)
    while True:
        now = counts(service), usage_now(service)[2]
        same = same + 1 if now == last else 0
        more = [name for name, count in now[0].items() if count > wanted.get(name, 0) and name not in BY_DESIGN]
        if same >= (60 if wanted and more else 2 * SWEEP_SECONDS) or time.monotonic() > deadline:
            return now[0], disk(service)
        last = now
        time.sleep(POLL_SECONDS)


def counts(service) -> dict:
    """Rows by table."""
    tables = "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite_%'"
    if service.store == "postgres":
        tables = "SELECT tablename FROM pg_tables WHERE schemaname = 'public'"
    names = [name for (name,) in service.rows(tables)]
    counted = service.rows(" UNION ALL ".join(f"SELECT '{name}', COUNT(*) FROM \"{name}\"" for name in names))
    return {name: int(count) for name, count in counted}


def disk(service) -> dict:
    blobs_mb, _, files = usage_now(service)
    return {"files of blobs": files, "blobs, bytes": round(1e6 * blobs_mb), "database, bytes": packed_bytes(service)}


def packed_bytes(service) -> int:
    """Of the database without free pages."""
    if service.store == "postgres":
        service.rows("VACUUM FULL")
        return int(service.rows("SELECT pg_database_size(current_database())")[0][0])
    copy = service.folder / "packed.sqlite"
    copy.unlink(missing_ok=True)
    connection = sqlite3.connect(service.data_folder / "tabletopgen.sqlite", timeout=30)
    try:
        connection.execute("VACUUM INTO ?", (str(copy),))
    finally:
        connection.close()
    return copy.stat().st_size
