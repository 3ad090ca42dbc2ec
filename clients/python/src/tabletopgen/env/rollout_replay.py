"""An episode of a rollout run again by its recorded actions, without the policy."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

from tabletopgen.env.folder_digest import digest_of_folder
from tabletopgen.env.rollout_episode import DONE, POLICY_ERROR, end_of, environment_of
from tabletopgen.env.rollout_folder import RolloutFolder
from tabletopgen.env.rollout_request import Request
from tabletopgen.env.scene_env import SceneEnv
from tabletopgen.env.vectors import Vector


def replay(rollout: str | Path, episode: int, environment: str | Path | None = None) -> dict[str, Any]:
    """Compares an episode with its repetition from the same start: whether it succeeds, its number of steps, how it
    ends, and the positions of all joints in its last state, to the bit. `equal` says whether all are equal.

    `environment` is the folder of the episode's environment where it lies elsewhere now, with the same files."""
    folder = RolloutFolder(rollout)
    request, record = Request.of_document(folder.document()), record_of(folder, episode)
    actions, final_qpos = folder.actions(episode)
    place = request.environments.index(record["environment"])
    where = str(environment or request.folders[place])
    if digest_of_folder(Path(where)) != request.digests[place]:
        raise ValueError(
            f"{where} has not the files that episode {episode} of {folder.folder} was run with; name the folder with"
            " them by --environment"
        )
    # Images move nothing.
    alone = replace(request, folders=(where,), images=False)
    with closing(environment_of(alone, 0)) as env:
        again = repeated(env, record, actions)
        own = {name: record[name] for name in again}
        qpos = env.simulation.data.qpos
        is_same = qpos.tobytes() == final_qpos.tobytes()
        apart = float(abs(qpos - final_qpos).max()) if qpos.shape == final_qpos.shape else None
    return {
        "episode": episode,
        "equal": own == again and is_same,
        "recorded": own,
        "replayed": again,
        "final_positions_equal": is_same,
        "largest_difference": apart,
    }


def record_of(folder: RolloutFolder, episode: int) -> dict[str, Any]:
    """The record of a finished episode."""
    records = folder.records()
    for record in records:
        if record["episode"] == episode:
            return record
    raise ValueError(
        f"{folder.folder} has no finished episode {episode}; it has {len(records)} of {folder.document()['episodes']}, which count from 0"
    )


def repeated(env: SceneEnv, record: dict[str, Any], actions: Vector) -> dict[str, Any]:
    """Success, end and steps of recorded actions."""
    env.reset(seed=record["seed"], options={"start": record["start"]})
    reason, steps = POLICY_ERROR, 0
    for action in actions:
        _, _, is_done, is_cut, info = env.step(action)
        steps += 1
        if end := end_of(is_done, is_cut, info):
            reason = end
            break
    return {"success": reason == DONE, "reason": reason, "steps": steps}
