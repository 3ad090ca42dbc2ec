"""Runs `tabletopgen batch` to its end, with `kill -9` on the way, and watches its memory."""

import random
import signal
import sqlite3
import subprocess
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

from tabletopgen_checks.problem import Problem

WATCH_S = 1.0


@dataclass
class Batch:
    """What happened: seconds of all runs together, resident memory in time, output lines at each kill."""

    folder: Path
    seconds: float = 0.0
    killed_at: list = field(default_factory=list)
    # (share of the requests that are done, MiB) of the run without a kill after it, the longest one.
    memory: list = field(default_factory=list)
    exit_code: int = 0
    said: str = ""


def run(command: list, folder: Path, requests: int, kills: int, seed: int) -> Batch:
    """One batch. Kills come at random shares of the requests, in different runs of the same command."""
    batch, rng = Batch(folder), random.Random(seed)
    at = sorted(rng.sample(range(1, max(2, requests)), min(kills, requests - 1)))
    for limit in [*at, None]:
        started = time.monotonic()
        with open(folder.with_suffix(".log"), "a", encoding="utf-8") as log:
            process = subprocess.Popen(command, stdout=log, stderr=log)
        watch = Watch(process.pid, folder, requests)
        while process.poll() is None:
            time.sleep(0.05)
            if limit is not None and lines(folder) >= limit:
                # Anywhere within a stage, not right after the line was written.
                time.sleep(rng.uniform(0.0, 1.5))
                process.send_signal(signal.SIGKILL)
                process.wait()
                batch.killed_at.append(lines(folder))
        batch.seconds += time.monotonic() - started
        batch.memory += watch.stop()
        print(f"{lines(folder)} of {requests} after {batch.seconds:.0f} s", flush=True)
        batch.exit_code = process.returncode
        if limit is not None and process.returncode != -signal.SIGKILL:
            raise Problem(f"the batch ended by itself before it was killed: exit code {process.returncode}")
    batch.said = folder.with_suffix(".log").read_text(encoding="utf-8", errors="replace")[-2000:]
    return batch


def lines(folder: Path) -> int:
    output = folder / "output.jsonl"
    return output.read_bytes().count(b"\n") if output.is_file() else 0


class Watch:
    """Resident memory of a process, once a second."""

    def __init__(self, pid: int, folder: Path, requests: int):
        self.pid, self.folder, self.requests = pid, folder, requests
        self.samples, self.ended = [], threading.Event()
        self.thread = threading.Thread(target=self.work, daemon=True)
        self.thread.start()

    def work(self):
        while not self.ended.wait(WATCH_S):
            try:
                status = Path(f"/proc/{self.pid}/status").read_text(encoding="ascii")
            except OSError:
                return
            found = [line.split()[1] for line in status.splitlines() if line.startswith("VmRSS")]
            if found:
                self.samples.append((lines(self.folder) / self.requests, int(found[0]) / 1024.0))

    def stop(self) -> list:
        self.ended.set()
        self.thread.join()
        return self.samples


def stage_counts(data_dir: Path) -> tuple:
    """(rows of stages, those begun more than once, jobs, jobs beyond one per scene), of the batch's own database."""
    with sqlite3.connect(f"file:{data_dir / 'tabletopgen.sqlite'}?mode=ro", uri=True) as database:
        rows, again = database.execute("SELECT COUNT(*), SUM(runs > 1) FROM stages").fetchone()
        jobs, scenes = database.execute("SELECT COUNT(*), COUNT(DISTINCT scene_id) FROM jobs").fetchone()
    return rows, again or 0, jobs, jobs - scenes
