"""A program that runs beside other work; its words are shown in one piece when it is waited for."""

import subprocess
import sys
import tempfile
from pathlib import Path

from tabletopgen_checks.problem import Problem


class Beside:
    """At most one program; `stop` is safe whatever became of it."""

    def __init__(self):
        self.process, self.words, self.command = None, None, []

    def start(self, command: list, folder: Path):
        self.command = [str(part) for part in command]
        self.words = tempfile.TemporaryFile()  # noqa: SIM115 (`finish` reads it)
        self.process = subprocess.Popen(
            self.command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=self.words,
            stderr=subprocess.STDOUT,
        )

    def finish(self):
        """Waits, shows what it printed, and raises a `Problem` where it failed."""
        if self.process is None:
            raise Problem("the program beside was not started")
        code = self.process.wait()
        self.words.seek(0)
        sys.stdout.write(self.words.read().decode("utf-8", "replace"))
        sys.stdout.flush()
        if code != 0:
            raise Problem(f"`{' '.join(self.command)}` ended with exit code {code}; see above")

    def stop(self):
        """Ends it where it still runs: by SIGINT, which Python programs clean up at."""
        if self.process is not None and self.process.poll() is None:
            self.process.send_signal(2)
            try:
                self.process.wait(30)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
