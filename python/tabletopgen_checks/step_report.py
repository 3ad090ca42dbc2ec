"""Steps that run in their order until one fails, with the seconds of each."""

import re
import shutil
import time
from collections.abc import Callable, Iterable
from pathlib import Path

from tabletopgen_checks.problem import Problem

# A compiler that found the disk full removes what it had begun to write, so that some is free again.
FULL_BYTES = 10**9
# Of cargo 7, the others of the environments of Python.
NEEDED_GB = 12
PASSED = re.compile(r"^== (.+?): (.*) \((\d+) s\)$", re.MULTILINE)


class StepReport:
    """What the steps of a run came to, for its last lines."""

    def __init__(self, folder: Path):
        """`folder` is where the steps write."""
        self.folder = folder
        self.began = time.monotonic()
        self.sentences: list[str] = []
        self.seconds: dict[str, float] = {}
        self.is_failed = False

    def run(self, steps: dict[str, Callable[[], str]], names: Iterable[str]):
        """Runs the named steps until one raises a `Problem` or is interrupted. Each gives a sentence."""
        for name in names:
            print(f"== {name}", flush=True)
            began = time.monotonic()
            try:
                sentence = steps[name]()
            except Problem as problem:
                self.is_failed = True
                sentence = "FAILED"
                print(f"== {name} FAILED: {problem}", flush=True)
                self.tell_full_disk()
            except KeyboardInterrupt:
                self.is_failed = True
                sentence = "interrupted"
            self.seconds[name] = time.monotonic() - began
            self.sentences.append(f"{name}: {sentence}")
            if self.is_failed:
                return
            print(f"== {name}: {sentence} ({self.seconds[name]:.0f} s)", flush=True)

    def tell_full_disk(self):
        """Names the cause of many errors that do not name it."""
        free_bytes = shutil.disk_usage(self.folder).free if self.folder.exists() else FULL_BYTES
        if free_bytes < FULL_BYTES:
            free_mb = free_bytes // 10**6
            print(f"== the disk of {self.folder} is full, {free_mb} MB are left: all steps take about {NEEDED_GB} GB", flush=True)

    def take_over(self, printed: str):
        """Adds the steps that another run printed."""
        for name, sentence, seconds in PASSED.findall(printed):
            self.sentences.append(f"{name}: {sentence}")
            self.seconds[name] = float(seconds)

    def summarize(self, title: str):
        """Prints the seconds of each step, the longest first, and one line about all."""
        for name, seconds in sorted(self.seconds.items(), key=lambda step: -step[1]):
            print(f"   {seconds:6.0f} s  {name}")
        verdict = "FAILED" if self.is_failed else "all passed"
        minutes = (time.monotonic() - self.began) / 60
        print(f"{title}: {verdict} in {minutes:.1f} min ({'; '.join(self.sentences)})")
