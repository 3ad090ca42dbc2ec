"""`kill -9` while jobs of all kinds run: nothing is lost, and nothing that was finished is computed again.

Rounds of work of all six kinds are ordered over HTTP. Each kill is aimed at a running job of the kind that has most
kills left, and comes at a random moment of the time that jobs of this kind take, within ten seconds; whatever else the
process held dies with it. On SQLite the process is the whole server; on PostgreSQL it is one of two workers, and
requests are answered by another process. A new process takes its place at once. Where all rounds have ended before all
kills were made, they are ordered again on fresh data.
"""

import os
import random
import statistics
import time
from collections import Counter, defaultdict
from dataclasses import dataclass, field
from typing import NamedTuple

from tabletopgen_checks.bars.reliability import audit
from tabletopgen_checks.bars.reliability.kills import KILLS_OF_A_JOB, SETTINGS, share
from tabletopgen_checks.bars.reliability.orders import Round, differences
from tabletopgen_checks.bars.reliability.part import Finding
from tabletopgen_checks.bars.reliability.scenes import SHORT_LEASE_SECONDS, complaints, side_by_side, tally
from tabletopgen_checks.problem import Problem

KINDS = {
    "generate": "building scenes",
    "execute_task": "executing tasks",
    "record_attempt": "recording attempts",
    "assemble_recording": "assembling recordings",
    "freeze_dataset": "freezing datasets",
    "verify_dataset": "verifying datasets",
}
PROMISED, MIN_HITS, SEED = 100, 5, 1
ROUNDS = 2
WORKERS = {"sqlite": 1, "postgres": 2}
APART_SECONDS = (0.3, 2.0)
# Where jobs take longer than this, as beside other programs, most kills come before their end.
LATEST_SECONDS = 10.0
PAUSE_SECONDS = 0.05
PATIENCE_SECONDS = 1800
# Jobs that are worked on, and the database user of the process that claimed each.
HELD = """SELECT jobs.id, jobs.kind, jobs.owner, (SELECT by_user FROM worked
    WHERE worked.job_id = jobs.id AND what = 'claimed' ORDER BY worked.id DESC LIMIT 1) FROM jobs WHERE state = 'running'"""


class HeldJob(NamedTuple):
    """A job that a process works on."""

    job_id: str
    kind: str
    owner: str
    user: str


@dataclass
class Tally:
    """What came of the kills of one store."""

    kills: int = 0
    hits: Counter = field(default_factory=Counter)
    # Deaths of one job at most.
    deaths: int = 0
    ended: int = 0
    wrong: list = field(default_factory=list)


class Aims:
    """Which job each kill is aimed at, and when it comes."""

    def __init__(self, wanted: int, seconds: dict, seed: int):
        """`seconds` are the usual durations of jobs by kind."""
        self.left = Counter({kind: share(wanted, len(KINDS), k) for k, kind in enumerate(KINDS)})
        self.seconds, self.draw, self.aimed = seconds, random.Random(seed), Counter()

    def any(self) -> bool:
        return self.left.total() > 0

    def target(self, held: list) -> "HeldJob | None":
        """A job of the kind with most kills left that was not aimed at too often."""
        fair = [job for job in held if self.left[job.kind] > 0 and self.aimed[job.job_id] < KILLS_OF_A_JOB]
        highest = max((self.left[job.kind] for job in fair), default=0)
        return self.draw.choice([job for job in fair if self.left[job.kind] == highest]) if fair else None

    def delay_seconds(self, kind: str) -> float:
        return self.draw.uniform(0.0, min(self.seconds.get(kind, 0.0), LATEST_SECONDS))

    def pause_seconds(self) -> float:
        return self.draw.uniform(*APART_SECONDS)

    def take(self, target: HeldJob):
        self.left[target.kind] -= 1
        self.aimed[target.job_id] += 1


