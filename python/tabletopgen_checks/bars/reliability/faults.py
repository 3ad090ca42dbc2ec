"""The database restarts, S3 is gone for a minute, the network is cut, the disk fills: nothing is lost, requests are
refused clearly, and the same processes go on."""

import itertools
import json
import shutil
import subprocess
import threading
import time
from collections import Counter
from dataclasses import dataclass, field

from tabletopgen_checks.bars.reliability import audit
from tabletopgen_checks.bars.reliability.network import Network
from tabletopgen_checks.bars.reliability.part import Finding
from tabletopgen_checks.bars.reliability.proxy import Proxy
from tabletopgen_checks.bars.reliability.scenes import (
    JOB_SECONDS,
    SHORT_LEASE,
    SMALL,
    outcome,
    request_of,
    submit,
    tally,
    undisturbed,
    wait_for_all,
)
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.service.postgres import Postgres

SCENES = 6
PROMISED_OUTAGE_SECONDS = 60
ASK_SECONDS = 0.5
# A request that waits longer than this for its refusal is not clear.
MAX_ANSWER_SECONDS = 30
SMALL_DISK_MB = 96
CLEAR = (503, 507)


@dataclass
class Responses:
    """Responses to the requests of a fault: counts by status and code, accepted jobs, and the longest time."""

    statuses: Counter = field(default_factory=Counter)
    codes: Counter = field(default_factory=Counter)
    accepted: list = field(default_factory=list)
    ready: list = field(default_factory=list)
    downloads: Counter = field(default_factory=Counter)
    longest_seconds: float = 0.0


class Asking(threading.Thread):
    """Twice a second submits a scene, asks whether the service is ready and downloads a bundle, as clients do that
    know nothing of the fault."""

    def __init__(self, api, first: int, made):
        super().__init__(daemon=True)
        self.api, self.number, self.made, self.asked, self.over = api, first, made, Responses(), threading.Event()

    def run(self):
        while not self.over.wait(ASK_SECONDS):
            text, seed = request_of(self.number)
            body = json.dumps({"text": text, "seed": seed}).encode()
            status, content = self.answer("POST", "/scenes", body, {"content-type": "application/json"})
            self.asked.statuses[status] += 1
            self.asked.ready.append(self.answer("GET", "/readyz")[0])
            self.asked.downloads[self.answer("GET", f"/scenes/{self.made}/bundle")[0]] += 1
            document = json.loads(content or b"{}")
            if status == 202:
                self.asked.accepted.append((self.number, document["id"], document["job"]["id"]))
                self.number += 1
            else:
                self.asked.codes[document.get("code", "no document")] += 1

    def answer(self, *request) -> tuple:
        """Status, 0 where there is none, and content."""
        began = time.monotonic()
        try:
            status, _, content = self.api.request(*request, timeout=2 * MAX_ANSWER_SECONDS)
        except Problem:
            status, content = 0, b"{}"
        self.asked.longest_seconds = max(self.asked.longest_seconds, time.monotonic() - began)
        return status, content

    def finish(self) -> Responses:
        self.over.set()
        self.join(4 * MAX_ANSWER_SECONDS)
        return self.asked


def measure(bench) -> Finding:
    rows, wrong = [], []
    parts = [
        ("postgres", "PostgreSQL restarts", postgres_restarts),
        ("postgres", "PostgreSQL crashes", postgres_crashes),
        ("postgres", f"S3 gone for {bench.given.outage_seconds} s", s3_gone),
        ("postgres", "network cut to the database", network_cut),
        ("sqlite", "disk full", disk_full),
        ("postgres", "disk of PostgreSQL full", postgres_disk_full),
    ]
    full = bench.given.outage_seconds >= PROMISED_OUTAGE_SECONDS and bench.stores() == ["sqlite", "postgres"]
    for store, name, part in parts:
        if store not in bench.stores():
            continue
        row, found = part(bench)
        rows.append([name, *row])
        print(f"{rows[-1]} {found[:10]}", flush=True)
        wrong += [f"{name}: {line}" for line in found]
    columns = [
        "fault",
        "how",
        "jobs",
        "lost or failed",
        "stages repeated",
        "committed twice",
        "other bytes",
        "answers to POST",
        "answers of /readyz in order",
        "downloads",
        "longest answer, s",
        "same processes",
    ]
    words = f"During a fault a scene is submitted every {ASK_SECONDS} s. Every scene that was accepted has to be made."
    if wrong:
        words += "\n\n" + "\n".join(f"- {line}" for line in wrong[:30])
    return Finding(columns, rows, not wrong, words, full=full)


