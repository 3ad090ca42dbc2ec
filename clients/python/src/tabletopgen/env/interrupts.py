"""Ctrl-C during long work, which ends at a place from which it goes on.

Python loses a `KeyboardInterrupt` that comes while an object is finalized, and after one that comes out of text that it
executes (as the definition of a named tuple) it ends by the signal, whatever was handled. Here an interrupt has a class
of its own, which the second does not concern, and one that was lost is raised again where the work asks.
"""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_received = threading.Event()


class Interrupt(KeyboardInterrupt):
    """Ctrl-C."""


@contextmanager
def interruptible() -> Iterator[None]:
    """Raises `Interrupt` for Ctrl-C.

    Nothing changes where the process ignores Ctrl-C, as in the background of a shell, or handles it in its own way."""
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    _received.clear()
    reported = sys.unraisablehook

    def report(lost: Any) -> None:
        if not isinstance(lost.exc_value, Interrupt):
            reported(lost)

    signal.signal(signal.SIGINT, _receive)
    sys.unraisablehook = report
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        sys.unraisablehook = reported
        _received.clear()


def raise_lost() -> None:
    """Raises an interrupt that was lost."""
    if _received.is_set():
        raise Interrupt


def _receive(number: int, frame: Any) -> None:
    _received.set()
    raise Interrupt