def measure(bench) -> Finding:
    # Of other programs: nothing of this part runs yet.
    load = os.getloadavg()[0]
    rows, stores, all_hit, kills, wrong, deaths = [], bench.stores(), True, 0, [], []
    # Side by side: on PostgreSQL much of the time passes waiting for leases.
    wanted = [share(bench.given.kind_kills, len(stores), k) for k in range(len(stores))]
    tallies = side_by_side(lambda pair: kills_of(bench, *pair), zip(stores, wanted), len(stores))
    for store, found in zip(stores, tallies):
        counts = tally(found.wrong)
        rows.append([store, found.kills, *(found.hits[kind] for kind in KINDS), found.ended, *counts.values()])
        print(f"{store}: {rows[-1]} {found.wrong[:10]}", flush=True)
        kills, wrong, deaths = kills + found.kills, wrong + found.wrong, [*deaths, found.deaths]
        all_hit &= all(found.hits[kind] >= MIN_HITS for kind in KINDS)
    columns = [
        "store",
        "kills",
        *KINDS.values(),
        "jobs ended",
        "lost or failed",
        "computed again",
        "committed twice",
        "other bytes",
    ]
    words = (
        "Below each kind stands how many kills hit a process that was working on such a job; a kill may hit "
        "several kinds. "
        "Compared with an undisturbed run of the same program are bundles, answers of executions, all files of "
        "recordings, and digest, archive and verification of datasets. Triggers in the database note every claim and "
        "every end of a job; what was claimed after it had been done is computed again. `worker.max_deaths` has its "
        "default of 12 deaths without progress, after which a job fails if it was alone; of all deaths no job met more than "
        f"{max(deaths, default=0)}. On PostgreSQL leases last {SHORT_LEASE_SECONDS} s. The load of the machine "
        f"at the start, from other programs, was {load:.1f}."
    )
    if wrong:
        words += "\n\n" + "\n".join(f"- {line}" for line in wrong[:20])
    full = kills >= PROMISED and all_hit and len(stores) == 2
    return Finding(columns, rows, not wrong, words, full=full)


def kills_of(bench, store: str, wanted: int) -> Tally:
    calm, seconds = undisturbed(bench, store)
    usual = ", ".join(f"{kind} {value:.2f}" for kind, value in seconds.items())
    print(f"{store}, seconds of jobs: {usual}", flush=True)
    aims, found = Aims(wanted, seconds, bench.given.kind_seed), Tally()
    while aims.any():
        before = found.kills
        disturbed(bench, store, calm, aims, found)
        if found.kills == before:
            raise Problem(f"no kill was made while all rounds were worked on; left are {dict(aims.left)}")
    return found


def undisturbed(bench, store: str) -> tuple:
    """Results of all rounds while nothing happens, and the usual seconds of jobs by kind."""
    with bench.service(store, f"kinds-{store}-calm", settings=SETTINGS, workers_wanted=WORKERS[store]) as service:
        audit.install(service)
        rounds = [Round(number) for number in range(ROUNDS)]
        work_through(service, rounds, lambda: None)
        calm = results_of(service, rounds)
        if missing := [name for one in rounds for name in one.expected() if name not in calm]:
            raise Problem(f"these were not made undisturbed: {', '.join(missing)}\n{service.api.words()}")
        return calm, usual_seconds(audit.work(service))


def disturbed(bench, store: str, calm: dict, aims: Aims, found: Tally):
    """All rounds on fresh data, and kills until all have ended."""
    with bench.service(store, f"kinds-{store}", settings=SETTINGS, workers_wanted=WORKERS[store]) as service:
        audit.install(service)
        killer = Killer(service, aims)
        rounds = [Round(number) for number in range(ROUNDS)]
        work_through(service, rounds, killer.step)
        rows = audit.work(service)
        found.kills += len(killer.killed)
        found.hits += hits_among(rows, killer.killed)
        found.deaths = max([found.deaths, *Counter(row.job_id for row in rows if row.what == "orphaned").values()])
        found.ended += sum(row.what == "done" for row in rows)
        wrong = differences(calm, results_of(service, rounds)) + unfinished(service) + audit.repeated_among(rows)
        wrong += audit.double_commits(service)
        for one in rounds:
            if one.recording:
                wrong += recording_complaints(recording_events(service.api, one.recording))
        for (job_id,) in service.rows("SELECT id FROM jobs WHERE state = 'succeeded'"):
            wrong += complaints(service.api.events_after(job_id))
        found.wrong += [f"{line} ({service.name})" for line in wrong]


