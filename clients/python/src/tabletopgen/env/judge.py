"""The program's own verdict about a task, in poses that MuJoCo reports.

Predicates are decided by `tabletopgen judge` alone: here is none of them. It compares with where the objects are in
the bundle, so each episode gets a bundle of its own, which has only what the judge reads, with the objects where the
episode starts.
"""

from __future__ import annotations

import copy
import hashlib
import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tabletopgen._local_server import program as installed_program
from tabletopgen.env.start import Start
from tabletopgen.errors import TabletopgenError

SCENE, COMPOSITION, MANIFEST = "scene.json", "composition.json", "manifest.json"
# An absent object is this far from the table, and each is at a place of its own.
AWAY_M, APART_M = 100.0, 10.0


class JudgeError(TabletopgenError):
    """A state about which the program did not decide."""


@dataclass(frozen=True)
class Verdict:
    """What was decided: each predicate of the goal with its measured value and limit, and the objects beside the goal
    that moved farther than the task permits."""

    reached: bool
    predicates: list[dict[str, Any]]
    disturbed: list[dict[str, Any]]


def judged_files(bundle: Path) -> list[str]:
    """Paths in a bundle that the judge reads."""
    scene = json.loads((bundle / SCENE).read_text(encoding="utf-8"))
    return [SCENE, COMPOSITION, *(f"glb/{instance['name']}.glb" for instance in scene["instances"])]


class Judge:
    """Asks the program about one task, which begins where the bundle has the objects until `begin` says otherwise.
    `bundle` is the folder of the scene's bundle, or what `judged_files` names of it, with its manifest."""

    def __init__(self, bundle: Path, task: Mapping[str, Any], program: Path | None = None):
        self._program = program or installed_program()
        self._place = tempfile.TemporaryDirectory(prefix="tabletopgen-judge-")
        self._bundle = Path(self._place.name) / "bundle"
        self._scene = json.loads((bundle / SCENE).read_text(encoding="utf-8"))
        listed = {entry["path"]: entry for entry in json.loads((bundle / MANIFEST).read_text(encoding="utf-8"))["files"]}
        self._files = [listed[path] for path in judged_files(bundle) if path != SCENE]
        for entry in self._files:
            target = self._bundle / entry["path"]
            target.parent.mkdir(parents=True, exist_ok=True)
            link_or_copy(bundle / entry["path"], target)
        (Path(self._place.name) / "task.json").write_text(json.dumps(task), encoding="utf-8")
        self._begins_at: Start | None = None

    def begin(self, start: Start) -> None:
        """The start of the episode that is judged from now on."""
        self._begins_at = start
        (self._bundle / MANIFEST).unlink(missing_ok=True)

    def verdict(self, state: Mapping[str, Any]) -> Verdict:
        """The verdict in a state as `Simulation.state` gives it. Raises `JudgeError` where the program has none."""
        if not (self._bundle / MANIFEST).is_file():
            self._write_scene()
        place = Path(self._place.name)
        (place / "state.json").write_text(json.dumps(state), encoding="utf-8")
        files = ["--bundle", self._bundle, "--task", place / "task.json", "--state", place / "state.json"]
        command = [str(word) for word in (self._program, "judge", *files, "--json")]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        document = json.loads(done.stdout) if done.stdout.startswith("{") else {}
        if "reached" not in document:
            raise JudgeError(f"`{' '.join(command)}` decided nothing: {done.stderr or done.stdout}")
        return Verdict(document["reached"], document["predicates"], document["disturbed"])

    def _write_scene(self) -> None:
        scene = copy.deepcopy(self._scene)
        begins_at = self._begins_at.objects if self._begins_at is not None else {}
        for place, instance in enumerate(scene["instances"]):
            if drawn := begins_at.get(instance["name"]):
                away = {"translation_m": [AWAY_M + APART_M * place, 0.0, 0.0], "rotation_xyzw": [0.0, 0.0, 0.0, 1.0]}
                instance.update(away if drawn.world_from_object is None else drawn.world_from_object)
        written = json.dumps(scene).encode()
        (self._bundle / SCENE).write_bytes(written)
        digest = hashlib.sha256(written).hexdigest()
        entry = {"path": SCENE, "sha256": digest, "size": len(written), "role": "scene", "media_type": "application/json"}
        (self._bundle / MANIFEST).write_text(json.dumps({"files": [entry, *self._files]}), encoding="utf-8")

    def close(self) -> None:
        self._place.cleanup()


def link_or_copy(source: Path, target: Path) -> None:
    try:
        os.link(source, target)
    except OSError:
        shutil.copyfile(source, target)
