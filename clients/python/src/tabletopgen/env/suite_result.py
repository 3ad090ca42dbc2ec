"""Results in a suite: a policy runs once from each start, and `result.json` states what others need to compare it."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from operator import itemgetter
from pathlib import Path
from typing import Any

from tabletopgen.env.record_folder import write_whole
from tabletopgen.env.rollout import rollout
from tabletopgen.env.rollout_episode import DONE
from tabletopgen.env.rollout_folder import RolloutFolder
from tabletopgen.env.rollout_report import counted, grouped
from tabletopgen.env.suite import ENVIRONMENTS, Suite
from tabletopgen.env.suite_build import program_version
from tabletopgen.env.suite_statement import STATED

FORMAT = "tabletopgen-suite-result/1"
RESULT = "result.json"
GROUPS = ("task", "scene", "variation", "environment")

# The reasons of the ends, from each start of each environment.
Outcomes = Mapping[str, Sequence[str]]


def run_suite(
    folder: str | Path, policy: str, out: str | Path, *, trained_on: str, name: str | None = None, **options: Any
) -> dict[str, Any]:
    """Runs a policy once from each start of a suite whose files are those that were frozen, and returns the content of
    `result.json`, which is written to the folder `out` of the rollout.

    `name` is what a leaderboard lists, the words of `policy` if absent; `trained_on` states data in words. `options`
    are those of `rollout` but for the number of episodes. A run that was stopped goes on where it was."""
    if not trained_on.strip():
        raise ValueError("state what the policy was trained on, such as nothing, or names and digests of datasets")
    suite = Suite.read(folder)
    suite.refuse_changed()
    rollout([suite.folder / ENVIRONMENTS / one for one in suite.environments], policy, out, **options)
    found = result_of(suite, RolloutFolder(out), name or policy, trained_on)
    found["versions"] |= program_version()
    write_whole(Path(out) / RESULT, (json.dumps(found, indent=1, allow_nan=False) + "\n").encode())
    return found


def result_of(suite: Suite, folder: RolloutFolder, name: str, trained_on: str) -> dict[str, Any]:
    """The result that the records of a finished rollout make, but for the version of the program."""
    asked = folder.document()
    if asked["digests"] != [one["digest"] for one in suite.environments.values()]:
        raise ValueError(f"{folder.folder} is a rollout in other environments than those of {suite.folder}; run the suite again")
    conditions = [path.removeprefix("conditions.") for path in STATED if path.startswith("conditions.")]
    return {
        "format": FORMAT,
        "suite": suite.identity,
        "policy": {"name": name, "given_as": asked["policy"], "digest": asked["policy_digest"], "trained_on": trained_on},
        "conditions": {key: asked[key] for key in conditions},
        **counts(suite, outcomes_of(suite, folder)),
        "versions": {key: asked[key] for key in ("tabletopgen", "mujoco", "gymnasium", "numpy", "python")},
    }


def outcomes_of(suite: Suite, folder: RolloutFolder) -> dict[str, list[str]]:
    """The outcomes in the records of a rollout, which has to be finished."""
    reasons = {(record["environment"], record["start"]): record["reason"] for record in folder.records()}
    if len(reasons) < suite.starts:
        raise ValueError(f"{folder.folder} has {len(reasons)} of {suite.starts} episodes; give the same `suite run` to finish it")
    return {name: [reasons[name, start] for start in range(one["starts"])] for name, one in suite.environments.items()}


def counts(suite: Suite, outcomes: Outcomes) -> dict[str, Any]:
    """The members of a result that outcomes decide."""
    records = [
        {**suite.environments[name], "environment": name, "reason": reason, "success": reason == DONE}
        for name, reasons in outcomes.items()
        for reason in reasons
    ]
    return {
        "episodes": len(records),
        "overall": counted(records),
        "by": {name: grouped(records, itemgetter(name)) for name in GROUPS},
        "reasons": dict(sorted(Counter(str(record["reason"]) for record in records).items())),
        "outcomes": {name: list(reasons) for name, reasons in outcomes.items()},
    }
