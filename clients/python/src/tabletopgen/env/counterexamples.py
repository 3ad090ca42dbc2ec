"""Counterexamples of a policy: certified scenes in which it fails, and the smallest changes that make it fail.

    from tabletopgen.env.counterexamples import counterexamples

    found = counterexamples("out/mug_env", "out/desk", "lerobot:out/act/pretrained_model", "out/breaks", scenes=100)
    found["smallest"]["light_intensity"]    # {"scene": 31, "value": 0.52, "holds_at": 0.55, ...}
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from tabletopgen.env.counterexample_axes import Change, axes_named
from tabletopgen.env.counterexample_report import document_of, markdown
from tabletopgen.env.counterexample_scene import FAILS, REFUSED, UNDONE, Base, SceneRunner, run_draws
from tabletopgen.env.counterexample_search import BudgetSpentError, Search
from tabletopgen.env.folder import EnvironmentFolder
from tabletopgen.env.folder_digest import digest_of_folder
from tabletopgen.env.judge import MANIFEST
from tabletopgen.env.record_folder import RecordFolder
from tabletopgen.env.rollout_folder import RolloutFolder
from tabletopgen.env.rollout_request import FREE, Request

FORMAT = "tabletopgen-search/1"
SCENES, DRAWS, DOCUMENT, TEXT = "scenes", "draws", "counterexamples.json", "counterexamples.md"


class SearchFolder(RecordFolder):
    """The folder of a search: `search.json`, `scenes.jsonl`, files of scenes, and the report."""

    work, request, lines, number, free = "search", "search.json", "scenes.jsonl", "scene", (*FREE, "bundle", "scenes")


def counterexamples(
    environment: str | Path,
    scene: str | Path,
    policy: str,
    out: str | Path,
    *,
    scenes: int = 100,
    draws: int = 0,
    randomize: str = "wide",
    vary: Sequence[str] = (),
    episodes: int = 1,
    seed: int = 0,
    finished: Callable[[Mapping[str, Any]], None] | None = None,
    **options: Any,
) -> dict[str, Any]:
    """Searches for changes of a scene that make a policy fail, and returns the content of `counterexamples.json`.

    `environment` is a folder that `prepare` wrote, with the task, the robot and the cameras, and `scene` the bundle
    that is changed. First the policy runs from `draws` new starts, drawn with `randomize` in the scene as it is. Then
    `scenes` scenes are made, the unchanged one first and refused ones among them, with `episodes` of the policy in
    each, which fails where less than half of them succeed. `vary` names the axes that are changed, all if empty.
    `options` are those of `Request.of`. A search that was stopped goes on where it was, also to more scenes than it was
    first asked for. `finished` is called with the record of each scene."""
    base = base_of(environment, scene, policy, episodes, seed, options)
    if scenes < 1 or draws < 0:
        raise ValueError(f"{scenes} scenes and {draws} draws cannot be searched; give one scene or more, and no negative number of draws")
    has_cameras = bool(base.environment.cameras) and options.get("images", True)
    axes, folder = axes_named(vary, has_cameras=has_cameras), SearchFolder(out)
    own = {"format": FORMAT, "bundle": str(base.bundle), "bundle_digest": digest_of_folder(base.bundle), "scenes": scenes}
    own |= {"draws": draws, "randomize": randomize, "vary": [axis.name for axis in axes]}
    document = {**Request.of([environment], policy, episodes=episodes, seed=seed, **options).document(), **own}
    with folder.held(document):
        folder.write(folder.request, (json.dumps(document, indent=1) + "\n").encode())
        try:
            search = Search(axes, journaled(folder, SceneRunner(base, folder.folder / SCENES), scenes, finished), seed)
            if draws:
                run_draws(base, draws, randomize, folder.folder / DRAWS)
            search.run()
        finally:
            found = reported(folder, document)
    return found


def base_of(
    environment: str | Path, scene: str | Path, policy: str, episodes: int, seed: int, options: Mapping[str, Any]
) -> Base:
    """The base of a search, with paths that scenes can name."""
    bundle = Path(scene).resolve()
    if not (bundle / MANIFEST).is_file():
        raise ValueError(f"{bundle} is no folder of a bundle: it has no {MANIFEST}; unpack an archive, or `generate --out` a scene")
    return Base(bundle, EnvironmentFolder.read(environment), policy, options, episodes, seed)


def journaled(
    folder: SearchFolder, runner: SceneRunner, budget: int, finished: Callable[[Mapping[str, Any]], None] | None
) -> Callable[[Change], bool]:
    """Whether the policy fails in the scene of a change: as the folder has it already, or by making the scene."""
    known = {key_of(record["change"]): record for record in folder.records()}

    def fails(change: Change) -> bool:
        if key_of(change) not in known:
            if len(known) >= budget:
                raise BudgetSpentError
            record = runner.record(len(known), change, known.get(key_of({})))
            refuse_base(record)
            folder.append(record)
            known[key_of(change)] = record
            if finished is not None:
                finished(record)
        return bool(known[key_of(change)]["outcome"] == FAILS)

    return fails


def key_of(change: Change) -> str:
    return json.dumps(change, sort_keys=True)


def refuse_base(record: Mapping[str, Any]) -> None:
    """Refuses to search around a scene in which the task cannot be done."""
    if not record["change"] and record["outcome"] in (REFUSED, UNDONE):
        reason = record.get("reason") or "the recorded actions do not do it in this simulation"
        raise ValueError(f"in the scene as it is, the program does not do the task: {reason}; search around another scene")


def reported(folder: SearchFolder, request: Mapping[str, Any]) -> dict[str, Any]:
    """Writes the report of the scenes so far, and returns its content."""
    draws = folder.folder / DRAWS / "rollout"
    drawn = RolloutFolder(draws).records() if draws.is_dir() else []
    found = document_of(request, folder.records(), drawn)
    folder.write(DOCUMENT, (json.dumps(found, indent=1, allow_nan=False) + "\n").encode())
    folder.write(TEXT, markdown(found).encode())
    return found
