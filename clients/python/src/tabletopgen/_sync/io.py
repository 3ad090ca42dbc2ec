"""What differs between the clients but for `await`: this file of `_sync`, and the same of `_async`."""

import threading
import time
from collections.abc import Callable
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

Lock = threading.Lock


def sleep(secs: float) -> None:
    time.sleep(secs)


def blocking_call(function: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
    """The result of a function that waits for files or processes."""
    return function(*arguments, **named)


def at_once(function: Callable[[], T]) -> T | None:
    """The result where it can be had without waiting for other tasks; here it always can."""
    return function()
