"""The search for counterexamples: what it finds, how small it makes it, and that its budget is kept."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from planted_policies import DARK_BELOW
from tabletopgen.env import EnvironmentFolder
from tabletopgen.env.__main__ import main
from tabletopgen.env.counterexample_axes import AXES, COLORS, USUAL_LIGHT, Change, axes_named, change_of, distance_of, operations_of
from tabletopgen.env.counterexample_report import document_of, markdown
from tabletopgen.env.counterexample_search import BudgetSpentError, Search
from tabletopgen.env.counterexamples import counterexamples
from tabletopgen.env.folder import DESCRIPTION, write_environment_like
from tabletopgen.env.folder_digest import digest_of_folder
from tabletopgen.env.recorded_dataset import RecordedDataset
from tabletopgen.env.rollout_replay import replay
from tabletopgen.env.start import CameraStart
from tabletopgen.errors import MissingPackageError

pytest.importorskip("scipy", reason="scipy is not installed")

POLICIES = Path(__file__).with_name("planted_policies.py")
ALL = axes_named([], has_cameras=True)


class World:
    """Scenes that are not made: in which a policy fails, and which there were."""

    def __init__(self, fails: Callable[[Change], bool], budget: int):
        self.rule, self.budget, self.made = fails, budget, list[Change]()

    def fails(self, change: Change) -> bool:
        if len(self.made) == self.budget:
            raise BudgetSpentError
        self.made.append(dict(change))
        return self.rule(change)

    def records(self) -> list[dict[str, Any]]:
        """Records as those of scenes."""
        return [
            {
                "scene": number,
                "change": change,
                "operations": [],
                "distance": distance_of(change, {}),
                "outcome": "fails" if self.rule(change) else "succeeds",
                "successes": 0,
                "episodes": 1,
                "record": {},
            }
            for number, change in enumerate(self.made)
        ]


def level(change: Change, name: str) -> float:
    return float(change.get(name, 0.0))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(
    ("name", "threshold"), [("light_intensity", -0.3), ("mass_factor", 0.2), ("x_m", -0.9), ("camera_turn_rad", 0.7)]
)
def test_the_smallest_change_of_a_planted_weakness_is_found(name: str, threshold: float, seed: int) -> None:
    world = World(lambda change: level(change, name) / threshold >= 1, 100)
    Search(ALL, world.fails, seed).run()
    assert len(world.made) == 100
    found = document_of({"policy": "planted", "vary": list(AXES), "scenes": 100}, world.records(), [])
    smallest = found["smallest"][name]
    held = smallest["holds_at"]
    assert list(found["smallest"]) == [name] and found["combined"] == []
    assert abs(threshold) <= smallest["distance"] <= abs(threshold) + 1 / 16
    low, high = sorted([held, smallest["value"]])
    assert low <= AXES[name].value(threshold) <= high


@pytest.mark.parametrize("seed", range(5))
def test_a_color_and_a_second_weakness_are_found_in_one_search(seed: int) -> None:
    world = World(lambda change: change.get("color") == "red" or level(change, "mass_factor") > 0.5, 100)
    Search(ALL, world.fails, seed).run()
    found = document_of({"policy": "planted", "vary": list(AXES), "scenes": 100}, world.records(), [])
    assert set(found["smallest"]) == {"color", "mass_factor"} and found["smallest"]["color"]["value"] == "red"
    assert set(found["holds"]["color"]) == set(COLORS) - {"red"} and found["combined"] == []
    text = markdown(found)
    assert "| color | red |  | 1.000 |" in text and "| x_m | no failure found |" in text


def test_a_weakness_of_two_changes_together_is_reduced_to_them() -> None:
    world = World(lambda change: level(change, "mass_factor") > 0.4 and level(change, "light_intensity") < -0.2, 100)
    Search(ALL, world.fails, 0).run()
    found = document_of({"policy": "planted", "vary": list(AXES), "scenes": 100}, world.records(), [])
    assert found["smallest"] == {} and len(found["combined"]) == 1
    change = found["combined"][0]["change"]
    assert set(change) == {"mass_factor", "light_intensity"}
    assert 0.4 < change["mass_factor"] < 0.47 and -0.27 < change["light_intensity"] < -0.2


def test_what_always_fails_is_not_searched_and_what_never_fails_is_to_the_end() -> None:
    always, never = World(lambda _: True, 100), World(lambda _: False, 60)
    Search(ALL, always.fails, 0).run()
    Search(ALL, never.fails, 0).run()
    assert always.made == [{}] and len(never.made) == 60 and len({json.dumps(one) for one in never.made}) == 60
    request = {"policy": "planted", "vary": list(AXES), "scenes": 60}
    assert "fails in the scene as it is" in markdown(document_of(request, always.records(), []))
    assert document_of(request, never.records(), [])["counterexamples"] == []


def test_a_missing_package_is_named_before_the_first_scene_and_nothing_is_imported_after_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    world = World(lambda _: False, 3)
    with monkeypatch.context() as without:
        without.setitem(sys.modules, "scipy.stats.qmc", None)
        with pytest.raises(MissingPackageError, match="pip install scipy"):
            Search(ALL, world.fails, 0)
    search = Search(ALL, world.fails, 0)
    monkeypatch.setitem(sys.modules, "scipy.stats.qmc", None)
    search.run()
    assert len(world.made) == 3


def test_a_search_is_decided_by_its_seed_and_a_greater_budget_begins_with_the_same() -> None:
    made = []
    for budget, seed in ((40, 1), (80, 1), (40, 2)):
        world = World(lambda change: level(change, "y_m") > 0.4, budget)
        Search(ALL, world.fails, seed).run()
        made.append(world.made)
    assert made[0] == made[1][:40] != made[2]


def test_changes_are_operations_of_edits() -> None:
    levels = {name: axis.ends[0] for name, axis in AXES.items()}
    found = {one["op"]: one for one in operations_of(change_of(levels), "can_1", USUAL_LIGHT)}
    assert found["resize"] == {"op": "resize", "target": "can_1", "factor": 1.4}
    assert found["set_physics"] == {"op": "set_physics", "target": "can_1", "mass_factor": 4.0, "friction_factor": 4.0}
    assert found["move"]["where"] == {"offset_m": [0.15, 0.15]} and found["clutter"]["count"] == 4
    assert found["recolor"]["color"] == found["restyle_table"]["color"] == "red" and found["rotate"]["by_rad"] == 1.5
    light = found["relight"]
    assert light["intensity"] == pytest.approx(1.6) and light["elevation_rad"] == pytest.approx(USUAL_LIGHT["elevation_rad"] + 0.3)
    assert math.isclose(math.remainder(light["azimuth_rad"] - USUAL_LIGHT["azimuth_rad"] - 3.1, 2 * math.pi), 0.0, abs_tol=1e-9)
    # Without changes of the light, the scene keeps the one that it has, stated or not.
    assert operations_of(change_of({"mass_factor": -1.0, "clutter": 0.1}), "can_1", USUAL_LIGHT) == [
        {"op": "set_physics", "target": "can_1", "mass_factor": 0.25}
    ]


def test_axes_that_are_not_there_are_refused() -> None:
    with pytest.raises(ValueError, match="there is no axis weight; choose among mass_factor"):
        axes_named(["weight"], has_cameras=True)
    with pytest.raises(ValueError, match="camera_turn_rad change what no camera observes"):
        axes_named(["camera_turn_rad"], has_cameras=False)
    assert not any(axis.name.startswith("camera") for axis in axes_named([], has_cameras=False))


def test_an_environment_like_another_is_the_same_for_the_same_bundle(
    environment: EnvironmentFolder, task_scene: Path, task_episodes: RecordedDataset, tmp_path: Path
) -> None:
    write_environment_like(tmp_path / "alike", task_scene, environment, task_episodes, None)
    assert digest_of_folder(tmp_path / "alike") == digest_of_folder(environment.folder)
    deviation = CameraStart((0.1, 0.0, 0.0), (0.0, 0.0, 0.0), 1.0)
    turned = write_environment_like(tmp_path / "turned", task_scene, environment, task_episodes, deviation)
    assert turned.cameras == environment.cameras and all(start.cameras == (deviation, deviation) for start in turned.starts)


def options(environment: EnvironmentFolder, scene: Path) -> dict[str, Any]:
    """A search that is decided by the light alone."""
    own: dict[str, Any] = {"environment": environment.folder, "scene": scene, "policy": f"{POLICIES}:dark", "vary": ["light_intensity"]}
    return {**own, "images": False, "max_duration_s": 15.0}


def test_a_dark_scene_is_found_certified_and_replayed(environment: EnvironmentFolder, task_scene: Path, tmp_path: Path) -> None:
    out, given = tmp_path / "out", options(environment, task_scene)
    found = counterexamples(out=out, scenes=2, draws=1, randomize="usual", **given)
    assert found["scenes"] == 2 and found["draws"]["episodes"] == 1
    before = (out / "scenes.jsonl").read_bytes()
    # More scenes continue the same search.
    found = counterexamples(out=out, scenes=5, draws=1, randomize="usual", **given)
    assert (out / "scenes.jsonl").read_bytes().startswith(before) and found["scenes"] == sum(found["outcomes"].values()) == 5
    smallest = found["smallest"]["light_intensity"]
    # MuJoCo's light is 0.6 bright.
    assert 0.3 <= smallest["value"] < DARK_BELOW / 0.6 <= smallest["holds_at"]
    assert sorted(path.name for path in (out / "scenes").iterdir()) == [f"{one['scene']:04d}" for one in sorted_by_scene(found)]
    for one in found["counterexamples"]:
        bundle = out / "scenes" / f"{one['scene']:04d}" / "bundle"
        assert json.loads((bundle / "report.json").read_text())["verdict"] == "pass"
        assert one["record"]["factors"]["light_brightness"] < DARK_BELOW and one["operations"][0]["op"] == "relight"
        assert replay(out / one["rollout"], 0)["equal"]
        assert json.loads((bundle.parent / "recorded" / "summary.json").read_text())["overall"]["successes"] == 1
    with pytest.raises(ValueError, match="the search of another request"):
        counterexamples(out=out, scenes=5, **{**given, "seed": 5})


def sorted_by_scene(found: dict[str, Any]) -> list[dict[str, Any]]:
    return sorted(found["counterexamples"], key=lambda one: int(one["scene"]))


def test_an_interrupted_search_goes_on(environment: EnvironmentFolder, task_scene: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = ["counterexamples", environment.folder, "--scene", task_scene, "--policy", f"{POLICIES}:dark", "--vary", "light_intensity"]
    command = list(map(str, [*words, "--no-images", "--max-duration", "15", "--out", out, "--scenes"]))
    pipes: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True, "start_new_session": True}
    with subprocess.Popen([sys.executable, "-m", "tabletopgen.env", *command, "9"], **pipes) as process:
        until_s = time.monotonic() + 120
        while not (out / "scenes.jsonl").is_file() and time.monotonic() < until_s:
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        said = process.communicate()[1]
    assert process.returncode == 130 and "Traceback" not in said and "the same command continues" in said, said
    made = (out / "scenes.jsonl").read_bytes().count(b"\n")
    assert json.loads((out / "counterexamples.json").read_text())["scenes"] == made
    assert main([*command, str(made + 1)]) == 0
    assert (out / "scenes.jsonl").read_bytes().count(b"\n") == made + 1


def test_a_scene_in_which_the_task_cannot_be_done_is_no_base(environment: EnvironmentFolder, task_scene: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="is no folder of a bundle"):
        counterexamples(environment.folder, tmp_path, "random", tmp_path / "out")
    with pytest.raises(ValueError, match="0 scenes and 0 draws cannot be searched"):
        counterexamples(environment.folder, task_scene, "random", tmp_path / "out", scenes=0)
    impossible = tmp_path / "impossible"
    impossible.mkdir()
    for path in environment.folder.iterdir():
        (impossible / path.name).symlink_to(path)
    document = json.loads((environment.folder / DESCRIPTION).read_text(encoding="utf-8"))
    document["task"]["goal"] = [{"predicate": "on", "object": "spoon_9", "target": "plate_1"}]
    (impossible / DESCRIPTION).unlink()
    (impossible / DESCRIPTION).write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(ValueError, match="in the scene as it is, the program does not do the task: .*cannot make its motions"):
        counterexamples(impossible, task_scene, "random", tmp_path / "out", images=False)
