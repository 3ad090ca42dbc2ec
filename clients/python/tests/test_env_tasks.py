"""When a task of an environment is done, and whether it can be."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from tabletopgen.env import EnvironmentFolder, SceneEnv
from tabletopgen.env.__main__ import main
from tabletopgen.env.folder import DESCRIPTION
from tabletopgen.env.judge import Judge, JudgeError
from tabletopgen.env.task_check import TaskCheck

CAN, PLATE, SPONGE = "soda_can_1", "plate_1", "sponge_1"


def with_goal(environment: EnvironmentFolder, folder: Path, *goal: dict[str, str]) -> EnvironmentFolder:
    """The environment with another goal."""
    shutil.copytree(environment.folder, folder)
    document = json.loads((folder / DESCRIPTION).read_text(encoding="utf-8"))
    document["task"]["goal"] = list(goal)
    (folder / DESCRIPTION).write_text(json.dumps(document), encoding="utf-8")
    return EnvironmentFolder.read(folder)


@pytest.fixture
def env(environment: EnvironmentFolder) -> Iterator[SceneEnv]:
    made = SceneEnv(folder=environment.folder, images=False)
    # A start with all objects.
    made.reset(options={"start": full_start(environment)})
    yield made
    made.close()


def full_start(environment: EnvironmentFolder) -> int:
    starts = environment.starts
    return next(number for number, start in enumerate(starts) if all(drawn.world_from_object for drawn in start.objects.values()))


def put(env: SceneEnv, name: str, on: str, above_m: float) -> None:
    """Puts an object upright above the origin of another one."""
    at = env.simulation.pose(on)["translation_m"]
    env.simulation.put(name, {"translation_m": [at[0], at[1], at[2] + above_m], "rotation_xyzw": [0.0, 0.0, 0.0, 1.0]})


def waited(env: SceneEnv, seconds: float) -> list[Any]:
    """What the steps of a waiting robot find, until an episode ends."""
    action = [*env.simulation.robot.positions_rad(env.simulation.data), 0.08]
    found = []
    for _ in range(round(seconds / env.step_s)):
        found.append(env.step(action)[1:])  # type: ignore[arg-type]
        if found[-1][1] or found[-1][2]:
            break
    return found


def test_a_task_is_done_once_all_has_rested(env: SceneEnv) -> None:
    put(env, CAN, PLATE, 0.01)
    found = waited(env, 3.0)
    reward, is_done, is_cut, info = found[-1]
    assert (reward, is_done, is_cut, info["is_success"]) == (1.0, True, False, True)
    assert all(one[0] == 0.0 for one in found[:-1])
    assert len(found) >= env.task["limits"]["min_rest_s"] * env.files.fps
    assert [predicate["reason"] for predicate in info["predicates"]] == ["holds"]


def test_a_task_that_is_not_done_goes_on_and_says_why(env: SceneEnv) -> None:
    assert not env.verdict().reached
    at = env.simulation.pose(CAN)
    env.simulation.put(CAN, {**at, "translation_m": [at["translation_m"][0] - 0.05, *at["translation_m"][1:]]})
    found = waited(env, 2.0)
    assert len(found) == round(2.0 * env.files.fps) and not any(one[1] for one in found)
    assert found[-1][3]["predicates"][0]["reason"] == "no_contact"


def test_moving_others_spoils_a_task(env: SceneEnv) -> None:
    put(env, CAN, PLATE, 0.01)
    at = env.simulation.pose(SPONGE)
    env.simulation.put(SPONGE, {**at, "translation_m": [at["translation_m"][0], at["translation_m"][1] + 0.05, 0.002]})
    found = waited(env, 3.0)
    assert not any(one[1] for one in found)
    info = found[-1][3]
    assert info["predicates"][0]["holds"] and [moved["object"] for moved in info["disturbed"]] == [SPONGE]


def test_a_verdict_is_relative_to_the_start_of_the_episode(environment: EnvironmentFolder, tmp_path: Path) -> None:
    files = with_goal(environment, tmp_path / "moved", {"predicate": "moved", "object": CAN})
    judge = Judge(files.scene, files.task)
    start = files.starts[0]
    pose = start.objects[CAN].world_from_object
    assert pose is not None
    judge.begin(start)
    at = pose["translation_m"]
    measured = []
    for shift_m in (0.0, 0.029, 0.031):
        moved = {**pose, "translation_m": [at[0] + shift_m, *at[1:]]}
        verdict = judge.verdict({"objects": {CAN: moved}})
        assert verdict.reached == (shift_m > 0.03) and not verdict.disturbed
        measured.append(verdict.predicates[0]["measured"])
    assert measured == pytest.approx([0.0, 0.029, 0.031], abs=1e-9)
    with pytest.raises(JudgeError, match="no object of the scene"):
        judge.verdict({"objects": {"spoon_9": pose}})
    judge.close()


def test_a_sound_task_passes_its_check(environment: EnvironmentFolder, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(environment.folder), "--count", "2"]) == 0
    found = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [one["is_sound"] for one in found] == [True, True]


@pytest.mark.parametrize(
    ("goal", "broken"),
    [
        # A sponge has no inside.
        ([{"predicate": "in", "object": CAN, "target": SPONGE}], "missed"),
        ([{"predicate": "on", "object": CAN}], "is_done_at_start"),
        ([{"predicate": "upside_down", "object": PLATE}, {"predicate": "upright", "object": PLATE}], "missed"),
    ],
)
def test_a_broken_task_is_found(goal: list[dict[str, str]], broken: str, environment: EnvironmentFolder, tmp_path: Path) -> None:
    with closing(TaskCheck(with_goal(environment, tmp_path / "broken", *goal))) as check:
        found = check.start(full_start(environment))
    assert not found.is_sound and getattr(found, broken)


@pytest.mark.parametrize(
    "goal",
    [
        [{"predicate": "lifted", "object": CAN}],
        [{"predicate": "stacked_on", "object": CAN, "target": PLATE}, {"predicate": "left_of", "object": SPONGE, "target": PLATE}],
        [{"predicate": "swapped", "object": CAN, "target": SPONGE}],
        [{"predicate": "at_back_left", "object": SPONGE}],
        [{"predicate": "between", "object": SPONGE, "target": CAN, "second_target": PLATE}],
        [{"predicate": "lying_on_side", "object": CAN}],
    ],
    ids=lambda goal: goal[0]["predicate"],
)
def test_scripts_reach_goals_of_all_kinds(goal: list[dict[str, str]], environment: EnvironmentFolder, tmp_path: Path) -> None:
    with closing(TaskCheck(with_goal(environment, tmp_path / "other", *goal))) as check:
        found = check.start(full_start(environment))
    assert found.is_reached and found.is_undone and found.missed == []


def test_commands_prepare_and_repeat(
    task_scene: Path, environment: EnvironmentFolder, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    dataset = str(task_scene.with_name("episodes"))
    folder = str(tmp_path / "environment")
    assert main(["prepare", folder, "--scene", str(task_scene), "--dataset", dataset]) == 0
    assert json.loads(capsys.readouterr().out) == {"folder": folder, "task": environment.task["instruction"], "starts": 4}
    assert main(["repeat", folder, dataset, "--count", "1"]) == 0
    first, summary = map(json.loads, capsys.readouterr().out.splitlines())
    assert first["is_success"] and summary["successes"] == summary["of"] == 1 and summary["steps_per_s"] > 1
    assert main(["check", str(tmp_path)]) == 2
    assert "is no environment" in capsys.readouterr().err
