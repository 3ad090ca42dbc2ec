"""Small scenes of known bytes, and what must hold of a job whose processes died.

A scene of one or two objects with the smallest previews takes a second or two, so that hundreds of kills are
affordable."""

import hashlib
import math
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from datetime import datetime

from tabletopgen_checks.problem import Problem

# Previews of the smallest size: they are of no interest here and take half of the time.
SMALL = {
    "preview.hero_width_px": "64",
    "preview.side_width_px": "64",
    "render.supersampling": "1",
    "render.shadow_map_px": "0",
    "render.sky_directions": "0",
}
# A dead worker is missed for eight seconds instead of thirty, so that hundreds of kills take minutes.
SHORT_LEASE_SECONDS = 8
TEXTS = (
    "An office desk with exactly a mug and nothing else",
    "An office desk with exactly a book and nothing else",
    "A table with exactly a plate and nothing else",
    "A table with exactly a bowl and nothing else",
    "A table with exactly an apple and nothing else",
    "A table with exactly a mug and a plate and nothing else",
)
JOB_SECONDS = 900


def leases_of(seconds: int) -> dict:
    """Settings with leases of so many seconds, eight at least: all tries of a request to S3 end within one."""
    return {
        "worker.lease_secs": str(seconds),
        "worker.heartbeat_secs": str(seconds // 6 or 1),
        "store.s3.retry_secs": str(min(12, seconds - 7)),
        "store.s3.timeout_secs": "8" if seconds >= 24 else "3",
    }


SHORT_LEASE = leases_of(SHORT_LEASE_SECONDS)
# Where a scene is not made within this time under kills, it is taken for lost.
PATIENCE = JOB_SECONDS


def request_of(number: int) -> tuple:
    """Text and seed of the scene of this number; another number is another scene."""
    return TEXTS[number % len(TEXTS)], 1 + number // len(TEXTS)


def submit(api, number: int, **more) -> tuple:
    """Scene id and job id."""
    text, seed = request_of(number)
    scene = api.submit_text(text, seed, **more)
    return scene["id"], scene["job"]["id"]


def digest_of(api, scene_id: str) -> str:
    """SHA-256 of the scene's bundle."""
    status, _, content = api.request("GET", f"/scenes/{scene_id}/bundle", timeout=120)
    if status != 200:
        raise Problem(f"the bundle of {scene_id} was answered with {status}")
    return hashlib.sha256(content).hexdigest()


def undisturbed(service, numbers) -> dict:
    """Digest of each scene's bundle, made while nothing happens."""
    ids = {number: submit(service.api, number) for number in numbers}
    made = {}
    for number, (scene_id, job_id) in ids.items():
        job = service.api.wait(job_id, JOB_SECONDS)
        if job["state"] != "succeeded":
            raise Problem(f"scene {request_of(number)} failed undisturbed: {job.get('failure')}")
        made[number] = digest_of(service.api, scene_id)
    return made


def key_of(event) -> tuple:
    return event["data"]["stage"], event["data"].get("instance", "")


def at_seconds(event) -> float:
    """When it happened by the database's clock, seconds since 1970."""
    return datetime.fromisoformat(event["at"].replace("Z", "+00:00")).timestamp()


def complaints(events: list) -> list:
    """What a job's events show that must not be: a finished stage computed again, a stage or the job committed
    twice.
    """
    wrong, finished = [], Counter()
    for event in events:
        if event["kind"] == "stage_started" and finished[key_of(event)]:
            wrong.append(f"repeated: {' '.join(key_of(event)).strip()} ran again after it had finished")
        if event["kind"] == "stage_finished" and not event["data"].get("cached"):
            finished[key_of(event)] += 1
    wrong += [f"twice: {' '.join(key).strip()} was committed {n} times" for key, n in finished.items() if n > 1]
    ends = sum(event["kind"] == "job_succeeded" for event in events)
    if ends != 1:
        wrong.append(f"twice: the job succeeded {ends} times" if ends else "lost: the job has no end")
    if [event["seq"] for event in events] != list(range(1, len(events) + 1)):
        wrong.append("twice: the events are not numbered 1, 2, 3, ...")
    return wrong


def outcome(api, scene_id: str, job_id: str, wanted: str) -> list:
    """Everything that is wrong with an ended job whose bundle should have the digest `wanted`."""
    job = api.json("GET", f"/jobs/{job_id}")
    if job["state"] != "succeeded":
        failure = (job.get("failure") or {}).get("code")
        return [f"lost: the job is {job['state']} ({failure})"]
    wrong = complaints(api.events_after(job_id))
    if digest_of(api, scene_id) != wanted:
        wrong.append("bytes: the bundle is another")
    return wrong


def wait_for_all(api, job_ids, seconds=PATIENCE) -> list:
    """The states of jobs once all have ended, or when patience has."""
    deadline = time.monotonic() + seconds
    open_jobs, states = list(job_ids), {}
    while open_jobs and time.monotonic() < deadline:
        for job_id in list(open_jobs):
            state = api.json("GET", f"/jobs/{job_id}")["state"]
            states[job_id] = state
            if state in ("succeeded", "failed", "cancelled"):
                open_jobs.remove(job_id)
        time.sleep(0.2)
    return [states.get(job_id, "unknown") for job_id in job_ids]


def side_by_side(work, items, lanes: int) -> list:
    """`work(item)` of each, so many at the same time; the first failure is raised."""
    with ThreadPoolExecutor(max(1, lanes)) as pool:
        return list(pool.map(work, items))


def tally(wrong: list) -> dict:
    """How often each kind of complaint came: lost, repeated, twice, bytes."""
    found = Counter(line.split(":")[0] for line in wrong)
    return {kind: found.get(kind, 0) for kind in ("lost", "repeated", "twice", "bytes")}


def quantile(values, share: float) -> float:
    """The smallest value that this share of all does not exceed."""
    ordered = sorted(values)
    return ordered[max(0, math.ceil(share * len(ordered)) - 1)]
