"""One combination of a suite: a task in a scene with a variation, as an environment, or left out with a reason."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Mapping
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

from tabletopgen.env.counterexample_axes import OF_CAMERAS, base_light, camera_of, operations_of
from tabletopgen.env.counterexample_scene import NOT_MADE, QUARANTINED, USAGE
from tabletopgen.env.folder import EnvironmentFolder, write_environment_like
from tabletopgen.env.policies import RECORDED
from tabletopgen.env.preparation import TASK_FAILED, complaint, completed, prepare
from tabletopgen.env.recorded_dataset import RECORDS, RecordedDataset
from tabletopgen.env.rollout import rollout
from tabletopgen.env.rollout_factors import MOVED
from tabletopgen.env.suite import ENVIRONMENTS, EPISODES, SCENES
from tabletopgen.env.suite_order import Combination, SuiteOrder, levels_of
from tabletopgen.env.task_check import StartCheck, TaskCheck

# What is being made. It goes when the suite is frozen.
PARTS = "parts"


class LeftOutError(Exception):
    """A combination that the program or its recorded actions do not do."""


class CombinationMaker:
    """Makes combinations in the folder of a suite, which has the scenes."""

    def __init__(self, order: SuiteOrder, folder: Path):
        self.order, self.folder = order, folder

    def record(self, number: int, one: Combination) -> dict[str, Any]:
        """Makes one, and returns its record, with the reason if it is left out."""
        began_s = time.perf_counter()
        place = self.folder / PARTS / one.name
        kept = {name: self.folder / name / one.name for name in (ENVIRONMENTS, EPISODES)}
        # A stop may have left a part of it.
        for path in (place, *kept.values()):
            shutil.rmtree(path, ignore_errors=True)
        place.mkdir(parents=True)
        reason = None
        try:
            self._make(one, place)
        except LeftOutError as error:
            reason = str(error)
        else:
            for name, path in kept.items():
                path.parent.mkdir(exist_ok=True)
                (place / name).rename(path)
        shutil.rmtree(place)
        took = {"wall_s": round(time.perf_counter() - began_s, 3)}
        return {"combination": number, "name": one.name, **vars(one), "reason": reason, **took}

    def _make(self, one: Combination, place: Path) -> None:
        """Writes the environment and the numbers of its episodes into a place."""
        bundle, task = self.folder / SCENES / one.scene, place / "task" / "task_0001.json"
        done("tasks", "--bundle", bundle, "--text", one.instruction, "--robot", self.order.robot, "--out", task.parent)
        change = levels_of(self.order.variations[one.variation].change)
        target = json.loads(task.read_text(encoding="utf-8"))["goal"][0][MOVED]
        if operations := operations_of(change, target, base_light(bundle)):
            words = ["--operations", json.dumps(operations), "--seed", self.order.seed, "--out", place / "bundle"]
            done("edit", "--bundle", bundle, *words)
            bundle = place / "bundle"
        verdict = json.loads((bundle / "report.json").read_text(encoding="utf-8"))["verdict"]
        if verdict != "pass":
            raise LeftOutError(f"the certificate of the scene says {verdict}")
        self._record_episodes(one, bundle, task, place)
        dataset = RecordedDataset(place / EPISODES)
        files = prepare(place / ENVIRONMENTS, bundle, task, self.order.robot, dataset=dataset.folder)
        if any(name in change for name in OF_CAMERAS):
            files = replace(files, folder=files.folder.rename(place / "usual_cameras"))
            files = write_environment_like(place / ENVIRONMENTS, bundle, files, dataset, camera_of(change))
        refuse_broken(files)
        refuse_undone(files, place)

    def _record_episodes(self, one: Combination, bundle: Path, task: Path, place: Path) -> None:
        """Records the episodes, and keeps their numbers without images."""
        drawn: object = self.order.variations[one.variation].randomize
        if isinstance(drawn, dict):
            amplitudes = place / "amplitudes.json"
            amplitudes.write_text(json.dumps(drawn), encoding="utf-8")
            drawn = amplitudes
        order = self.order
        words: list[object] = ["--task", task, "--robot", order.robot, "--seed", order.seed, "--count", order.starts]
        words += ["--randomize", drawn, "--cameras", ",".join(order.cameras) or "none", "--size", order.size_px, "--fps", order.fps]
        done("episodes", "--bundle", bundle, *words, "--format", "parquet-png", "--out", place / "recorded")
        recorded = RecordedDataset(place / "recorded").folder
        for path in (recorded / RECORDS, *recorded.glob("episodes/*/*.parquet")):
            target = place / EPISODES / path.relative_to(recorded)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)


def done(*words: object) -> None:
    """Runs a command of the program. What it refuses or fails at is left out."""
    found = completed(*words, "--quiet", accepted=(0, USAGE, QUARANTINED, NOT_MADE, TASK_FAILED))
    if found.returncode != 0:
        raise LeftOutError(complaint(found) or f"`tabletopgen {words[0]}` ended with exit code {found.returncode}")


def refuse_broken(files: EnvironmentFolder) -> None:
    """Refuses a task that a script finds broken from a start."""
    with closing(TaskCheck(files)) as check:
        for found in check.starts(range(len(files.starts))):
            if not found.is_sound:
                raise LeftOutError(f"the task is broken from start {found.start}: {fault(found)}")


def fault(found: StartCheck) -> str:
    """Why a start is not sound."""
    if found.is_done_at_start:
        return "its goal is reached before anything moves"
    if not found.is_reached:
        return f"its goal is reached nowhere, by {json.dumps(found.missed)}"
    if not found.is_undone:
        return "its goal stays reached when all is put back"
    return f"an object moves by {1000 * found.moved_m:.0f} mm by itself"


def refuse_undone(files: EnvironmentFolder, place: Path) -> None:
    """Refuses a task that the recorded actions do not do from all starts."""
    found: Mapping[str, Any] = rollout([files.folder], f"{RECORDED}{place / EPISODES}", place / "repeated", images=False)
    successes, starts = found["overall"]["successes"], len(files.starts)
    if successes < starts:
        raise LeftOutError(f"the recorded actions do the task from {successes} of {starts} starts: ends are {json.dumps(found['reasons'])}")
