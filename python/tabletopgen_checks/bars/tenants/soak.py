"""Two tenants, each alone, and then both while one of them floods the server.

A tenant submits at a steady pace. Each job waits for a vendor and then ends, so that turns at workers are measured and
not the processor. Turns are fair if the other tenant has no more of them than this one while a job of this one waits,
but for the slots that were taken when it came, and if two tenants with a backlog get as many."""

import http.client
import json
import os
import time
from datetime import datetime

from tabletopgen_checks.bars.overload import P99_FACTOR, P99_FLOOR_S
from tabletopgen_checks.bars.reliability.bench import STORES
from tabletopgen_checks.bars.reliability.part import Finding, yes
from tabletopgen_checks.bars.reliability.scenes import SMALL, quantile, request_of, side_by_side
from tabletopgen_checks.bars.tenants import attacks
from tabletopgen_checks.bars.tenants.vendor import ANSWER_SECONDS, RefusingVendor
from tabletopgen_checks.problem import Problem

PROMISED_SECONDS, LEAD_SECONDS = 40, 3
SUBMISSIONS_PER_S = 2
# Enough for the seconds that shares are counted in.
BACKLOG, SHARE_SECONDS = 240, 8
FAIR_SHARE, SHARE_SLACK = 0.5, 0.05
SLOTS = 2
SETTINGS = {"worker.concurrency": str(SLOTS)}


class Tenant:
    """Submits at a steady pace; what it was answered, and its jobs."""

    def __init__(self, client, first_seed: int):
        self.client, self.seed = client, first_seed
        self.seconds, self.jobs, self.refused = [], [], []

    def work(self, seconds: float):
        began = time.monotonic()
        for k in range(int(seconds * SUBMISSIONS_PER_S)):
            time.sleep(max(0.0, began + k / SUBMISSIONS_PER_S - time.monotonic()))
            self.submit()

    def submit(self):
        self.seed += 1
        text, _ = request_of(0)
        body = json.dumps({"text": text, "seed": self.seed}).encode()
        began = time.monotonic()
        connection = http.client.HTTPConnection("127.0.0.1", self.client.port, timeout=60)
        try:
            connection.request("POST", "/scenes", body, {"content-type": "application/json", **self.client.credential()})
            answer = connection.getresponse()
            content = answer.read()
        finally:
            connection.close()
        if answer.status != 202:
            self.refused.append(f"{answer.status} {content[:200]!r}")
            return
        self.seconds.append(time.monotonic() - began)
        self.jobs.append(json.loads(content)["job"]["id"])

    def ended(self) -> tuple:
        """Seconds of each job from its submission to its first turn, and to its end, once all have ended."""
        waits, wholes, deadline = [], [], time.monotonic() + 120
        for job_id in self.jobs:
            while (job := self.client.json("GET", f"/jobs/{job_id}"))["finished_at"] is None:
                if time.monotonic() > deadline:
                    raise Problem(f"job {job_id} did not end: {job['state']}\n{self.client.words()}")
                time.sleep(0.1)
            waits.append(apart_s(job["created_at"], job["started_at"]))
            wholes.append(apart_s(job["created_at"], job["finished_at"]))
        return waits, wholes


def apart_s(first: str, second: str) -> float:
    return (moment(second) - moment(first)).total_seconds()


def moment(text: str) -> datetime:
    return datetime.fromisoformat(text.replace("Z", "+00:00"))


def measure(bench) -> Finding:
    # Of other programs: nothing of this part runs yet.
    rows, words, held, load = [], [], True, os.getloadavg()[0]
    for store in bench.stores():
        with RefusingVendor() as vendor:
            with bench.keyed(store, f"soak-{store}", SMALL | vendor.settings() | SETTINGS) as service:
                found = Comparison(bench, service)
                found.measure(bench.given.soak_seconds)
        rows += [[store, *row] for row in found.rows]
        words.append(f"On {store} the attacks were answered with: {attacks.summary(found.answers)}. {found.words}")
        held &= found.held
    columns = ["store", "who", "meanwhile", "submissions", "refused", "submission p50, ms", "p99, ms", "promised", "turn p99, ms"]
    columns += ["turns ahead", "to the end p99, ms", ""]
    lead = (
        f"{SUBMISSIONS_PER_S} submissions a second, each on a new connection, for {bench.given.soak_seconds} s, beside a single kind of "
        f"attack for half as long; {SLOTS} slots, each job waits {1000 * ANSWER_SECONDS:.0f} ms for a vendor, which refuses. Promised is "
        f"a p99 of the submission within {P99_FACTOR:.0f} times that alone (or {1000 * P99_FLOOR_S:.0f} ms, as short answers scatter on "
        f"two cores), and no more than {SLOTS} turns ahead: those that the other tenant had beyond one's own while one's job waited. The "
        f"other tenant attacks with {attacks.FLOODING_CLIENTS} clients that submit, {attacks.BODIES_PER_S} bodies of "
        f"{attacks.BODY_BYTES >> 20} MiB a second, {attacks.STREAMS} event streams without a reader, and batches of "
        f"{attacks.BATCH_REQUESTS} requests, in processes of this machine that come last for its processor. All limits are the usual "
        f"ones. The load of the machine at the start, from other programs, was {load:.1f}."
    )
    full = bench.given.soak_seconds >= PROMISED_SECONDS and len(bench.stores()) == len(STORES)
    return Finding(columns, rows, held, "\n\n".join([lead, *words]), full=full)


