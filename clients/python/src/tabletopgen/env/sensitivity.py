"""Sensitivity of a policy: which factors of the starts explain where its rollouts fail.

    from tabletopgen.env.sensitivity import sensitivity

    found = sensitivity(["out/rollout"], "out/sensitivity")
    found["named"]    # ["light_brightness"]
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tabletopgen.env.record_folder import write_whole
from tabletopgen.env.rollout_folder import RolloutFolder
from tabletopgen.env.sensitivity_model import models_of
from tabletopgen.env.sensitivity_plots import plot
from tabletopgen.env.sensitivity_report import document_of, markdown
from tabletopgen.env.sensitivity_splits import ranked
from tabletopgen.env.sensitivity_table import table_of

DOCUMENT, TEXT, PLOTS = "sensitivity.json", "sensitivity.md", "plots"
# Factors with a plot.
PLOTTED = 6


def sensitivity(rollouts: Sequence[str | Path], out: str | Path, *, seed: int = 0) -> dict[str, Any]:
    """Analyzes the finished episodes of one or more rollouts of one policy, and returns the content of
    `sensitivity.json`, which is written to the folder `out` with `sensitivity.md` and plots. Equal rollouts and seeds
    give equal files; earlier ones are written over."""
    out, folders = Path(out), [RolloutFolder(folder) for folder in rollouts]
    requests = [folder.document() for folder in folders]
    refuse_unlike(folders, requests)
    both = zip(folders, requests, strict=True)
    records = [(digest_in(request, record), record) for folder, request in both for record in folder.records()]
    if not records:
        raise ValueError(f"{', '.join(str(folder.folder) for folder in folders)} have no finished episode; run `rollout` first")
    table = table_of([record for _, record in records], [digest for digest, _ in records])
    factors, models = ranked(table, seed), models_of(table, seed)
    found = document_of(table, factors, models, requests[0]["policy"], seed)
    (out / PLOTS).mkdir(parents=True, exist_ok=True)
    for one in factors[:PLOTTED]:
        name = f"{PLOTS}/{one.name}.svg"
        write_whole(out / name, plot(one, table))
        next(row for row in found["factors"] if row["name"] == one.name)["plot"] = name
    write_whole(out / DOCUMENT, (json.dumps(found, indent=1, allow_nan=False) + "\n").encode())
    write_whole(out / TEXT, markdown(found).encode())
    return found


def digest_in(request: Mapping[str, Any], record: Mapping[str, Any]) -> str:
    """The digest of the environment of an episode: the same environment in two rollouts has the same starts."""
    return str(request["digests"][request["environments"].index(record["environment"])])


def refuse_unlike(folders: Sequence[RolloutFolder], requests: Sequence[Mapping[str, Any]]) -> None:
    """Refuses rollouts of different policies, whose failures have no common cause, and those named twice."""
    if not folders:
        raise ValueError("no rollout is named; give the folders of --out of one or more `rollout`s")
    if len({folder.folder.resolve() for folder in folders}) < len(folders):
        raise ValueError(f"a rollout is named twice in {', '.join(str(one.folder) for one in folders)}; name each once")
    first = requests[0]
    for folder, other in zip(folders, requests, strict=True):
        if (other["policy"], other["policy_digest"]) != (first["policy"], first["policy_digest"]):
            raise ValueError(
                f"{folder.folder} is a rollout of {other['policy']!r}, {folders[0].folder} of {first['policy']!r} or other files of it;"
                " analyze policies one by one"
            )
