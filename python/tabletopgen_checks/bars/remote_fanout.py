"""Two scenes of twelve objects at the same time, from models that take two seconds a call: how long, against the
longest chain of calls of one.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.remote_fanout [--target-dir target]

A scene waits for fourteen calls one after the other: describe, draw, recognize, measure, stacking, two calls of the
segmenter, then a redrawn object, its mesh, two checks of how that stands, the view from above, the check of that, and
the boxes on it. Objects are redrawn and made side by side. The chain is those fourteen calls and the computation of one
scene alone, which is measured with models that answer at once.
"""

import shutil
import time
from pathlib import Path

from tabletopgen_checks.bars.page import arguments, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.service.mock_vendors import MockVendors
from tabletopgen_checks.service.server import Server

DEPENDS_ON = (
    "crates/models/http_client", "crates/models/remote", "src/pipeline", "src/pipeline.rs", "src/worker",
    "src/worker.rs",
)
TEXT, SEED, OBJECTS = "a dinner table with four plates, four forks and four glasses", 11, 12
CALLS_IN_A_ROW, LATENCY_MS, JOBS = 14, 2000, 2
JOB_SECONDS, MAX_RATIO = 1200, 3.0


def main() -> bool:
    given = arguments(__doc__, program="")
    if given.program:
        given.binary = Path(given.program)
    folder = given.work / "remote_fanout"
    alone, calls = made(given.binary, folder, 0, 1)
    together, _ = made(given.binary, folder, LATENCY_MS, JOBS)
    chain = alone + CALLS_IN_A_ROW * LATENCY_MS / 1000
    ratio = together / chain
    columns = ["computation of one, s", "calls of one", "its chain, s", f"{JOBS} at the same time, s", "of the chain"]
    body = (
        f"{OBJECTS} objects, {CALLS_IN_A_ROW} calls in a row of {LATENCY_MS / 1000:.0f} s; at most {MAX_RATIO:.0f} times the chain is "
        f"promised.\n\n" + table(columns, [[f"{alone:.1f}", calls, f"{chain:.1f}", f"{together:.1f}", f"{ratio:.2f}"]])
    )
    body += f"\n\nScene (seeds {SEED} and on): {TEXT}"
    if given.program:
        print(body)
    else:
        write("remote_fanout", "Models are asked side by side", body, DEPENDS_ON)
    return ratio < MAX_RATIO


def made(binary: Path, folder: Path, latency_ms: int, jobs: int) -> tuple:
    """Seconds until so many scenes are made at the same time, and the calls of one."""
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "data").mkdir(parents=True)
    with MockVendors(binary, latency_ms) as providers:
        with Server(binary, folder / "data", folder / "log", arguments=providers.settings()) as server:
            began = time.monotonic()
            # The words differ, so that nothing is found that another made.
            scenes = [server.submit_text(TEXT + "." * (k + 1), SEED + k) for k in range(jobs)]
            for scene in scenes:
                job = server.wait(scene["job"]["id"], JOB_SECONDS)
                if job["state"] != "succeeded":
                    raise Problem(f"a scene was not made: {job.get('failure')}\n{server.words()}")
            took = time.monotonic() - began
            shown = server.json("GET", f"/scenes/{scenes[0]['id']}")
    return took, len(shown["spending"]["calls"])


if __name__ == "__main__":
    run(main)
