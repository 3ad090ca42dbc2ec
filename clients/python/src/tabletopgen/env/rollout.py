"""Rollouts: a policy acts in environments for many episodes, and what differs between them is counted.

    from tabletopgen.env.rollout import rollout

    found = rollout(["out/mug_env"], "lerobot:out/act/pretrained_model", "out/rollout", episodes=100, workers=4)
    found["overall"]    # {"successes": 61, "episodes": 100, "rate": 0.61, "wilson_95": [0.512, 0.700]}
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from tabletopgen.env.folder import EnvironmentFolder
from tabletopgen.env.rollout_folder import RolloutFolder
from tabletopgen.env.rollout_order import episodes
from tabletopgen.env.rollout_report import markdown, summary
from tabletopgen.env.rollout_request import Request
from tabletopgen.env.rollout_workers import records_of

SUMMARY, TABLES = "summary.json", "summary.md"


def rollout(
    environments: Sequence[str | Path],
    policy: str,
    out: str | Path,
    *,
    workers: int = 1,
    finished: Callable[[Mapping[str, Any]], None] | None = None,
    **asked: Any,
) -> dict[str, Any]:
    """Runs episodes of a policy in environments, and returns the content of `summary.json`.

    `environments` are folders that `prepare` wrote, `policy` one of the kinds in `policies.py`, `out` the folder of the
    rollout. A rollout that was stopped goes on where it was; one that was asked for in other words is refused.
    `workers` processes share the episodes, which are the same for each number of them. `finished` is called with the
    record of each episode. `asked` are the options of `Request.of`."""
    if workers < 1:
        raise ValueError(f"{workers} workers run nothing; give 1 or more")
    request, folder = Request.of(environments, policy, **asked), RolloutFolder(out)
    with folder.held(request.document()):
        done = {record["episode"] for record in folder.records()}
        waiting = [episode for episode in episodes(starts_of(request), request.episodes, request.seed) if episode.number not in done]
        try:
            for record in records_of(request, folder.folder, waiting, workers):
                folder.append(record)
                if finished is not None:
                    finished(record)
        finally:
            found = summarized(folder, request)
    return found


def starts_of(request: Request) -> list[int]:
    """Numbers of starts of the environments."""
    return [len(EnvironmentFolder.read(folder).starts) for folder in request.folders]


def summarized(folder: RolloutFolder, request: Request) -> dict[str, Any]:
    """Writes both summaries of the finished episodes, and returns the first."""
    found = summary(folder.records(), request.episodes)
    folder.write(SUMMARY, (json.dumps(found, indent=1) + "\n").encode())
    folder.write(TABLES, markdown(found, request.document()).encode())
    return found