def disturbed(bench, service, digests, how: str, fault) -> tuple:
    """Submits scenes, lets `fault()` happen while they are made and more are asked for, and checks what came of
    all.
    """
    audit.install(service)
    before = [server.pid for server in service.servers]
    ids = [(0, *submit(service.api, 0))]
    service.api.wait(ids[0][2], JOB_SECONDS)
    ids += [(number, *submit(service.api, number)) for number in range(1, SCENES)]
    time.sleep(1.0)
    asking = Asking(service.api, SCENES, ids[0][1])
    asking.start()
    try:
        fault()
        # What comes after it has to be accepted again, by the same processes.
        recovered = accepted_within(asking, 60)
    finally:
        asked = asking.finish()
    ids += asked.accepted
    states = wait_for_all(service.api, [job_id for _, _, job_id in ids])
    wrong = [] if recovered else ["lost: no scene was accepted within 60 s after the fault"]
    for (number, scene_id, job_id), state in zip(ids, states):
        if state not in ("succeeded", "failed", "cancelled"):
            wrong.append(f"lost: scene {number} is still {state}")
        else:
            # Scenes that were submitted during the fault have no undisturbed bundle to be compared with.
            wrong += [
                line
                for line in outcome(service.api, scene_id, job_id, digests.get(number, ""))
                if number in digests or not line.startswith("bytes")
            ]
    wrong += audit.double_commits(service)
    alive = [server.process.poll() is None and server.pid in before for server in service.servers]
    if not all(alive):
        wrong.append("restart: a process ended")
    unclear = [status for status in asked.statuses if status not in (202, *CLEAR)]
    wrong += [f"unclear: a POST was answered with {status or 'nothing'}" for status in unclear]
    if asked.longest_seconds > MAX_ANSWER_SECONDS:
        wrong.append(f"unclear: a POST waited {asked.longest_seconds:.0f} s for its answer")
    counts = tally(wrong)
    answers = ", ".join(f"{status}: {count}" for status, count in sorted(asked.statuses.items()))
    codes = ", ".join(sorted(asked.codes))
    return [
        how,
        len(ids),
        counts["lost"],
        counts["repeated"],
        counts["twice"],
        counts["bytes"],
        answers + (f" ({codes})" if codes else ""),
        changes(asked.ready),
        f"{asked.downloads[200]} of {sum(asked.downloads.values())}",
        f"{asked.longest_seconds:.1f}",
        "yes" if all(alive) else "NO",
    ], wrong


def changes(statuses: list) -> str:
    """The statuses in order, each as often as it came in a row."""
    return ", ".join(f"{status}: {len(list(group))}" for status, group in itertools.groupby(statuses))


def accepted_within(asking, seconds) -> bool:
    had, deadline = len(asking.asked.accepted), time.monotonic() + seconds
    while time.monotonic() < deadline:
        if len(asking.asked.accepted) > had:
            return True
        time.sleep(0.1)
    return False


def calm(bench, store) -> dict:
    with bench.service(store, f"calm-{store}", settings=SMALL) as service:
        return undisturbed(service, range(SCENES))


def postgres_restarts(bench) -> tuple:
    digests = calm(bench, "postgres")
    with bench.service("postgres", "restarts", settings=SMALL | SHORT_LEASE, workers_wanted=2) as service:

        def fault():
            for _ in range(2):
                bench.postgres.restart("fast", pause_seconds=3)
                time.sleep(5)

        return disturbed(bench, service, digests, "stopped (fast), 3 s, started; twice", fault)


