"""Environments of tasks, prepared by the program and run in MuJoCo."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import tabletopgen.env
from tabletopgen.env import EnvironmentFolder, SceneEnv, prepare
from tabletopgen.env.engine import mujoco
from tabletopgen.env.expert import Expert
from tabletopgen.env.recorded_dataset import RecordedDataset
from tabletopgen.env.scene_env import OBJECTS, STATE

# Numbers of datasets are single precision.
SAME = 1e-6
ADVICE = "ignore:.*symmetric and normalized"


@pytest.fixture
def env(environment: EnvironmentFolder) -> Iterator[SceneEnv]:
    """The environment without images."""
    made = SceneEnv(folder=environment.folder, images=False)
    yield made
    made.close()


def recorded_pose(env: SceneEnv, state: Any) -> None:
    """Puts the robot where a recorded state has it."""
    robot, data = env.simulation.robot, env.simulation.data
    arm = len(robot.arm_qpos)
    data.qpos[robot.arm_qpos], data.qvel[robot.arm_dof] = state[:arm], state[arm : 2 * arm]
    data.qpos[robot.finger_qpos] = robot.finger_sign * state[-2] / robot.names.opening_per_position
    mujoco.mj_kinematics(env.simulation.model, data)
    mujoco.mj_camlight(env.simulation.model, data)


@pytest.mark.filterwarnings(ADVICE)
def test_gymnasium_has_no_complaint(environment: EnvironmentFolder) -> None:
    made = gymnasium.make(tabletopgen.env.ID, folder=environment.folder, render_mode="rgb_array", object_poses=True)
    check_env(made.unwrapped)
    made.reset(seed=0)
    frame = made.render()
    assert isinstance(frame, np.ndarray) and frame.shape == (480, 640, 3) and frame.std() > 5
    made.close()


def test_states_equal_those_of_the_dataset(env: SceneEnv, task_episodes: RecordedDataset) -> None:
    for number, start in enumerate(env.starts):
        states = task_episodes.frames(start.episode)[STATE]
        observed, info = env.reset(options={"start": number})
        assert info["episode"] == start.episode
        first = observed[STATE]
        # All but velocities, which are zero at a start.
        still = [place for place, name in enumerate(env.state_names) if not name.endswith("_per_s")]
        assert np.abs(first - states[0])[still].max() < SAME
        for state in states:
            recorded_pose(env, state)
            assert np.abs(env._observation()[STATE] - state).max() < SAME


def test_cameras_are_where_the_dataset_has_them(env: SceneEnv, task_episodes: RecordedDataset) -> None:
    columns = [f"camera.{camera.name}.{what}" for camera in env.files.cameras for what in ("world_from_camera", "intrinsics")]
    assert len(columns) == 4
    for number, start in enumerate(env.starts):
        frames = task_episodes.frames(start.episode, [STATE, *columns])
        env.reset(options={"start": number})
        for row in (0, len(frames[STATE]) // 2):
            recorded_pose(env, frames[STATE][row])
            for camera, drawn in zip(env.files.cameras, start.cameras, strict=True):
                found = env.cameras.world_from_camera(env.simulation.data, camera)
                expected = frames[f"camera.{camera.name}.world_from_camera"][row].reshape(4, 4)
                assert np.abs(found - expected).max() < SAME
                assert camera.focal_px(drawn) == pytest.approx(frames[f"camera.{camera.name}.intrinsics"][row][0], rel=SAME)


def test_images_have_the_names_and_sizes_of_the_dataset(environment: EnvironmentFolder) -> None:
    made = SceneEnv(folder=environment.folder)
    observed, _ = made.reset(seed=0)
    images = {name: image for name, image in observed.items() if name.startswith("observation.images.")}
    assert set(images) == {"observation.images.front", "observation.images.wrist"}
    assert all(image.shape == (48, 48, 3) and image.dtype == np.uint8 and image.std() > 5 for image in images.values())
    made.close()


@pytest.mark.parametrize("mode", ["joint", "tool", "recorded"])
def test_recorded_actions_do_the_task_in_every_mode(mode: str, environment: EnvironmentFolder, task_episodes: RecordedDataset) -> None:
    made = SceneEnv(folder=environment.folder, images=False, action_mode=mode)
    done = list(Expert(made, task_episodes).repeats(range(len(made.starts))))
    assert [one.is_success for one in done] == [True] * len(made.starts)
    assert all(predicate["holds"] for one in done for predicate in one.predicates)
    made.close()


def test_the_motion_is_that_of_the_dataset(env: SceneEnv, task_episodes: RecordedDataset) -> None:
    states, actions = task_episodes.frames(0)[STATE], Expert(env, task_episodes).actions(0)
    env.reset(options={"start": 0})
    apart_m = 0.0
    tool = slice(env.state_names.index("end_effector_x_m"), env.state_names.index("end_effector_z_m") + 1)
    for action, state in zip(actions[:-1], states[1:], strict=True):
        apart_m = max(apart_m, float(np.abs(env.step(action)[0][STATE] - state)[tool].max()))
    # Within half a step of the fastest motion.
    assert apart_m < 0.015


def test_the_same_seed_gives_the_same_trajectory(environment: EnvironmentFolder) -> None:
    def trajectory(seed: int) -> list[Any]:
        made = SceneEnv(folder=environment.folder, images=False, object_poses=True)
        observed, info = made.reset(seed=seed)
        made.action_space.seed(seed)
        seen = [info["start"], observed[STATE], observed[OBJECTS]]
        for _ in range(20):
            observed, *rest = made.step(made.action_space.sample())
            seen += [observed[STATE], observed[OBJECTS], *rest[:3]]
        made.reset()
        made.close()
        return [np.asarray(one).tobytes() for one in seen]

    assert trajectory(3) == trajectory(3) != trajectory(4)


def test_processes_run_it_side_by_side(environment: EnvironmentFolder) -> None:
    def made() -> gymnasium.Env[Any, Any]:
        return SceneEnv(folder=environment.folder, images=False)

    # What a process imports may have threads, which a forked one would not have.
    vector = gymnasium.vector.AsyncVectorEnv([made, made], context="forkserver")
    observed, info = vector.reset(seed=[3, 3])
    assert np.array_equal(observed[STATE][0], observed[STATE][1]) and info["start"][0] == info["start"][1]
    action = vector.action_space.sample()
    observed, reward, *_ = vector.step(np.stack([action[0], action[0]]))
    assert np.array_equal(observed[STATE][0], observed[STATE][1]) and list(reward) == [0.0, 0.0]
    vector.close()


def test_a_thousand_resets_leak_nothing(env: SceneEnv) -> None:
    def used() -> tuple[float, int, int]:
        gc.collect()
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE") / 1e6, len(os.listdir("/proc/self/fd")), len(gc.get_objects())

    for count in (50, 1000):
        before = used()
        for number in range(count):
            env.reset(options={"start": number % len(env.starts)})
            if number % 10 == 0:
                env.step(env.action_space.sample())
    after = used()
    assert after[0] - before[0] < 5.0 and after[1] == before[1] and after[2] - before[2] < 100


def test_a_start_has_the_drawn_masses_frictions_and_objects(env: SceneEnv) -> None:
    model = env.simulation.model
    as_compiled = env.simulation._as_compiled
    presences = set()
    for number, start in enumerate(env.starts):
        env.reset(options={"start": number})
        for name, drawn in start.objects.items():
            body, geom = env.simulation.body[name], env.simulation.geoms[name][0]
            assert model.body_mass[body] == pytest.approx(drawn.mass_factor * as_compiled["body_mass"][body])
            assert model.geom_friction[geom, 0] == pytest.approx(drawn.friction_factor * as_compiled["geom_friction"][geom, 0])
            assert (drawn.world_from_object is not None) == (name in env.simulation.present)
            if drawn.world_from_object is not None:
                assert env.simulation.pose(name)["translation_m"] == pytest.approx(drawn.world_from_object["translation_m"])
        presences.add(env.simulation.present)
    assert len(presences) == 2, "the object that the task does not name is absent in some episodes"


def test_an_absent_object_neither_falls_nor_is_seen(env: SceneEnv) -> None:
    number = next(number for number, start in enumerate(env.starts) if start.objects["sponge_1"].world_from_object is None)
    env.reset(options={"start": number})
    before = env.simulation.pose("sponge_1")
    for _ in range(10):
        env.step(env.action_space.sample())
    after = env.simulation.pose("sponge_1")
    assert after["translation_m"] == pytest.approx(before["translation_m"], abs=1e-6)
    assert "sponge_1" not in env.simulation.state()["objects"]


def test_what_is_no_action_is_refused(env: SceneEnv) -> None:
    env.reset(seed=0)
    for action in (np.zeros(3, np.float32), np.full(8, np.nan, np.float32)):
        with pytest.raises(ValueError, match="8 finite numbers .joint1_rad, .*gripper_opening_m"):
            env.step(action)


def test_poses_out_of_reach_are_approached(environment: EnvironmentFolder) -> None:
    made = SceneEnv(folder=environment.folder, images=False, action_mode="tool")
    observed, _ = made.reset(seed=0)
    tool = slice(made.state_names.index("end_effector_x_m"), made.state_names.index("end_effector_z_m") + 1)
    before = observed[STATE][tool]
    # Behind the base, as far as numbers go, with the hand as it is.
    columns = [made.state_names.index(name) for name in made.action_names[3:9]]
    action = np.array([-1.6, 0.0, 0.5, *observed[STATE][columns], 0.08], dtype=np.float32)
    for _ in range(15):
        observed, *_ = made.step(action)
    assert np.isfinite(observed[STATE]).all() and observed[STATE][tool][0] < before[0] - 0.1
    action[3:9] = 0.0
    with pytest.raises(ValueError, match="are no columns of a rotation"):
        made.step(action)
    made.close()


def test_an_episode_ends_when_its_time_is_up(environment: EnvironmentFolder) -> None:
    made = SceneEnv(folder=environment.folder, images=False, max_duration_s=0.2)
    made.reset(seed=0)
    ends = [made.step(made.action_space.sample())[2:4] for _ in range(3)]
    assert ends == [(False, False), (False, False), (False, True)]
    made.close()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({}, "give a scene, or the folder"),
        ({"folder": ".", "action_mode": "torque"}, "choose one of joint, tool, recorded"),
        ({"folder": ".", "render_mode": "human"}, "choose one of rgb_array"),
        ({"folder": "."}, "is no environment: it has no environment.json"),
        ({"scene": ".", "task": "lift the can"}, "is no folder of a bundle"),
    ],
)
def test_what_cannot_be_made_is_refused(arguments: dict[str, Any], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with pytest.raises(ValueError, match=said):
        SceneEnv(**arguments)


def test_a_dataset_of_another_task_is_refused(task_scene: Path, task_episodes: RecordedDataset, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="has no episode of the task 'lift the can', only of ..put the can on the plate.."):
        prepare(tmp_path / "environment", task_scene, "lift the can", dataset=task_episodes.folder)
    assert list(tmp_path.iterdir()) == []


def test_what_exists_is_not_overwritten(environment: EnvironmentFolder, task_scene: Path) -> None:
    with pytest.raises(ValueError, match="exists; name another folder"):
        prepare(environment.folder, task_scene, "lift the can")
    with pytest.raises(ValueError, match="name a task, or a dataset"):
        prepare(environment.folder.with_name("other"), task_scene)


def test_a_bundle_alone_is_enough(task_scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    order: dict[str, Any] = {"scene": task_scene, "task": "lift the can", "starts": 1, "fps": 10, "images": False}
    made = gymnasium.make(tabletopgen.env.ID, **order).unwrapped
    assert isinstance(made, SceneEnv) and len(made.starts) == 1 and made.metadata["render_fps"] == 10
    made.close()
    written = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("environment.json")}
    gymnasium.make(tabletopgen.env.ID, **order).close()
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("environment.json")} == written, "it is made once"


def test_every_format_with_tables_gives_the_same_numbers(task_episodes: RecordedDataset) -> None:
    other = RecordedDataset(task_episodes.folder.with_name("lerobot-v3.0"))
    for episode in range(len(other.entries)):
        own, others = task_episodes.frames(episode), other.frames(episode)
        assert all(np.array_equal(own[column], others[column]) for column in own)
    with pytest.raises(ValueError, match="no frames of episode 99"):
        other.frames(99)
    with pytest.raises(ValueError, match="no dataset to read"):
        RecordedDataset(task_episodes.folder / "episodes")
