"""Packages for LeRobot's EnvHub: `env.py` as its evaluation loads it, without LeRobot itself."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import pytest

from tabletopgen import _media
from tabletopgen.env import EnvironmentFolder
from tabletopgen.env.__main__ import main
from tabletopgen.env.recorded_dataset import RecordedDataset

REPOSITORY = "me/can_on_plate"


@pytest.fixture
def package(environment: EnvironmentFolder, tmp_path: Path) -> Path:
    folder = tmp_path / ("0" * 40)
    assert main(["envhub", str(environment.folder), "--repository", REPOSITORY, "--out", str(folder)]) == 0
    return folder


def entry(path: Path) -> Any:
    """The module of an `env.py`."""
    spec = importlib.util.spec_from_file_location("hub_env", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_recorded_actions_succeed_as_lerobot_counts_it(package: Path, task_episodes: RecordedDataset) -> None:
    vector = entry(package / "env.py").make_env()["tabletopgen"][0]
    assert vector.call("task_description") == ("put the can on the plate",)
    max_steps = vector.call("_max_episode_steps")[0]
    observed, info = vector.reset(seed=[1])
    assert set(observed) == {"agent_pos", "pixels"}
    actions = task_episodes.frames(int(info["episode"][0]), ["action"])["action"]
    assert actions.shape[1] == vector.single_action_space.shape[0]
    succeeded = False
    for step in range(min(max_steps, 200)):
        *_, info = vector.step(actions[None, min(step, len(actions) - 1)])
        if "final_info" in info:
            (succeeded,) = info["final_info"]["is_success"].tolist()
            break
    assert succeeded
    vector.close()


def test_it_runs_in_processes_of_its_own(package: Path) -> None:
    vector = entry(package / "env.py").make_env(n_envs=2, use_async_envs=True)["tabletopgen"][0]
    observed, _ = vector.reset(seed=[1, 2])
    assert observed["agent_pos"].shape == (2, 29) and observed["pixels"]["front"].shape == (2, 48, 48, 3)
    vector.step(vector.action_space.sample())
    vector.close()


def test_the_other_files_are_of_the_same_commit(package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    class Hub:
        @staticmethod
        def snapshot_download(repository: str, revision: str | None) -> str:
            asked.append((repository, revision))
            return str(package)

    alone = tmp_path / ("1" * 40)
    alone.mkdir()
    (alone / "env.py").write_bytes((package / "env.py").read_bytes())
    monkeypatch.setattr("tabletopgen.env.envhub.imported", lambda name: Hub if name == "huggingface_hub" else _media.imported(name))
    entry(alone / "env.py").make_env()["tabletopgen"][0].close()
    assert asked == [(REPOSITORY, "1" * 40)]


def test_its_card_says_what_it_is(package: Path) -> None:
    card = (package / "README.md").read_text(encoding="utf-8")
    assert all(word in card for word in ("# put the can on the plate", REPOSITORY, "4 recorded starts", "29 numbers", "all 22 numbers"))
    assert (package / "requirements.txt").read_text(encoding="utf-8") == "tabletopgen[env]\n"
