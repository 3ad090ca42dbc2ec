"""The summary of a rollout: shares of successes with their intervals, overall and by what differs between episodes.

An interval is that of Wilson ("Probable inference, the law of succession, and statistical inference", 1927) for a
probability of which so many successes in so many independent trials are known.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

# Half the width of the central 95 % of the standard normal distribution.
Z_95 = 1.959963984540054
# Numeric factors are divided into so many bins of about equal counts.
BINS = 3
# Names of the groups, and the value of an episode's record that each divides by.
GROUPS: dict[str, Callable[[Mapping[str, Any]], str]] = {
    "environment": lambda record: str(record["environment"]),
    "task": lambda record: str(record["task"]),
    "wording": lambda record: str(record["wording"]),
    "object": lambda record: " + ".join(dict.fromkeys(moved["category"] for moved in record["moved"])),
}

Record = Mapping[str, Any]


def wilson_interval(successes: int, trials: int) -> tuple[float, float]:
    """The 95 % interval of a probability. Without trials it is all from 0 to 1."""
    if not 0 <= successes <= trials:
        raise ValueError(f"{successes} successes in {trials} trials are impossible; give 0 <= successes <= trials")
    if trials == 0:
        return 0.0, 1.0
    share, weight = successes / trials, Z_95**2 / trials
    center = (share + weight / 2) / (1 + weight)
    half = Z_95 / (1 + weight) * math.sqrt(share * (1 - share) / trials + weight / (4 * trials))
    low = 0.0 if successes == 0 else center - half
    high = 1.0 if successes == trials else center + half
    return low, high


def counted(records: Iterable[Record]) -> dict[str, Any]:
    """How many of these episodes succeeded, with the interval."""
    found = [bool(record["success"]) for record in records]
    successes, episodes = sum(found), len(found)
    rate = successes / episodes if episodes else None
    return {"successes": successes, "episodes": episodes, "rate": rate, "wilson_95": list(wilson_interval(successes, episodes))}


def summary(records: Sequence[Record], asked: int) -> dict[str, Any]:
    """The content of `summary.json` for the records of finished episodes, of so many that were asked for."""
    starts = {(record["environment"], record["start"]) for record in records}
    return {
        "asked": asked,
        "overall": counted(records),
        "distinct_starts": len(starts),
        "reasons": dict(sorted(Counter(record["reason"] for record in records).items())),
        "groups": {name: grouped(records, value_of) for name, value_of in GROUPS.items()},
        "factors": factors(records),
    }


def grouped(records: Sequence[Record], value_of: Callable[[Record], str]) -> list[dict[str, Any]]:
    """The count of each value, in the order of the values."""
    parts: dict[str, list[Record]] = {}
    for record in records:
        parts.setdefault(value_of(record), []).append(record)
    return [{"value": value, **counted(parts[value])} for value in sorted(parts)]


def factors(records: Sequence[Record]) -> dict[str, list[dict[str, Any]]]:
    """The counts in bins of each numeric factor that differs between episodes; those without it are left out."""
    names = sorted({name for record in records for name in record["factors"]})
    found = {name: binned([record for record in records if record["factors"].get(name) is not None], name) for name in names}
    return {name: bins for name, bins in found.items() if len(bins) > 1}


def binned(records: Sequence[Record], name: str) -> list[dict[str, Any]]:
    """Counts in bins of about equal numbers of episodes. Episodes with the same value are in the same bin, and a factor
    with few values has a bin for each."""
    parts: dict[int, list[Record]] = {}
    values = sorted(float(record["factors"][name]) for record in records)
    distinct = sorted(set(values))
    edges = distinct if len(distinct) <= BINS else [values[math.ceil(len(values) * k / BINS) - 1] for k in range(1, BINS)]
    for record in records:
        value = float(record["factors"][name])
        parts.setdefault(sum(value > edge for edge in edges), []).append(record)
    return [{**range_of(parts[place], name), **counted(parts[place])} for place in sorted(parts)]


def range_of(records: Sequence[Record], name: str) -> dict[str, float]:
    values = [float(record["factors"][name]) for record in records]
    return {"min": min(values), "max": max(values)}


def markdown(document: Mapping[str, Any], request: Mapping[str, Any]) -> str:
    """The content of `summary.md`."""
    overall = document["overall"]
    finished = f"{overall['episodes']} of {document['asked']} episodes finished"
    lines = [f"# Rollout of `{request['policy']}`", "", f"{said(overall)}, {finished}.", ""]
    lines += ["Intervals are those of Wilson for 95 %. They take episodes as independent."]
    if document["distinct_starts"] < overall["episodes"]:
        lines += [
            f"Only {document['distinct_starts']} starts differ; of a policy that draws nothing by chance, episodes from the same start"
            " are equal, and the intervals are too narrow."
        ]
    if not overall["episodes"]:
        return "\n".join(lines) + "\n"
    lines += ["", "| end of the episode | episodes |", "| --- | ---: |"]
    lines += [f"| {reason} | {count} |" for reason, count in document["reasons"].items()]
    for name, rows in document["groups"].items():
        lines += table(name, [(cell(row["value"]), row) for row in rows])
    for name, rows in document["factors"].items():
        lines += table(name, [(f"{row['min']:.4g} to {row['max']:.4g}", row) for row in rows])
    return "\n".join(lines) + "\n"


def table(name: str, rows: Sequence[tuple[str, Mapping[str, Any]]]) -> list[str]:
    """Lines of a table of Markdown."""
    lines = ["", f"## By {name}", "", f"| {name} | successes | of | rate | 95 % |", "| --- | ---: | ---: | ---: | --- |"]
    for value, row in rows:
        low, high = row["wilson_95"]
        lines.append(f"| {value} | {row['successes']} | {row['episodes']} | {row['rate']:.3f} | {low:.3f} to {high:.3f} |")
    return lines


def said(counts: Mapping[str, Any]) -> str:
    """One count in words."""
    low, high = counts["wilson_95"]
    share = f" ({100 * counts['rate']:.1f} %, 95 % interval {100 * low:.1f} % to {100 * high:.1f} %)" if counts["episodes"] else ""
    return f"{counts['successes']} of {counts['episodes']} episodes succeeded{share}"


def cell(text: str) -> str:
    """Text that divides no table."""
    return text.replace("|", "\\|").replace("\n", " ")