def postgres_crashes(bench) -> tuple:
    digests = calm(bench, "postgres")
    with bench.service("postgres", "crashes", settings=SMALL | SHORT_LEASE, workers_wanted=2) as service:

        def fault():
            for _ in range(2):
                bench.postgres.restart("immediate")
                time.sleep(5)

        return disturbed(bench, service, digests, "stopped (immediate), recovers from its log; twice", fault)


def s3_gone(bench) -> tuple:
    digests = calm(bench, "postgres")
    seconds = bench.given.outage_seconds
    with Proxy(bench.s3.port) as proxy:
        url = f"http://127.0.0.1:{proxy.port}"
        settings = SMALL | SHORT_LEASE | {"store.s3.endpoint": url}
        with bench.service("postgres", "s3gone", settings=settings, workers_wanted=2) as service:

            def fault():
                proxy.refuse()
                time.sleep(seconds / 2)
                proxy.release()
                proxy.hold()
                time.sleep(seconds / 2)
                proxy.release()

            return disturbed(
                bench, service, digests, "half of it connections are refused, half of it nothing answers", fault
            )


def network_cut(bench) -> tuple:
    """The workers are in a network namespace of their own; the link to the database is taken down."""
    digests = calm(bench, "postgres")
    with Network() as network:
        how = f"{network.how}; {bench.given.outage_seconds} s"
        with network.between(bench.postgres.port) as database, network.between(bench.s3.port) as s3:
            settings = SMALL | SHORT_LEASE
            with bench.service(
                "postgres",
                "cut",
                settings=settings,
                workers_wanted=2,
                within=network.within(),
                database_at=database.address,
                s3_url=f"http://{s3.address}",
            ) as service:

                def fault():
                    database.cut()
                    time.sleep(bench.given.outage_seconds)
                    database.mend()

                return disturbed(bench, service, digests, how, fault)


def disk_full(bench) -> tuple:
    """The data directory is on a small disk that is filled to the last byte and freed again."""
    digests = calm(bench, "sqlite")
    place = bench.folder / "small-disk"
    with small_disk(place) as how, bench.service("sqlite", "full", settings=SMALL | SHORT_LEASE, data=place / "data") as service:

        def fault():
            filler = fill(place)
            time.sleep(bench.given.outage_seconds / 2)
            filler.unlink()

        return disturbed(bench, service, digests, how, fault)


def postgres_disk_full(bench) -> tuple:
    """As above with the data of PostgreSQL; it is started again where it gave up."""
    digests = calm(bench, "postgres")
    place = bench.folder / "small-disk-of-postgres"
    options = {"max_wal_size": "64MB", "min_wal_size": "32MB"}
    with small_disk(place, 256) as how, Postgres(bench.given.target_dir, options=options, folder=place) as postgres:
        settings = SMALL | SHORT_LEASE
        with bench.service("postgres", "dbfull", settings=settings, workers_wanted=2, postgres=postgres) as service:

            def fault():
                filler = fill(place)
                time.sleep(bench.given.outage_seconds / 2)
                filler.unlink()
                if not postgres.is_running():
                    postgres.start()

            return disturbed(bench, service, digests, how, fault)


def fill(place):
    """A file that takes all the space there is."""
    filler = place / "filler"
    try:
        with open(filler, "wb", buffering=0) as file:
            while True:
                file.write(bytes(1 << 12))
    except OSError:
        return filler


class small_disk:
    """A tmpfs where mounting is allowed."""

    def __init__(self, place, size_mb=SMALL_DISK_MB):
        self.place, self.size_mb = place, size_mb

    def __enter__(self) -> str:
        self.place.mkdir(parents=True, exist_ok=True)
        command = ["mount", "-t", "tmpfs", "-o", f"size={self.size_mb}m", "tmpfs", str(self.place)]
        if subprocess.run(command, capture_output=True).returncode != 0:
            raise Problem("a small disk cannot be mounted here (tmpfs); run this part as root, or leave it out")
        return f"tmpfs of {self.size_mb} MB, filled to the last byte"

    def __exit__(self, *_):
        subprocess.run(["umount", "--lazy", str(self.place)], capture_output=True)
        shutil.rmtree(self.place, ignore_errors=True)
