"""Processes that run the episodes of a rollout side by side.

Each has environments and a policy of its own, and gets one episode at a time through a pipe. When the process that
started them is gone, be it killed, they end by themselves.
"""

from __future__ import annotations

import multiprocessing
import signal
import traceback
from collections.abc import Iterator, Sequence
from contextlib import closing, suppress
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

from tabletopgen.env.rollout_episode import Episodes
from tabletopgen.env.rollout_folder import RolloutFolder
from tabletopgen.env.rollout_order import Episode
from tabletopgen.env.rollout_request import Request
from tabletopgen.errors import TabletopgenError

# What a process imports may have threads, which a forked one would not have.
CONTEXT = multiprocessing.get_context("spawn")
# Time for a process to end by itself.
END_S = 15.0


class WorkerFailedError(TabletopgenError):
    """A process that could not run an episode."""


def records_of(request: Request, folder: Path, waiting: Sequence[Episode], workers: int) -> Iterator[dict[str, Any]]:
    """Records of episodes as they finish."""
    if workers == 1:
        yield from records_here(request, folder, waiting)
    elif waiting:
        yield from records_of_processes(request, folder, list(waiting), min(workers, len(waiting)))


def records_here(request: Request, folder: Path, waiting: Sequence[Episode]) -> Iterator[dict[str, Any]]:
    """The same in this process."""
    own = Episodes(request, RolloutFolder(folder))
    try:
        for episode in waiting:
            if (record := own.run(episode)) is not None:
                yield record
    finally:
        own.close()


def records_of_processes(request: Request, folder: Path, waiting: list[Episode], workers: int) -> Iterator[dict[str, Any]]:
    pipes: dict[Connection, Any] = {}
    running: dict[Connection, Episode] = {}
    waiting.reverse()
    try:
        for _ in range(workers):
            own, other = CONTEXT.Pipe()
            process = CONTEXT.Process(target=work, args=(other, request, folder))
            process.start()
            # Only the process has its end, so that the pipe ends with it.
            other.close()
            pipes[own] = process
            running[own] = waiting.pop()
            own.send(running[own])
        while running:
            for pipe in wait(list(running)):
                assert isinstance(pipe, Connection)
                yield received(pipe, running.pop(pipe), pipes[pipe])
                if waiting:
                    running[pipe] = waiting.pop()
                    pipe.send(running[pipe])
    finally:
        end(pipes)


def received(pipe: Connection, episode: Episode, process: Any) -> dict[str, Any]:
    """The record that a process sends."""
    try:
        record, error = pipe.recv()
    except (EOFError, OSError) as gone:
        process.join(END_S)
        raise WorkerFailedError(
            f"the process of episode {episode.number} ended with exit code {process.exitcode}; finished episodes are kept. Use fewer"
            " --workers if memory was short, and give the same command to continue"
        ) from gone
    if record is None:
        raise WorkerFailedError(f"episode {episode.number} could not be run: {error}")
    found: dict[str, Any] = record
    return found


def end(pipes: dict[Connection, Any]) -> None:
    """Ends processes: those that wait end by themselves, others are stopped."""
    for pipe in pipes:
        pipe.close()
    for process in pipes.values():
        process.join(END_S)
        if process.is_alive():
            process.terminate()
            process.join()


def work(pipe: Connection, request: Request, folder: Path) -> None:
    """What a process does: it runs the episodes that it gets until there are no more."""
    # Ctrl-C reaches all processes of a terminal; the one that started this one decides.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # In an episode nothing is sent: a pipe with something to read has lost its other end.
    own = Episodes(request, RolloutFolder(folder), is_wanted=lambda: not pipe.poll())
    with suppress(EOFError, ConnectionError), closing(own):
        while (answer := answered(own, pipe.recv())) is not None:
            pipe.send(answer)


def answered(own: Episodes, episode: Episode) -> tuple[dict[str, Any] | None, str | None] | None:
    """The record of an episode, or why there is none; `None` if it is no longer wanted."""
    try:
        record = own.run(episode)
    except (TabletopgenError, ValueError) as error:
        return None, str(error)
    except Exception:
        return None, traceback.format_exc()
    return (record, None) if record is not None else None
