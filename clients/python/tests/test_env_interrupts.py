"""Interrupts that Python would lose, or that would end it by the signal."""

from __future__ import annotations

import subprocess
import sys

import pytest

WORK = """
import os, signal, sys
from tabletopgen.env.interrupts import interruptible, raise_lost

class Finalized:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        sum(range(1000))

def lost():
    Finalized()
    print("goes on", flush=True)
    raise_lost()

def executed():
    exec("import os, signal\\nos.kill(os.getpid(), signal.SIGINT)\\nsum(range(1000))")

signal.signal(signal.SIGINT, signal.default_int_handler)
try:
    with interruptible():
        {work}()
except KeyboardInterrupt:
    sys.exit(130)
"""


@pytest.mark.parametrize(("work", "shown"), [("lost", "goes on\n"), ("executed", "")])
def test_an_interrupt_ends_the_work_with_its_exit_code(work: str, shown: str) -> None:
    done = subprocess.run([sys.executable, "-c", WORK.format(work=work)], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, shown, "")
