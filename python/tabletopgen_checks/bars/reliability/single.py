"""The same request twice at once: computed once, paid once; and 200 times through two API processes: one scene."""

import http.client
import json
import threading
from collections import Counter
from functools import partial

from tabletopgen_checks.bars.reliability.part import Finding
from tabletopgen_checks.bars.reliability.scenes import JOB_SECONDS, SMALL, digest_of, request_of, side_by_side, submit
from tabletopgen_checks.service.mock_vendors import MockVendors
from tabletopgen_checks.service.server import Server

PROMISED_TWINS, PROMISED_POSTS = 10, 200
LATENCY_MS = 300
# What the vendors of the test draw is unlike what they place; here it counts how often they are asked.
UNJUDGED = {"fidelity.min_silhouette_iou": "0", "fidelity.max_missed_share": "1", "fidelity.max_invented_share": "1"}


def measure_twins(bench) -> Finding:
    """Each text is submitted twice at the same moment; two workers, or two slots on SQLite, take one job each."""
    rows, wrong = [], []
    stores = bench.stores()
    for store in stores:
        repeated, paid_twice, others = 0, 0, 0
        with MockVendors(bench.binary, LATENCY_MS) as providers:
            settings = SMALL | UNJUDGED | providers.vendors()
            with bench.service(store, f"once-{store}", settings=settings) as service:
                bills, digests = [], []
                for number in range(bench.given.twins):
                    before = len(providers.bill())
                    scene_id, job_id = submit(service.api, number)
                    service.api.wait(job_id, JOB_SECONDS)
                    bills.append(Counter(providers.bill()[before:]))
                    digests.append(digest_of(service.api, scene_id))
            slots = {"worker.concurrency": "2" if store == "sqlite" else "1"}
            with bench.service(store, f"twins-{store}", settings=settings | slots, workers_wanted=2) as service:
                for number in range(bench.given.twins):
                    before = len(providers.bill())
                    pair = side_by_side(partial(submit, service.api), [number, number], 2)
                    states = [service.api.wait(job_id, JOB_SECONDS)["state"] for _, job_id in pair]
                    if states != ["succeeded"] * 2:
                        wrong.append(f"scene {number} on {store}: {states}")
                        continue
                    stages = [service.api.json("GET", f"/jobs/{job_id}/stages")["stages"] for _, job_id in pair]
                    computed = Counter(
                        (s["stage"], s.get("instance")) for one in stages for s in one if not s["cached"]
                    )
                    again = [key for key, count in computed.items() if count != 1]
                    more = Counter(providers.bill()[before:]) - bills[number]
                    repeated, paid_twice = repeated + len(again), paid_twice + sum(more.values())
                    others += sum(digest_of(service.api, scene_id) != digests[number] for scene_id, _ in pair)
                    wrong += [f"scene {number} on {store}: {key} was computed {computed[key]} times" for key in again]
                    wrong += [
                        f"scene {number} on {store}: {line[:2]} was paid {count} times more"
                        for line, count in more.items()
                    ]
        rows.append([store, bench.given.twins, repeated, paid_twice, others])
        print(f"{store}: {rows[-1]} {wrong[:10]}", flush=True)
    columns = ["store", "pairs", "stages computed twice", "vendor calls paid twice", "other bytes"]
    held = not wrong and all(row[2:] == [0, 0, 0] for row in rows)
    words = f"Every vendor call takes {LATENCY_MS} ms."
    if wrong:
        words += "\n\n" + "\n".join(f"- {line}" for line in wrong[:20])
    return Finding(columns, rows, held, words, full=bench.given.twins >= PROMISED_TWINS and len(stores) == 2)


def measure_posts(bench) -> Finding:
    """Identical POSTs with one idempotency key, all sent at once, through two API processes on PostgreSQL."""
    rows = []
    stores = bench.stores()
    for store in stores:
        with bench.service(store, f"posts-{store}", settings=SMALL, apis_wanted=2) as service:
            text, seed = request_of(0)
            answers = posts(service.apis, {"text": text, "seed": seed}, bench.given.posts)
            scenes = {scene for _, scene, _ in answers if scene}
            others = posts(service.apis, {"text": text, "seed": seed + 1}, 2 * len(service.apis))
            listed = service.api.json("GET", "/scenes?page_size=200")["scenes"]
        statuses = Counter(status for status, _, _ in answers)
        refused = Counter(f"{status} {code}".strip() for status, _, code in others)
        rows.append([store, len(service.apis), len(answers), shown(statuses), len(scenes), len(listed), shown(refused)])
        print(f"{store}: {rows[-1]}", flush=True)
    columns = ["store", "API processes", "identical POSTs", "answers", "scenes named", "scenes stored", "another body"]
    held = all(
        set(part.split(": ")[0] for part in row[3].split(", ")) <= {"200", "202"}
        and row[4] == row[5] == 1
        and all(part.startswith("422 ") for part in row[6].split(", "))
        for row in rows
    )
    return Finding(columns, rows, held, full=bench.given.posts >= PROMISED_POSTS and len(stores) == 2)


def shown(counts: Counter) -> str:
    return ", ".join(f"{what}: {count}" for what, count in sorted(counts.items(), key=lambda item: str(item[0])))


def posts(apis: list, body: dict, count: int) -> list:
    """Status, scene and problem code of each; the connections are made first and the bodies sent at one moment."""
    gate = threading.Barrier(count)

    def post(k) -> tuple:
        api: Server = apis[k % len(apis)]
        connection = http.client.HTTPConnection("127.0.0.1", api.port, timeout=60)
        connection.connect()
        gate.wait()
        headers = {"content-type": "application/json", "idempotency-key": "the-same"}
        connection.request("POST", "/scenes", json.dumps(body).encode(), headers)
        response = connection.getresponse()
        content = json.loads(response.read())
        connection.close()
        return response.status, content.get("id") if response.status in (200, 202) else None, content.get("code", "")

    return side_by_side(post, range(count), count)