def work_through(service, rounds: list, between):
    """Orders the rounds, each as soon as the scenes of the one before are there, until all work has ended."""
    deadline = time.monotonic() + PATIENCE_SECONDS
    while not all(one.is_over for one in rounds):
        for before, one in zip([None, *rounds], rounds):
            if before is None or before.is_begun:
                one.step(service.api)
        if time.monotonic() > deadline:
            # What is missing is found when results are compared.
            return
        watched_until = time.monotonic() + 4 * PAUSE_SECONDS
        while time.monotonic() < watched_until:
            between()
            time.sleep(PAUSE_SECONDS)


class Killer:
    """Kills the process that works on what the next kill is aimed at."""

    def __init__(self, service, aims: Aims):
        self.service, self.aims = service, aims
        # Owners of jobs: the names that the killed processes had in the queue.
        self.killed: list[str] = []
        self.target: HeldJob | None = None
        self.due = 0.0

    def step(self):
        """Aims, or kills when the time has come and the job still runs."""
        if not self.aims.any() or time.monotonic() < self.due:
            return
        if self.target is None:
            self.target = self.aims.target(self.held())
            if self.target is not None:
                self.due = time.monotonic() + self.aims.delay_seconds(self.target.kind)
            return
        target, self.target = self.target, None
        victim = self.process_of(target)
        if victim is None or target not in self.held():
            return
        victim.kill()
        self.killed.append(target.owner)
        self.aims.take(target)
        self.service.replace(victim).wait_until_ready()
        self.due = time.monotonic() + self.aims.pause_seconds()
        print(f"{self.service.store}: killed at {target.kind}, {self.aims.left.total()} left", flush=True)

    def held(self) -> list:
        """Jobs of processes that live."""
        jobs = [HeldJob(*row) for row in self.service.rows(HELD)]
        return [job for job in jobs if job.owner not in self.killed and self.process_of(job) is not None]

    def process_of(self, job: HeldJob):
        users = self.service.users
        return next((server for server in self.service.workers if (users[server] or "") == job.user), None)


def results_of(service, rounds: list) -> dict:
    return {name: parts for one in rounds for name, parts in one.results(service.api).items()}


def usual_seconds(rows: list) -> dict:
    """Median time from claim to end of jobs, by kind."""
    claimed, seconds = {}, defaultdict(list)
    for row in rows:
        if row.what == "claimed":
            claimed[row.job_id] = row.at_ms
        elif row.what == "done":
            seconds[row.kind].append((row.at_ms - claimed[row.job_id]) / 1000)
    return {kind: statistics.median(values) for kind, values in seconds.items()}


def hits_among(rows: list, killed: list) -> Counter:
    """How many of these processes had a job of each kind when they died."""
    hit = {(row.kind, row.owner) for row in rows if row.what == "orphaned" and row.owner in killed}
    return Counter(kind for kind, _ in hit)


def unfinished(service) -> list:
    rows = service.rows("SELECT kind, state, failure_code FROM jobs WHERE state <> 'succeeded' ORDER BY id")
    return [f"lost: a job {kind} is {state} ({code})" for kind, state, code in rows]


def recording_events(api, recording: str) -> list:
    events, after = [], 0
    while page := api.json("GET", f"/episodes/{recording}/events?after={after}&page_size=200")["events"]:
        events += page
        after = page[-1]["seq"]
    return events


def recording_complaints(events: list) -> list:
    """What the events of a recording show that must not be: an attempt that was made twice or lost, several ends."""
    kinds = Counter(event["kind"] for event in events)
    attempts = Counter(event["data"]["number"] for event in events if event["kind"] == "attempt")
    wrong = [f"repeated: attempt {number} was made {times} times" for number, times in attempts.items() if times > 1]
    wrong += [f"lost: the recording has an event {kind}" for kind in ("attempt_lost", "restarted") if kinds[kind]]
    if not kinds["finished"]:
        wrong.append("lost: the recording has no end")
    elif kinds["finished"] > 1:
        wrong.append(f"twice: the recording finished {kinds['finished']} times")
    return wrong
