"""A server of the program for all tests that want one: TABLETOPGEN_PROGRAM, or the program on PATH."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tabletopgen import Client, Recording, Scene
from tabletopgen.env import EnvironmentFolder, prepare
from tabletopgen.env.recorded_dataset import RecordedDataset

SENTENCE = "A desk with a mug and an apple"
# For programs that tests start.
os.environ["PYTHONPATH"] = str(Path(__file__).resolve().parent.parent / "src")
# A disk that loses power is not what is tested.
SETTINGS = {"store.fsync": "false"}
# Little work for the renderer.
SMALL_RECORDING: dict[str, Any] = {"size_px": 64, "cameras": ["front"]}


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--sentences", type=int, default=30, help="sentences of the test of map; 1000 is the bar")


@pytest.fixture(scope="session")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program, which the clients of the tests find as the first one on PATH."""
    named = os.environ.get("TABLETOPGEN_PROGRAM") or shutil.which("tabletopgen")
    if not named:
        pytest.fail("set TABLETOPGEN_PROGRAM to the program, such as target/debug/tabletopgen")
    folder = tmp_path_factory.mktemp("bin")
    (folder / "tabletopgen").symlink_to(Path(named).resolve())
    os.environ["PATH"] = f"{folder}{os.pathsep}{os.environ['PATH']}"
    return Path(named).resolve()


@pytest.fixture(scope="session")
def client(program: Path) -> Iterator[Client]:
    """A client of a local server."""
    with Client(settings=SETTINGS, progress=False) as made:
        yield made


@pytest.fixture(scope="session")
def made(client: Client) -> Scene:
    """A finished scene."""
    return client.generate(SENTENCE, seed=7, labels={"made": "once"}).wait()


@pytest.fixture(scope="session")
def recorded(made: Scene) -> Recording:
    """A finished recording of one episode."""
    return made.record("lift the apple", 1, formats=["lerobot-v3.0"], record=SMALL_RECORDING).wait()


TASK = "put the can on the plate"
# Two objects; one is absent now and then, since the task does not name it.
TASK_SENTENCE = "A small table with a can, a plate and a sponge"
TASK_EPISODES = 4


@pytest.fixture(scope="session")
def task_scene(program: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a bundle in which a robot has something to do."""
    folder = tmp_path_factory.mktemp("task") / "scene"
    subprocess.run([program, "generate", "--text", TASK_SENTENCE, "--seed", "3", "--out", folder, "--quiet"], check=True)
    return folder


@pytest.fixture(scope="session")
def task_episodes(program: Path, task_scene: Path) -> RecordedDataset:
    """A few recorded episodes of a task, in two formats."""
    folder = task_scene.with_name("episodes")
    order: list[str | Path] = ["episodes", "--scene", task_scene, "--task", TASK, "--count", str(TASK_EPISODES), "--seed", "7"]
    shown = ["--cameras", "front,wrist", "--size", "48", "--amplitude", "absent_distractors=0.5"]
    subprocess.run([program, *order, *shown, "--format", "parquet-png,lerobot-v3.0", "--out", folder, "--quiet"], check=True)
    return RecordedDataset(folder)


@pytest.fixture(scope="session")
def environment(task_scene: Path, task_episodes: RecordedDataset) -> EnvironmentFolder:
    """The environment of that task."""
    return prepare(task_scene.with_name("environment"), task_scene, TASK, dataset=task_episodes.folder)
