"""One scene of a search: an edited bundle that is certified, an episode that shows that the task can be done there, and
episodes of the policy from the same start.

    scenes/NNNN/bundle         what `tabletopgen edit` made
    scenes/NNNN/episodes       what `tabletopgen episodes` recorded, without randomization
    scenes/NNNN/environment    the environment of both
    scenes/NNNN/rollout        episodes of the policy
    scenes/NNNN/recorded       the recorded actions repeated, where the policy failed
"""

from __future__ import annotations

import json
import math
import shutil
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tabletopgen.env.counterexample_axes import Change, base_light, camera_of, distance_of, operations_of
from tabletopgen.env.folder import EnvironmentFolder, write_environment_like
from tabletopgen.env.policies import RECORDED
from tabletopgen.env.preparation import TASK_FAILED, complaint, completed, run
from tabletopgen.env.recorded_dataset import RecordedDataset
from tabletopgen.env.rollout import rollout
from tabletopgen.env.rollout_factors import MOVED
from tabletopgen.env.rollout_folder import RolloutFolder

# Exit codes of the program: what was asked for will not do, a scene that is not certified, one that cannot be made.
USAGE, QUARANTINED, NOT_MADE = 2, 3, 4
# Outcomes of a scene. Only the first two say something about the policy.
FAILS, SUCCEEDS, REFUSED, UNDONE = "fails", "succeeds", "refused", "undone"
# Attempts of the recorder at the one episode.
ATTEMPTS = 2
# The longest difference of two colors with channels from 0 to 1.
WHITE_FROM_BLACK = math.sqrt(3.0)


@dataclass(frozen=True)
class Base:
    """The base of a search: a bundle, an environment with the task, robot, rate and cameras, the policy with the
    options of its rollouts, episodes in each scene, and a seed."""

    bundle: Path
    environment: EnvironmentFolder
    policy: str
    options: Mapping[str, Any]
    episodes: int
    seed: int

    @property
    def target(self) -> str:
        """The object whose properties are changed: the first that the task moves."""
        return str(self.environment.task["goal"][0][MOVED])


class SceneRunner:
    """Makes scenes of a search in a folder, and runs the policy in them."""

    def __init__(self, base: Base, folder: Path):
        self.base, self.folder = base, folder
        self.light = base_light(base.bundle)

    def record(self, number: int, change: Change, first: Mapping[str, Any] | None) -> dict[str, Any]:
        """Makes a scene, and returns its record. `first` is that of the base scene. Files are kept where the policy
        fails."""
        began_s = time.perf_counter()
        place = self.folder / f"{number:04d}"
        # A stop may have left a part of it.
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        operations = operations_of(change, self.base.target, self.light)
        found = self._outcome(place, operations, change)
        apart = {"color": color_apart(first, found)} if first is not None else {}
        if first is not None and "base_m" in found:
            found["base_moved_m"] = math.dist(first["base_m"], found["base_m"])
        if found["outcome"] != FAILS:
            shutil.rmtree(place)
        took = {"wall_s": round(time.perf_counter() - began_s, 3)}
        return {"scene": number, "change": dict(change), "operations": operations, "distance": distance_of(change, apart), **found, **took}

    def _outcome(self, place: Path, operations: list[dict[str, Any]], change: Change) -> dict[str, Any]:
        bundle = self.base.bundle
        if operations:
            bundle = place / "bundle"
            words = ["edit", "--bundle", self.base.bundle, "--operations", json.dumps(operations), "--seed", self.base.seed]
            done = completed(*words, "--out", bundle, "--quiet", accepted=(0, QUARANTINED, NOT_MADE))
            if done.returncode != 0:
                return {"outcome": REFUSED, "reason": complaint(done) or "the certificate says quarantine"}
        if refusal := self._recorded(bundle, place):
            return {"outcome": REFUSED, "reason": refusal}
        dataset = RecordedDataset(place / "episodes")
        files = write_environment_like(place / "environment", bundle, self.base.environment, dataset, camera_of(change))
        found = rollout([files.folder], self.base.policy, place / "rollout", episodes=self.base.episodes, **self.base.options)
        successes = found["overall"]["successes"]
        base = dataset.entries[0]["record"]["world_from_base"]["translation_m"]
        shown: dict[str, Any] = {"successes": successes, "episodes": self.base.episodes, "base_m": base}
        shown["record"] = RolloutFolder(place / "rollout").records()[0]
        if 2 * successes >= self.base.episodes:
            return {"outcome": SUCCEEDS, **shown}
        # Only what the recorded actions do in this simulation is what a policy could have done.
        again = rollout([files.folder], f"{RECORDED}{place / 'episodes'}", place / "recorded", images=False)
        return {"outcome": FAILS if again["overall"]["successes"] else UNDONE, **shown}

    def _recorded(self, bundle: Path, place: Path) -> str | None:
        """Records the episode of a scene, or returns why the program cannot do the task there."""
        verdict = json.loads((bundle / "report.json").read_text(encoding="utf-8"))["verdict"]
        if verdict != "pass":
            return f"the certificate says {verdict}"
        words = [*recorder_words(self.base, bundle, place), "--count", 1, "--max-attempts", ATTEMPTS, "--randomize", "none"]
        done = completed(*words, "--cameras", "none", accepted=(0, USAGE, NOT_MADE, TASK_FAILED))
        return complaint(done) if done.returncode != 0 else None


def recorder_words(base: Base, bundle: Path, place: Path) -> list[object]:
    """The command that records episodes of the task in a bundle, to the folder `episodes` of a place."""
    task = place / "task.json"
    task.write_text(json.dumps(base.environment.task), encoding="utf-8")
    words: list[object] = ["episodes", "--bundle", bundle, "--task", task, "--robot", base.environment.robot.name, "--seed", base.seed]
    words += ["--fps", base.environment.fps, "--format", "parquet-png", "--workers", 1, "--out", place / "episodes", "--quiet"]
    return words


def color_apart(first: Mapping[str, Any], found: Mapping[str, Any]) -> float:
    """The difference between the colors of the moved object here and in the base scene, as a share of white from black;
    1 where the scene was refused."""
    if "record" not in found:
        return 1.0
    return math.dist(color_in(first["record"]), color_in(found["record"])) / WHITE_FROM_BLACK


def color_in(record: Mapping[str, Any]) -> list[float]:
    """The color of the first moved object in an episode's record."""
    return list(record["objects"][record["moved"][0]["object"]]["color"])


def run_draws(base: Base, count: int, randomize: str, place: Path) -> None:
    """Runs the policy from so many new starts in the base scene, drawn with a randomization. What is finished of it
    stays."""
    dataset, environment = place / "episodes", place / "environment"
    place.mkdir(parents=True, exist_ok=True)
    cameras = place / "cameras.json"
    cameras.write_text(json.dumps([asdict(camera) for camera in base.environment.cameras]), encoding="utf-8")
    if not dataset.exists():
        shown = cameras if base.environment.cameras else "none"
        run(*recorder_words(base, base.bundle, place), "--count", count, "--randomize", randomize, "--cameras", shown)
    shutil.rmtree(environment, ignore_errors=True)
    files = write_environment_like(environment, base.bundle, base.environment, RecordedDataset(dataset), None)
    rollout([files.folder], base.policy, place / "rollout", seed=base.seed, **base.options)