class Comparison:
    """Each tenant alone, one beside the attacks of the other, and both with a backlog."""

    def __init__(self, bench, service):
        self.bench, self.service = bench, service
        self.rows, self.answers, self.words, self.held = [], {}, "", True

    def measure(self, seconds: float):
        victim, hostile = (self.bench.client(self.service, name) for name in ("victim", "hostile"))
        # What is made with the first job stays out of the comparison.
        Tenant(victim, 0).work(2)
        self.steady(hostile, "hostile", "alone", seconds)
        alone = self.steady(victim, "victim", "alone", seconds)
        job = hostile.submit_text(request_of(0)[0], 1)["job"]["id"]
        for names, time_taken in [*(([name], seconds / 2) for name in attacks.ATTACKS), (list(attacks.ATTACKS), seconds)]:
            with attacks.under(names, hostile, time_taken + LEAD_SECONDS, job) as answers:
                time.sleep(LEAD_SECONDS)
                meanwhile = f"the other: {', '.join(names)}" if len(names) == 1 else "the other: all of it"
                self.steady(victim, "victim", meanwhile, time_taken, alone)
            self.answers |= answers
        self.share(victim)

    def steady(self, client, name: str, meanwhile: str, seconds: float, alone=None) -> float:
        """The p99 of submissions, seconds."""
        tenant, began_ms = Tenant(client, 1000 * (1 + len(self.rows))), 1000 * time.time()
        tenant.work(seconds)
        waits, wholes = tenant.ended()
        if not wholes:
            raise Problem(f"all submissions of {name} were refused: {tenant.refused[:3]}")
        p99, turn, whole = quantile(tenant.seconds, 0.99), quantile(waits, 0.99), quantile(wholes, 0.99)
        limits, holds = ("-", "-"), not tenant.refused
        if alone is not None:
            limit, ahead = max(P99_FACTOR * alone, P99_FLOOR_S), self.turns_ahead(name, began_ms)
            limits = f"{1000 * limit:.0f}", str(ahead)
            holds &= p99 <= limit and ahead <= SLOTS
        self.held &= holds
        p50, p99_ms, turn_ms, whole_ms = (f"{1000 * value:.1f}" for value in (quantile(tenant.seconds, 0.5), p99, turn, whole))
        row = [name, meanwhile, len(tenant.seconds), len(tenant.refused), p50, p99_ms, limits[0], turn_ms, limits[1], whole_ms]
        self.rows.append([*row, yes(holds)])
        print(self.rows[-1], tenant.refused[:2], flush=True)
        return p99

    def turns_ahead(self, tenant: str, since_ms: float) -> int:
        """The most turns that another tenant had, beyond those of this one, while a job of this one waited."""
        jobs = self.service.rows("SELECT tenant_id, created_at, started_at FROM jobs WHERE started_at IS NOT NULL")
        times = sorted((int(started), int(created), of == tenant) for of, created, started in jobs)
        excess = 0
        for at, created, is_own in times:
            if is_own and created >= since_ms:
                turns = [own for started, _, own in times if created < started < at]
                excess = max(excess, len(turns) - 2 * sum(turns))
        return excess

    def share(self, victim):
        """How many jobs of each end while both have a backlog: the flood left the hostile tenant one."""
        side_by_side(lambda k: Tenant(victim, 10**6 + k).submit(), range(BACKLOG), 4)
        ended = [self.ended_jobs(name) for name in ("victim", "hostile")]
        time.sleep(SHARE_SECONDS)
        ended = [self.ended_jobs(name) - before for name, before in zip(("victim", "hostile"), ended)]
        share = ended[0] / max(1, sum(ended))
        fair = abs(share - FAIR_SHARE) <= SHARE_SLACK
        self.held &= fair
        self.words = (
            f"With a backlog of both, {ended[0]} jobs of the victim ended and {ended[1]} of the hostile one: {100 * share:.0f} %, "
            f"promised {100 * FAIR_SHARE:.0f} % give or take {100 * SHARE_SLACK:.0f}, {yes(fair)}."
        )
        print(self.words, flush=True)

    def ended_jobs(self, tenant: str) -> int:
        statement = f"SELECT COUNT(*) FROM jobs WHERE tenant_id = '{tenant}' AND state NOT IN ('queued', 'running')"
        return int(self.service.rows(statement)[0][0])
