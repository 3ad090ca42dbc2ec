"""Other programs: run to their end for their output, for their processor time, or in the background."""

import argparse
import os
import subprocess
import sys
import tempfile
import threading
from dataclasses import dataclass
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import ROOT


def output_of(*command, environment=None, folder=None) -> str:
    """The standard output of a command that has to succeed."""
    words = [str(part) for part in command]
    done = subprocess.run(words, capture_output=True, text=True, stdin=subprocess.DEVNULL, env=environment, cwd=folder)
    if done.returncode != 0:
        shown = f"{done.stdout[-1000:]}{done.stderr[-2000:]}".strip()
        raise Problem(f"`{' '.join(words)}` ended with exit code {done.returncode}:\n{shown}")
    return done.stdout


def run_beside(description: str, environment) -> int:
    """The program `python -m ... [--target-dir DIR] COMMAND...`: runs the command with the variables that the context
    manager `environment(target)` yields, and gives its exit code.
    """
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--target-dir", type=Path, default=ROOT / "target")
    parser.add_argument("command", nargs=argparse.REMAINDER)
    given = parser.parse_args()
    if not given.command:
        parser.error("name a command, such as: cargo test -p tabletopgen-store")
    try:
        with environment(given.target_dir.resolve()) as variables:
            return subprocess.run(given.command, env=os.environ | variables).returncode
    except Problem as problem:
        print(problem, file=sys.stderr)
        return 1


@dataclass
class Run:
    exit_code: int
    stdout: str
    stderr: str
    # Of this process and what it waited for, whatever else runs at the same time.
    cpu_s: float


def run_alone(command: list, seconds: float, environment: dict) -> Run:
    with tempfile.TemporaryFile() as stdout, tempfile.TemporaryFile() as stderr:
        process = subprocess.Popen(command, stdout=stdout, stderr=stderr, env=environment)
        late = threading.Event()
        timer = threading.Timer(seconds, lambda: (late.set(), process.kill()))
        timer.start()
        try:
            _, status, usage = os.wait4(process.pid, 0)
        except BaseException:
            process.kill()
            raise
        finally:
            timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        if late.is_set():
            raise subprocess.TimeoutExpired(command, seconds)
        return Run(process.returncode, whole(stdout), whole(stderr), usage.ru_utime + usage.ru_stime)


def whole(file) -> str:
    """The text of a temporary file from its beginning."""
    file.seek(0)
    return file.read().decode("utf-8", "replace")


class BackgroundProgram:
    """A program beside other work, whose output is shown in one piece when it is waited for. `stop` is safe in any
    state."""

    def __init__(self):
        self.process: subprocess.Popen | None = None
        self.output, self.command = None, []

    def start(self, command: list, folder: Path):
        self.command = [str(part) for part in command]
        self.output = tempfile.TemporaryFile()  # noqa: SIM115 (`finish` reads it)
        self.process = subprocess.Popen(
            self.command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=self.output,
            stderr=subprocess.STDOUT,
        )

    def finish(self) -> str:
        """Waits, shows what it printed and gives it, and raises a `Problem` where it failed."""
        if self.process is None:
            raise Problem("the program in the background was not started")
        code = self.process.wait()
        printed = whole(self.output)
        sys.stdout.write(printed)
        sys.stdout.flush()
        if code != 0:
            raise Problem(f"`{' '.join(self.command)}` ended with exit code {code}; see above")
        return printed

    def has_failed(self) -> bool:
        return self.process is not None and self.process.poll() not in (None, 0)

    def is_running(self) -> bool:
        return self.process is not None and self.process.poll() is None

    def stop(self):
        """Ends it where it still runs: by SIGINT, which Python programs clean up at."""
        if self.process is not None and self.is_running():
            self.process.send_signal(2)
            try:
                self.process.wait(30)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
