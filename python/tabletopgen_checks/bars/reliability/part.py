"""A part of the bar: what it promises, what it measured, and whether that holds."""

from dataclasses import dataclass, field


@dataclass
class Finding:
    """The result of one part: rows of a table, words about how, and whether the promise holds."""

    columns: list
    rows: list
    held: bool
    words: str = ""
    # Whether it was measured with as many cases as the promise names.
    full: bool = True
    # Names of plots in docs/results.
    plots: list = field(default_factory=list)


def yes(held: bool) -> str:
    return "holds" if held else "DOES NOT HOLD"
