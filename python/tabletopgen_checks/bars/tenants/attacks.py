"""What a hostile tenant does, each in a process of its own that comes last for the processor: clients of other machines
would not take the server's cores."""

import asyncio
import contextlib
import json
import multiprocessing
import os
import time

from tabletopgen_checks.bars.overload import HEAD, Attack
from tabletopgen_checks.bars.reliability import load

FLOODING_CLIENTS, BODY_CLIENTS, STREAMS, BATCH_CLIENTS = 8, 2, 200, 1
BODY_BYTES, BATCH_REQUESTS = 16 << 20, 1000
# What a line of a gigabit a second carries; this machine's own network would carry five times as many.
BODIES_PER_S = 7
TEXT = "An office desk with exactly a mug and nothing else"


def submissions(port: int, header: dict, seconds: float, _job: str):
    """As many as are answered."""
    requests = (load.post("/scenes", {"text": TEXT, "seed": 10**9 + k}, header) for k in range(10**9))
    return load.run([port], FLOODING_CLIENTS, seconds, lambda _: next(requests))[2]


def big_bodies(port: int, header: dict, seconds: float, _job: str):
    """Large bodies that are no scene."""
    request, began = load.post("/scenes", {"text": "x" * BODY_BYTES}, header), time.monotonic()

    def paced(k: int) -> bytes:
        time.sleep(max(0.0, began + k / BODIES_PER_S - time.monotonic()))
        return request

    return load.run([port], BODY_CLIENTS, seconds, paced)[2]


def batches(port: int, header: dict, seconds: float, _job: str):
    body = {"templates": [TEXT], "seeds": {"first": 0, "count": BATCH_REQUESTS}}
    return load.run([port], BATCH_CLIENTS, seconds, lambda _: load.post("/batches", body, header))[2]


def streams(port: int, header: dict, seconds: float, job: str):
    """Event streams that are opened and never read."""
    lines = "".join(f"{name}: {value}\r\n" for name, value in header.items())
    attack = Attack(HEAD.format(method="GET", path=f"/jobs/{job}/events") + f"{lines}accept: text/event-stream\r\n\r\n", STREAMS)
    began = time.monotonic()
    asyncio.run(attack.open(port))
    time.sleep(max(0.0, seconds - (time.monotonic() - began)))
    attack.end()
    return {"opened": STREAMS - attack.refused}


ATTACKS = {"submissions": submissions, "big bodies": big_bodies, "batches": batches, "event streams": streams}


def attack(name: str, answers, *arguments):
    os.nice(19)
    answers.put((name, {str(status): count for status, count in ATTACKS[name](*arguments).items()}))


@contextlib.contextmanager
def under(names, client, seconds: float, job: str):
    """Those attacks at once, on behalf of a client; yields what they were answered, by attack, once they have ended."""
    answers, found = multiprocessing.Queue(), {}
    arguments = (client.port, client.credential(), seconds, job)
    many = [multiprocessing.Process(target=attack, args=(name, answers, *arguments), daemon=True) for name in names]
    for one in many:
        one.start()
    try:
        yield found
        for _ in many:
            name, counts = answers.get(timeout=seconds + 120)
            found[name] = counts
    finally:
        for one in many:
            one.kill()
            one.join()


def summary(found: dict) -> str:
    """What the attacks were answered, in words."""
    return "; ".join(f"{name} {json.dumps(counts, sort_keys=True)}" for name, counts in sorted(found.items()))
