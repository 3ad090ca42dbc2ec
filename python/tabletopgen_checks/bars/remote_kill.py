"""`kill -9` at random moments while every question of a scene goes to remote models: nothing is billed twice but what
no client can decide, and each case of that stands in the ledger as `outcome_unknown`.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.remote_kill [--target-dir target] [--kills 200]

`tabletopgen-lab mock-vendors` answers for all remote models and keeps a bill. One scene is made undisturbed; then the
same scene again and again, each on fresh data, its server killed at a random moment and started again until the job is
done. What the undisturbed scene was billed, every scene is billed once; what it is billed beyond that has to stand in
its books.
"""

import random
import shutil
import time
from collections import Counter
from pathlib import Path

from tabletopgen_checks.bars.page import arguments, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.service.mock_vendors import MockVendors
from tabletopgen_checks.service.server import Server

DEPENDS_ON = (
    "crates/models/http_client", "crates/models/remote", "crates/server/store", "src/pipeline.rs",
    "src/pipeline/checkpoint", "src/pipeline/checkpoint.rs", "src/pipeline/ledger.rs", "src/worker", "src/worker.rs",
)
TEXT, SEED = "an apple on a plate and a fork beside it", 7
JOB_SECONDS = 600
# As slow as a quick model, so that most kills fall into calls.
LATENCY_MS = 150
MAX_KILLS_PER_SCENE = 4


def main() -> bool:
    given = arguments(__doc__, kills=200, draw=1, program="")
    if given.program:
        given.binary = Path(given.program)
    folder = given.work / "remote_kill"
    draw = random.Random(given.draw)
    with MockVendors(given.binary, LATENCY_MS) as providers:
        undisturbed = Scene(given.binary, folder, providers)
        took = undisturbed.made(lambda seconds: None)
        once = Counter(undisturbed.billed)
        print(f"undisturbed: {took:.1f} s, billed for {sum(once.values())} questions", flush=True)
        kills, twice, unknown, faults, scenes = 0, 0, 0, [], 0
        while kills < given.kills:
            planned = min(draw.randint(1, MAX_KILLS_PER_SCENE), given.kills - kills)
            # What was done before a kill is found after it, so less time is left.
            moments = [draw.uniform(0.0, took / (1 + k)) for k in range(planned)]
            scene = Scene(given.binary, folder, providers)
            seconds = scene.made(lambda _, moments=moments: moments.pop(0) if moments else None)
            if not scene.kills:
                took = min(took, seconds)
            kills, scenes = kills + scene.kills, scenes + 1
            repeated = sum((Counter(scene.billed) - once).values())
            twice, unknown = twice + repeated, unknown + scene.unknown
            faults += scene.faults(repeated, once, undisturbed.bundle)
            print(f"{kills} kills, {scenes} scenes: {twice} billed twice, {unknown} unknown, {faults}", flush=True)
    body = (
        f"{kills} kills at random moments of {scenes} scenes, {took:.1f} s each undisturbed; every answer takes {LATENCY_MS} ms "
        f"at least.\n\n"
        + table(
            ["billed twice", "of unknown outcome in the ledger", "billed twice and not in the ledger", "scenes that differ"],
            [[twice, unknown, sum("not in" in fault for fault in faults), sum("bundle" in fault for fault in faults)]],
        )
        + f"\n\nA question is of unknown outcome when its server died between the reservation and the answer's being kept; "
        f"`providers.on_unknown = resend`.\n\nScene (seed {SEED}): {TEXT}"
    )
    if given.kills >= 200:
        write("remote_kill", "Killed while models are asked", body, DEPENDS_ON)
    else:
        print(body)
    return not faults


class Scene:
    """The scene, made once on fresh data."""

    def __init__(self, binary: Path, folder: Path, providers: MockVendors):
        shutil.rmtree(folder, ignore_errors=True)
        (folder / "data").mkdir(parents=True)
        self.server = Server(binary, folder / "data", folder / "log", arguments=providers.settings())
        self.providers, self.kills, self.before = providers, 0, len(providers.bill())

    def made(self, next_kill) -> float:
        """Makes it; `next_kill` says after how many seconds the server dies next, None = not any more."""
        began, ids = time.monotonic(), None
        while True:
            with self.server as server:
                if ids is None:
                    scene = server.submit_text(TEXT, SEED)
                    ids = scene["id"], scene["job"]["id"]
                pause = next_kill(time.monotonic() - began)
                if pause is not None and not ended_within(server, ids[1], pause):
                    server.kill()
                    self.kills += 1
                    continue
                job = server.wait(ids[1], JOB_SECONDS)
                shown = server.json("GET", f"/scenes/{ids[0]}")
                status, _, self.bundle = server.request("GET", f"/scenes/{ids[0]}/bundle", timeout=120)
                break
        if job["state"] != "succeeded" or status != 200:
            raise Problem(f"the scene was not made: {job['state']}, {job.get('failure')}\n{self.server.words()}")
        calls = shown["spending"]["calls"]
        self.answered = sum(call["outcome"] == "answered" for call in calls)
        self.unknown = sum(call["outcome"] == "outcome_unknown" for call in calls)
        self.open = sum(call["outcome"] is None for call in calls)
        self.billed = self.providers.bill()[self.before :]
        return time.monotonic() - began

    def faults(self, repeated: int, once: Counter, bundle: bytes) -> list:
        """What was promised and did not hold."""
        faults = []
        if repeated > self.unknown:
            faults.append(f"{repeated} billed twice, {repeated - self.unknown} of them not in the ledger as unknown")
        if len(self.billed) > self.answered + self.unknown:
            faults.append(f"{len(self.billed)} billed, {self.answered + self.unknown} in the ledger: some are not in it")
        if set(once) - set(self.billed):
            faults.append("something was never asked")
        if self.open:
            faults.append(f"{self.open} calls were left open")
        if self.bundle != bundle:
            faults.append("another bundle")
        return faults


def ended_within(server: Server, job_id: str, seconds: float) -> bool:
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if server.json("GET", f"/jobs/{job_id}")["state"] in ("succeeded", "failed", "cancelled"):
            return True
        time.sleep(min(0.05, max(0.0, deadline - time.monotonic())))
    return False


if __name__ == "__main__":
    run(main)
