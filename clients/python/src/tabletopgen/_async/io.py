"""What differs between the clients but for `await`: this file of `_async`, and the same of `_sync`."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

Lock = asyncio.Lock


async def sleep(secs: float) -> None:
    await asyncio.sleep(secs)


async def blocking_call(function: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
    """The result of a function that waits for files or processes."""
    return await asyncio.to_thread(function, *arguments, **named)


def at_once(function: Callable[[], Awaitable[T]]) -> T | None:
    """The result where it can be had without waiting for other tasks; here it cannot."""
    return None
