"""The command `suite`: its arguments, and what it prints."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from tabletopgen.env.interrupts import raise_lost
from tabletopgen.env.suite_build import build
from tabletopgen.env.suite_leaderboard import leaderboard
from tabletopgen.env.suite_order import DEFAULT
from tabletopgen.env.suite_result import run_suite


def add_suite(commands: Any, add_running: Callable[[Any], None]) -> None:
    """The arguments of `suite`. `add_running` adds those of a rollout."""
    steps = commands.add_parser("suite", help="a benchmark of many environments").add_subparsers(dest="step", required=True)
    built = steps.add_parser("build", help="make every combination of scenes, tasks and variations, and freeze them")
    built.add_argument("order", metavar="file", help=f"a JSON document; or {DEFAULT}, the suite of the package")
    built.add_argument("--out", type=Path, required=True, help="a folder; the same command continues what is in it")
    ran = steps.add_parser("run", help="run a policy once from each start")
    ran.add_argument("suite", type=Path, help="the folder of --out of `suite build`")
    ran.add_argument("--name", help="what a leaderboard lists; the words of --policy if absent")
    ran.add_argument("--trained-on", required=True, metavar="TEXT", help="data that the policy was trained on; nothing, if none")
    add_running(ran)
    ranked = steps.add_parser("leaderboard", help="order results")
    ranked.add_argument("suite", type=Path)
    ranked.add_argument("results", type=Path, nargs="+", metavar="result", help="folders of --out of `suite run`, or their result.json")
    ranked.add_argument("--out", type=Path, required=True, help="a file of JSON; a page of Markdown is written beside it")


def suite(step: str, **given: Any) -> None:
    """Carries out a step, and prints what it came to."""
    run: dict[str, Callable[..., Mapping[str, Any]]] = {"build": built, "run": ran, "leaderboard": ranked}
    print(json.dumps(run[step](**given)))


def built(order: str, out: Path) -> dict[str, Any]:
    made = build(order, out, finished=print_combination)
    left_out = len(made.document["left_out"])
    return {**made.identity, "environments": len(made.environments), "starts": made.starts, "left_out": left_out, "out": str(out)}


def print_combination(record: Mapping[str, Any]) -> None:
    """Prints what a combination came to. An interrupt that was lost ends the work here."""
    names = ("name", "reason", "wall_s")
    print(json.dumps({name: record[name] for name in names if record[name] is not None}), flush=True)
    raise_lost()


def ran(suite: Path, out: Path, **given: Any) -> dict[str, Any]:
    found = run_suite(suite, out=out, **given)
    return {**found["suite"], "policy": found["policy"]["name"], **found["overall"], "out": str(out)}


def ranked(suite: Path, results: list[Path], out: Path) -> dict[str, Any]:
    rows = leaderboard(suite, results, out)["results"]
    shown = [{"rank": row["rank"], "policy": row["policy"]["name"], "rate": row["overall"]["rate"]} for row in rows]
    return {"results": shown, "out": str(out)}
