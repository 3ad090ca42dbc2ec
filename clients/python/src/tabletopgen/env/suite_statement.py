"""What a result in a suite must state, and the page of a suite that says so."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tabletopgen.env.rollout_report import cell

# Members of a result, with dots between, and what each states.
STATED = {
    "suite.name": "name of the suite",
    "suite.version": "its version",
    "suite.digest": "its digest, which names every byte of its environments",
    "policy.name": "name of the policy, by which it is listed",
    "policy.given_as": "what `--policy` named",
    "policy.digest": "digest of the policy's files; none for `random` and for a server",
    "policy.trained_on": "data that the policy was trained on, and whether starts or episodes of this suite are among them",
    "conditions.seed": "seed of the order of starts, and of what the policy draws by chance",
    "conditions.action_mode": "mode of actions",
    "conditions.chunk": "actions that are carried out of each answer of a server; none where all are",
    "conditions.images": "whether cameras are observed",
    "conditions.object_poses": "whether poses of objects are observed",
    "conditions.max_duration_s": "seconds after which an episode ends; none where those of the task hold",
    "conditions.rename": "observations with other names",
    "episodes": "number of episodes: one from each start",
    "overall": "successes, with the interval of Wilson for 95 %",
    "by.task": "the same for each task",
    "by.scene": "the same for each scene",
    "by.variation": "the same for each variation",
    "by.environment": "the same for each environment",
    "reasons": "how many episodes ended for which reason",
    "outcomes": "the reason of the end from each start of each environment",
    "versions.tabletopgen": "version of the Python package",
    "versions.program": "version of the program, which judges success",
    "versions.program_digest": "digest of the program",
    "versions.mujoco": "version of MuJoCo",
    "versions.gymnasium": "version of Gymnasium",
    "versions.numpy": "version of NumPy",
    "versions.python": "version of Python",
}
# Members that may be null.
NULLABLE = ("policy.digest", "conditions.chunk", "conditions.max_duration_s")
# Stands for a member that is not there.
ABSENT = object()


def member(result: Any, path: str) -> Any:
    """A member by its path, or `ABSENT`."""
    for name in path.split("."):
        if not isinstance(result, Mapping) or name not in result:
            return ABSENT
        result = result[name]
    return result


def missing(result: Any) -> list[str]:
    """Members that a result must state, and does not."""
    return [path for path in STATED if member(result, path) in (ABSENT, "") or (member(result, path) is None and path not in NULLABLE)]


def readme(document: Mapping[str, Any]) -> str:
    """The content of `README.md` of a suite with this `suite.json`."""
    environments, order = document["environments"], document["order"]
    lines = [f"# Suite {document['name']} {document['version']}", ""]
    lines += [f"{len(environments)} environments with {order['starts']} starts each. Digest: `{document['digest']}`.", ""]
    lines += ["```", "python -m tabletopgen.env suite run THIS_FOLDER --policy POLICY --name NAME --trained-on TEXT --out RESULT"]
    lines += ["python -m tabletopgen.env suite leaderboard THIS_FOLDER RESULT [RESULT ...] --out leaderboard.json", "```", ""]
    lines += ["A run takes each start once. The policy `tabletopgen.env.suite_expert:SuiteExpert` repeats the recorded actions of"]
    lines += ["`episodes/`, and shows what can be reached; any other policy acts by its observations and the instruction alone, and"]
    lines += [f"reads no file of this folder. Data to train on can be recorded in `scenes/` with another seed than {order['seed']}:", ""]
    lines += ["```", "tabletopgen episodes --bundle THIS_FOLDER/scenes/SCENE --task INSTRUCTION --seed SEED --count COUNT --out DATASET \\"]
    cameras = ",".join(order["cameras"]) or "none"
    lines += [f"    --robot {order['robot']} --cameras {cameras} --size {order['size_px']} --fps {order['fps']}", "```"]
    lines += ["", "## Environments", "", "| environment | instruction |", "| --- | --- |"]
    lines += [f"| {one['name']} | {cell(one['instruction'])} |" for one in environments]
    if document["left_out"]:
        lines += ["", "Left out, since the program or its recorded actions do not do the task:", ""]
        lines += ["| combination | reason |", "| --- | --- |"]
        lines += [f"| {one['name']} | {cell(one['reason'])} |" for one in document["left_out"]]
    lines += ["", "## What a result must state", ""]
    lines += ["`suite run` writes all of it into `result.json`. The leaderboard refuses a result that lacks any of it.", ""]
    lines += ["| member | content |", "| --- | --- |", *(f"| `{path}` | {text} |" for path, text in STATED.items())]
    return "\n".join(lines) + "\n"
