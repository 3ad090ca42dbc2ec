"""An expected failure of a program of this package."""

from pathlib import Path


class Problem(Exception):
    """What went wrong and what to do about it, in words for the person who started the program."""


def end_of_log(log: Path, program: str, lines: int = 15) -> str:
    """The last lines of a program's log, for the words of a problem."""
    try:
        last = log.read_text(encoding="utf-8", errors="replace").splitlines()[-lines:]
    except OSError:
        last = []
    return "\n".join([f"the last lines of {program}:"] + [f"  {line}" for line in last or ["(nothing)"]])
