"""The leaderboard of a suite: results in order of success, each with all that it states."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tabletopgen.env.record_folder import write_whole
from tabletopgen.env.rollout_folder import REQUEST, RolloutFolder
from tabletopgen.env.rollout_report import cell
from tabletopgen.env.suite import Suite, listed
from tabletopgen.env.suite_result import FORMAT as OF_RESULT
from tabletopgen.env.suite_result import RESULT, counts, result_of
from tabletopgen.env.suite_statement import STATED, member, missing

FORMAT = "tabletopgen-suite-leaderboard/1"
# Members of a result that no table of counts has.
NAMED = ("policy.given_as", "policy.digest", "policy.trained_on", "conditions.", "reasons", "versions.")

Row = Mapping[str, Any]


def leaderboard(folder: str | Path, results: Sequence[str | Path], out: str | Path) -> dict[str, Any]:
    """Orders results in a suite, and returns the content of the file `out`, beside which a page with the suffix `.md`
    is written.

    A result is a file, or the folder of --out of `suite run`. Where records of the run lie beside it, it is counted
    again from them. Refused are results in another suite, and those that are unfinished, incomplete or miscounted."""
    suite, out = Suite.read(folder), Path(out)
    if out.suffix == ".md":
        raise ValueError(f"{out} is the name of the page; name the file of JSON, such as leaderboard.json")
    found = [read(suite, Path(path)) for path in results]
    names = [one["policy"]["name"] for one in found]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"several results are named {', '.join(twice)}; give the same `suite run` another --name, which repeats nothing")
    rows = ranked(found)
    document = {"format": FORMAT, "suite": suite.identity, "results": rows}
    write_whole(out, (json.dumps(document, indent=1, allow_nan=False) + "\n").encode())
    write_whole(out.with_suffix(".md"), markdown(suite, rows).encode())
    return document


def read(suite: Suite, path: Path) -> dict[str, Any]:
    """A result that may be compared."""
    file = path / RESULT if path.is_dir() else path
    if not file.is_file():
        raise ValueError(f"{file} does not exist: the run is not finished; give the same `suite run` to finish it")
    result = document_in(file)
    if lacking := missing(result):
        raise ValueError(f"{file} does not state {', '.join(lacking)}; run `suite run` again, or add what is known")
    if result["suite"] != suite.identity:
        other = said(result["suite"])
        raise ValueError(f"{file} is a result in the suite {other}, not in {said(suite.identity)}; run the policy in this one")
    refuse_unfinished(suite, file, result["outcomes"])
    refuse_others(file, result, counts(suite, result["outcomes"]), "its outcomes")
    if (file.parent / REQUEST).is_file():
        again = result_of(suite, RolloutFolder(file.parent), result["policy"]["name"], result["policy"]["trained_on"])
        again["versions"] = {**result["versions"], **again["versions"]}
        refuse_others(file, result, again, "the records beside it")
    return result


def document_in(file: Path) -> dict[str, Any]:
    """The content of a file of `suite run`."""
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except ValueError:
        found = None
    if not isinstance(found, dict) or found.get("format") != OF_RESULT:
        raise ValueError(f"{file} is no result of `suite run`, which has the format {OF_RESULT!r}; name its folder of --out")
    return found


def refuse_unfinished(suite: Suite, file: Path, outcomes: Any) -> None:
    """Refuses a result without an outcome from each start of the suite."""
    starts = {name: one["starts"] for name, one in suite.environments.items()}
    found = {name: len(reasons) for name, reasons in outcomes.items()} if isinstance(outcomes, Mapping) else {}
    if found != starts:
        others = [name for name in {**starts, **found} if starts.get(name) != found.get(name)]
        raise ValueError(f"{file} has not one outcome from each start of {listed(others)}; give the same `suite run` to finish it")


def refuse_others(file: Path, result: Row, again: Row, source: str) -> None:
    """Refuses a result that states something else than what it is counted from."""
    if others := [name for name in again if result.get(name) != again[name]]:
        raise ValueError(f"{file} does not agree with {source} in {listed(others)}; give the same `suite run` again, which writes it anew")


def ranked(results: Sequence[Row]) -> list[dict[str, Any]]:
    """Results in order of their rates. A rank is one more than the number of results whose interval is wholly above,
    and results whose intervals overlap are tied."""
    rows = []
    for one in sorted(results, key=lambda one: (-one["overall"]["rate"], one["policy"]["name"])):
        low, high = one["overall"]["wilson_95"]
        above = [other for other in results if other["overall"]["wilson_95"][0] > high]
        below = [other for other in results if other["overall"]["wilson_95"][1] < low]
        tied = [other["policy"]["name"] for other in results if other is not one and other not in above and other not in below]
        rows.append({"rank": len(above) + 1, "tied_with": sorted(tied), **one})
    return rows


def markdown(suite: Suite, rows: Sequence[Row]) -> str:
    """The page of a leaderboard."""
    lines = [f"# Leaderboard of {said(suite.identity)}", ""]
    lines += [f"{suite.starts} episodes of each policy, one from each start of {len(suite.environments)} environments."]
    lines += ["Intervals are those of Wilson for 95 %. Policies whose intervals overlap are tied: this suite does not separate"]
    lines += ["them. A rank is one more than the number of policies whose interval is wholly above.", ""]
    lines += ["| rank | policy | successes | of | rate | 95 % | tied with |", "| ---: | --- | ---: | ---: | ---: | --- | --- |"]
    for row in rows:
        overall, tied = row["overall"], ", ".join(row["tied_with"]) or "none"
        low, high = overall["wilson_95"]
        shares = f"{overall['successes']} | {overall['episodes']} | {overall['rate']:.3f} | {low:.3f} to {high:.3f}"
        lines.append(f"| {row['rank']} | {cell(row['policy']['name'])} | {shares} | {cell(tied)} |")
    for name in ("task", "scene", "variation"):
        lines += group_table(name, rows)
    lines += ["", "## What each result states", "", "`README.md` of the suite explains the members."]
    for row in rows:
        lines += ["", f"### {row['policy']['name']}", "", "| member | content |", "| --- | --- |"]
        lines += [f"| `{path}` | {cell(shown(member(row, path)))} |" for path in STATED if path.startswith(NAMED)]
    return "\n".join(lines) + "\n"


def group_table(name: str, rows: Sequence[Row]) -> list[str]:
    """Successes of each policy by what divides the episodes, with intervals."""
    values = [one["value"] for one in rows[0]["by"][name]]
    lines = ["", f"## By {name}", "", f"| policy | {' | '.join(values)} |", f"| --- |{' --- |' * len(values)}"]
    for row in rows:
        parts = [(one["successes"], one["episodes"], *one["wilson_95"]) for one in row["by"][name]]
        shares = [f"{successes} of {episodes} ({low:.2f} to {high:.2f})" for successes, episodes, low, high in parts]
        lines.append(f"| {cell(row['policy']['name'])} | {' | '.join(shares)} |")
    return lines


def shown(value: Any) -> str:
    """A value as a page has it."""
    return value if isinstance(value, str) else json.dumps(value)


def said(identity: Mapping[str, str]) -> str:
    """A suite in words."""
    return f"{identity['name']} {identity['version']} ({identity['digest'][:12]})"
