"""Rollouts of policies in environments: what is counted, recorded, continued and replayed."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import PIL.Image
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from websockets.exceptions import ConnectionClosed
from websockets.sync.server import Server, ServerConnection, serve

from tabletopgen._media import imported
from tabletopgen.env import EnvironmentFolder, SceneEnv
from tabletopgen.env.__main__ import main
from tabletopgen.env.animated_png import AnimatedPng
from tabletopgen.env.envhub import LeRobotEnv
from tabletopgen.env.folder import DESCRIPTION
from tabletopgen.env.lerobot_policy import LeRobotPolicy, refuse_others
from tabletopgen.env.policy import Description, PolicyFailedError, PolicyUnavailableError, description_of
from tabletopgen.env.policy_server import ServerPolicy, packed, unpacked
from tabletopgen.env.recorded_dataset import RecordedDataset
from tabletopgen.env.rollout import rollout
from tabletopgen.env.rollout_folder import RolloutFolder
from tabletopgen.env.rollout_order import episodes
from tabletopgen.env.rollout_replay import replay
from tabletopgen.env.rollout_report import binned, wilson_interval
from tabletopgen.env.rollout_workers import WorkerFailedError
from tabletopgen.errors import MissingPackageError

STATE = "observation.state"
msgpack: Any = imported("msgpack")
# Episodes of six steps.
SHORT: dict[str, Any] = {"images": False, "max_duration_s": 0.4}
# Policies in a file. Each process writes its number, so that a test sees when it ends.
POLICIES = '''
import os, time
from pathlib import Path
import numpy as np
from tabletopgen.env.policies import RandomPolicy

class Slow(RandomPolicy):
    def act(self, observation):
        time.sleep(0.03)
        return super().act(observation)

def slow(description):
    (Path(__file__).parent / f"{os.getpid()}.pid").touch()
    return Slow(description)

class Faulty:
    def __init__(self, answers):
        self.answers, self.rest = answers, []
    def reset(self, info):
        self.rest = list(self.answers)
    def act(self, observation):
        answer = self.rest.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

def raising(description):
    return Faulty([np.zeros(8), np.zeros(8), RuntimeError("no idea")])

def short(description):
    return Faulty([np.zeros(3)])

def infinite(description):
    return Faulty([np.zeros(8), np.full(8, np.nan)])

def stops(description):
    os._exit(7)

def actless(description):
    return object()
'''


@pytest.fixture
def policies(tmp_path: Path) -> Path:
    path = tmp_path / "policies" / "own.py"
    path.parent.mkdir()
    path.write_text(POLICIES, encoding="utf-8")
    return path


@pytest.fixture
def description(environment: EnvironmentFolder) -> Iterator[Description]:
    env = SceneEnv(folder=environment.folder, images=False)
    yield description_of(env, environment, "joint", {})
    env.close()


def lasting(records: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Records without what differs between machines."""
    return [{name: part for name, part in record.items() if name not in ("wall_s", "policy_s")} for record in records]


def command(*words: object) -> list[str]:
    return [sys.executable, "-m", "tabletopgen.env", *map(str, words)]


def lines_in(out: Path) -> int:
    path = out / "episodes.jsonl"
    return path.read_bytes().count(b"\n") if path.is_file() else 0


def wait_for(condition: Any, limit_s: float = 60.0) -> None:
    until_s = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < until_s, "it did not come to this in time"
        time.sleep(0.02)


@pytest.mark.parametrize(
    ("successes", "trials", "low", "high"),
    [
        # Newcombe, "Two-sided confidence intervals for the single proportion", 1998, table I, method 3.
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
        (8, 10, 0.4902, 0.9433),
        (0, 10, 0.0, 0.2775),
        (10, 10, 0.7225, 1.0),
        (0, 0, 0.0, 1.0),
    ],
)
def test_intervals_are_the_published_ones(successes: int, trials: int, low: float, high: float) -> None:
    assert wilson_interval(successes, trials) == pytest.approx((low, high), abs=5e-5)


def test_impossible_counts_have_no_interval() -> None:
    with pytest.raises(ValueError, match="11 successes in 10 trials are impossible"):
        wilson_interval(11, 10)


def test_episodes_take_each_start_once_before_any_twice() -> None:
    found = episodes([4, 2, 3], 18, 5)
    assert [one.number for one in found] == list(range(18))
    starts = [(environment, start) for environment, count in enumerate([4, 2, 3]) for start in range(count)]
    for part in (found[:9], found[9:]):
        assert sorted((one.environment, one.start) for one in part) == starts
    assert found[:9] != [one for one in found[9:]] and len({one.seed for one in found}) == 18


def test_environments_have_as_many_of_the_first_episodes() -> None:
    found = episodes([20] * 7, 24, 1)
    counts = [sum(one.environment == place for one in found) for place in range(7)]
    assert sorted(set(counts)) == [3, 4]


def test_more_episodes_begin_with_the_same_ones_and_another_seed_has_others() -> None:
    assert episodes([4, 2, 3], 7, 5) == episodes([4, 2, 3], 18, 5)[:7] != episodes([4, 2, 3], 7, 6)


def records_with(values: Sequence[float], successes: int = 0) -> list[dict[str, Any]]:
    return [{"success": place < successes, "factors": {"x": value}} for place, value in enumerate(values)]


def test_bins_of_a_factor_have_equal_counts() -> None:
    bins = binned(records_with([9, 1, 5, 3, 7, 2, 8, 4, 6, 0], successes=1), "x")
    assert [(one["min"], one["max"], one["episodes"], one["successes"]) for one in bins] == [(0, 3, 4, 0), (4, 6, 3, 0), (7, 9, 3, 1)]


def test_equal_values_of_a_factor_are_in_one_bin() -> None:
    assert [(one["min"], one["max"], one["episodes"]) for one in binned(records_with([1, 1, 1, 1, 2, 3, 4, 5]), "x")] == [
        (1, 1, 4),
        (2, 3, 2),
        (4, 5, 2),
    ]
    assert [(one["min"], one["episodes"]) for one in binned(records_with([2, 3, 2, 2, 2, 2]), "x")] == [(2, 5), (3, 1)]


def test_frames_of_an_animated_image_are_those_that_were_added(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    frames = [random.integers(0, 256, (5, 7, 3), dtype=np.uint8)]
    for _ in range(3):
        frames.append(frames[-1].copy())
        frames[-1][1:3, 2:4] = random.integers(0, 256, (2, 2, 3))
    video = AnimatedPng(15)
    for frame in frames:
        video.add(frame)
    (tmp_path / "video.png").write_bytes(video.content())
    with PIL.Image.open(tmp_path / "video.png") as read:
        assert getattr(read, "n_frames", 1) == 4 and read.info["duration"] == pytest.approx(1000 / 15)
        for place, frame in enumerate(frames):
            read.seek(place)
            assert np.array_equal(np.asarray(read.convert("RGB")), frame)
    with pytest.raises(ValueError, match="give frames of one size"):
        video.add(np.zeros((7, 5, 3), dtype=np.uint8))


def test_recorded_actions_succeed_and_replay(
    environment: EnvironmentFolder, task_episodes: RecordedDataset, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    found = rollout([environment.folder], f"recorded:{task_episodes.folder}", out, images=False, videos=1)
    assert found["overall"] == {"successes": 4, "episodes": 4, "rate": 1.0, "wilson_95": pytest.approx([0.5101, 1.0], abs=1e-4)}
    records = RolloutFolder(out).records()
    assert sorted(record["start"] for record in records) == [0, 1, 2, 3]
    for record in records:
        start = environment.starts[record["start"]]
        assert record["recorded_episode"] == start.episode and record["reason"] == "done" and record["predicates"][0]["holds"]
        assert record["simulated_s"] == pytest.approx(record["steps"] / environment.fps)
        assert replay(out, record["episode"])["equal"]
        can, plate = (start.objects[name].world_from_object for name in ("soda_can_1", "plate_1"))
        assert can is not None and plate is not None
        apart_m = np.hypot(*(np.array(can["translation_m"]) - plate["translation_m"])[:2])
        assert record["factors"]["distance_m"] == pytest.approx(apart_m)
        assert record["factors"]["objects_present"] == sum(drawn.world_from_object is not None for drawn in start.objects.values())
        assert record["light"]["brightness_factor"] == start.light.brightness_factor
        assert record["cameras"]["wrist"]["offset_m"] == list(start.cameras[1].offset_m)
    assert records[0]["task"] == "on(soda_can, plate)" and records[0]["wording"] == "put the can on the plate"
    assert [path.name for path in (out / "videos").iterdir()] == ["000000.png"]
    with PIL.Image.open(out / "videos" / "000000.png") as video:
        assert getattr(video, "n_frames", 1) == records[0]["steps"] + 1
    tables = (out / "summary.md").read_text(encoding="utf-8")
    assert "4 of 4 episodes succeeded (100.0 %, 95 % interval 51.0 % to 100.0 %)" in tables and "## By distance_m" in tables


def test_what_moved_otherwise_is_no_equal_replay(
    environment: EnvironmentFolder, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    rollout([environment.folder], "random", out, episodes=1, **SHORT)
    assert main(["replay", str(out), "0"]) == 0
    folder = RolloutFolder(out)
    actions, final_qpos = folder.actions(0)
    actions[2, 0] += 1e-4
    folder.write_actions(0, actions, final_qpos)
    capsys.readouterr()
    assert main(["replay", str(out), "0"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert not found["final_positions_equal"] and 0 < found["largest_difference"] < 1e-3 and found["recorded"] == found["replayed"]


def test_a_replay_wants_the_environment_of_the_rollout(environment: EnvironmentFolder, tmp_path: Path) -> None:
    moved = tmp_path / "moved"
    shutil.copytree(environment.folder, tmp_path / "environment")
    rollout([tmp_path / "environment"], "random", tmp_path / "out", episodes=1, **SHORT)
    (tmp_path / "environment").rename(moved)
    with pytest.raises(ValueError, match="is no folder"):
        replay(tmp_path / "out", 0)
    assert replay(tmp_path / "out", 0, moved)["equal"]
    (moved / DESCRIPTION).write_text((moved / DESCRIPTION).read_text() + " ")
    with pytest.raises(ValueError, match="has not the files that episode 0"):
        replay(tmp_path / "out", 0, moved)
    with pytest.raises(ValueError, match="has no finished episode 3; it has 1 of 1"):
        replay(tmp_path / "out", 3, moved)
    with pytest.raises(ValueError, match="is no rollout"):
        replay(moved, 0)


def test_workers_change_no_episode(environment: EnvironmentFolder, tmp_path: Path) -> None:
    other = tmp_path / "other"
    shutil.copytree(environment.folder, other)
    order: dict[str, Any] = {"episodes": 10, "seed": 3, **SHORT}
    for name, workers in (("one", 1), ("three", 3)):
        rollout([environment.folder, other], "random", tmp_path / name, workers=workers, **order)
    one, three = (RolloutFolder(tmp_path / name) for name in ("one", "three"))
    assert len(one.records()) == 10 and lasting(one.records()) == lasting(three.records())
    assert {record["reason"] for record in one.records()} == {"time"}
    for number in range(10):
        assert one.actions(number)[0].shape == (6, 8)
        assert (one.folder / f"actions/{number:06d}.npz").read_bytes() == (three.folder / f"actions/{number:06d}.npz").read_bytes()
    assert len({one.actions(number)[0].tobytes() for number in range(10)}) == 10


def test_a_killed_rollout_goes_on_where_it_was(environment: EnvironmentFolder, policies: Path, tmp_path: Path) -> None:
    out, whole = tmp_path / "out", tmp_path / "whole"
    words = ["rollout", environment.folder, "--policy", f"{policies}:slow", "--episodes", "10", "--no-images", "--max-duration", "0.6"]
    with subprocess.Popen(command(*words, "--out", out, "--workers", "2"), stdout=subprocess.DEVNULL) as process:
        wait_for(lambda: lines_in(out) >= 3)
        process.kill()
    pids = [int(path.stem) for path in policies.parent.glob("*.pid")]
    assert len(pids) == 2
    # Workers of a killed process end by themselves.
    wait_for(lambda: not any(is_running(pid) for pid in pids), 30.0)
    before = (out / "episodes.jsonl").read_bytes()
    with open(out / "episodes.jsonl", "ab") as file:
        file.write(b'{"episode": 9, "succ')
    done = subprocess.run(command(*words, "--out", out), capture_output=True, text=True, check=True)
    after = (out / "episodes.jsonl").read_bytes()
    assert after.startswith(before) and 3 <= before.count(b"\n") < 10
    assert len(done.stdout.splitlines()) == 10 - before.count(b"\n") + 1
    assert [record["episode"] for record in RolloutFolder(out).records()] == list(range(10))
    subprocess.run(command(*words, "--out", whole), capture_output=True, check=True)
    assert lasting(RolloutFolder(out).records()) == lasting(RolloutFolder(whole).records())


def is_running(pid: int) -> bool:
    with contextlib.suppress(ProcessLookupError, FileNotFoundError):
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    return False


@pytest.mark.parametrize("workers", [1, 2])
def test_an_interrupt_ends_cleanly(workers: int, environment: EnvironmentFolder, policies: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = ["rollout", environment.folder, "--policy", f"{policies}:slow", "--episodes", "30", "--no-images", "--max-duration", "0.4"]
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "start_new_session": True}
    with subprocess.Popen(command(*words, "--out", out, "--workers", workers), **pipes) as process:
        wait_for(lambda: lines_in(out) >= 2)
        # As a terminal does it: to all processes.
        os.killpg(process.pid, signal.SIGINT)
        said = process.communicate()[1]
    assert process.returncode == 130 and "Traceback" not in said and f"kept in {out}, and the same command continues" in said
    finished = lines_in(out)
    assert 2 <= finished < 30
    assert json.loads((out / "summary.json").read_text())["overall"]["episodes"] == finished
    assert not any(path.suffix == ".part" for path in out.rglob("*"))


def test_a_worker_that_dies_is_named_and_loses_nothing(environment: EnvironmentFolder, policies: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = command("rollout", environment.folder, "--policy", f"{policies}:stops", "--out", out, "--workers", "2", "--no-images")
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "ended with exit code 7; finished episodes are kept" in done.stderr
    assert lines_in(out) == 0 and json.loads((out / "summary.json").read_text())["overall"]["rate"] is None


@pytest.mark.parametrize("workers", [1, 2])
def test_a_policy_that_cannot_be_made_ends_the_rollout(
    workers: int, environment: EnvironmentFolder, policies: Path, tmp_path: Path
) -> None:
    with pytest.raises((ValueError, WorkerFailedError), match="actless returned a object without reset and act"):
        rollout([environment.folder], f"{policies}:actless", tmp_path / "out", workers=workers, **SHORT)
    assert lines_in(tmp_path / "out") == 0


@pytest.mark.parametrize(
    ("policy", "steps", "said"),
    [
        ("raising", 2, "RuntimeError: no idea"),
        ("short", 0, r"an action of shape \(3,\) was given, where one has 8 numbers: joint1_rad"),
        ("infinite", 1, "8 finite numbers"),
    ],
)
def test_an_error_of_a_policy_ends_its_episode_only(
    policy: str, steps: int, said: str, environment: EnvironmentFolder, policies: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    found = rollout([environment.folder], f"{policies}:{policy}", out, episodes=2, **SHORT)
    assert found["reasons"] == {"policy_error": 2} and found["overall"]["successes"] == 0
    for record in RolloutFolder(out).records():
        assert record["steps"] == steps and re.search(said, record["error"])
        assert record["predicates"][0]["reason"] == "no_contact"
        assert replay(out, record["episode"])["equal"]


def test_a_rollout_of_another_request_is_refused(environment: EnvironmentFolder, policies: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    rollout([environment.folder], f"{policies}:slow", out, episodes=1, **SHORT)
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    for other in ({"seed": 1}, {"episodes": 2}, {"action_mode": "tool"}, {"object_poses": True}):
        with pytest.raises(ValueError, match=f"another request .{next(iter(other))}: .* before, .* now"):
            rollout([environment.folder], f"{policies}:slow", out, **{"episodes": 1, **SHORT, **other})
    policies.write_text(POLICIES + "# changed\n", encoding="utf-8")
    with pytest.raises(ValueError, match="policy_digest"):
        rollout([environment.folder], f"{policies}:slow", out, episodes=1, **SHORT)
    with pytest.raises(ValueError, match="own.py is a file"):
        rollout([environment.folder], "random", policies, episodes=1, **SHORT)
    with pytest.raises(ValueError, match="has files, but is no rollout"):
        rollout([environment.folder], "random", policies.parent, episodes=1, **SHORT)
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before


def test_one_process_at_a_time_runs_a_rollout(environment: EnvironmentFolder, tmp_path: Path) -> None:
    out, refused = tmp_path / "out", []

    def finished(_: Any) -> None:
        with pytest.raises(ValueError, match="another process runs the rollout"):
            rollout([environment.folder], "random", out, episodes=1, **SHORT)
        refused.append(True)

    rollout([environment.folder], "random", out, episodes=1, finished=finished, **SHORT)
    assert refused == [True]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--policy", "what"], "names no policy; give random, recorded:DATASET"),
        (["--policy", "missing.py:made"], "missing.py, which is to make the policy, cannot be imported"),
        (["--policy", "json:nothing"], "json has no function 'nothing'"),
        (["--policy", "lerobot:nowhere"], "nowhere is no folder"),
        (["--policy", "recorded:nowhere"], "no dataset to read in nowhere"),
        (["--policy", "random", "--episodes", "0"], "0 episodes with seed 0"),
        (["--policy", "random", "--workers", "0"], "0 workers run nothing"),
        (["--policy", "random", "--max-duration", "0"], "episodes of 0.0 s have no step"),
        (["--policy", "random", "--rename", "a"], "--rename takes NAME=OTHER"),
    ],
)
def test_what_cannot_be_run_is_refused(
    words: list[str], said: str, environment: EnvironmentFolder, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["rollout", str(environment.folder), "--out", str(tmp_path / "out"), *words]) == 2
    assert said in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_environments_of_one_policy_are_alike(environment: EnvironmentFolder, tmp_path: Path) -> None:
    other = tmp_path / "other"
    shutil.copytree(environment.folder, other)
    document = json.loads((other / DESCRIPTION).read_text(encoding="utf-8"))
    (other / DESCRIPTION).write_text(json.dumps({**document, "fps": 50}), encoding="utf-8")
    with pytest.raises(ValueError, match="at 50 steps per second, .* at 15; run a policy in them one by one"):
        rollout([environment.folder, other], "random", tmp_path / "out", **SHORT)
    with pytest.raises(ValueError, match="is named twice"):
        rollout([environment.folder, environment.folder], "random", tmp_path / "out", **SHORT)


# The protocol of openpi as its client 0.1.2 has it, written apart from what is tested.
def openpi_packed(value: Any) -> bytes:
    def encoded(one: Any) -> Any:
        if isinstance(one, np.ndarray):
            return {b"__ndarray__": True, b"data": one.tobytes(), b"dtype": one.dtype.str, b"shape": one.shape}
        raise TypeError(type(one))

    content: bytes = msgpack.packb(value, default=encoded)
    return content


def openpi_unpacked(content: bytes) -> Any:
    def decoded(one: Any) -> Any:
        if b"__ndarray__" in one:
            return np.ndarray(buffer=one[b"data"], dtype=np.dtype(one[b"dtype"]), shape=one[b"shape"])
        return one

    return msgpack.unpackb(content, object_hook=decoded)


HORIZON = 4


class OpenpiServer:
    """A server of a policy whose rows of actions are its number of answers, and then counted, around the state."""

    def __init__(self) -> None:
        self.seen: list[dict[str, Any]] = []
        self.failing: str | None = None
        self.columns, self.failing_for, self.hangs_up_after = 8, 10**9, 10**9
        self._server: Server | None = None
        self.port = 0

    def __enter__(self) -> OpenpiServer:
        self._server = serve(self._answer, "127.0.0.1", self.port, compression=None, max_size=None)
        self.port = self._server.socket.getsockname()[1]
        self.thread = threading.Thread(target=self._server.serve_forever)
        self.thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        assert self._server is not None
        self._server.shutdown()
        self.thread.join()

    @property
    def address(self) -> str:
        return f"ws://127.0.0.1:{self.port}"

    def _answer(self, connection: ServerConnection) -> None:
        connection.send(openpi_packed({"model": "counts"}))
        with contextlib.suppress(ConnectionClosed):
            while len(self.seen) < self.hangs_up_after:
                observation = openpi_unpacked(connection.recv())  # type: ignore[arg-type]
                self.seen.append(observation)
                if self.failing is not None and len(self.seen) <= self.failing_for:
                    # As openpi's own server does, which ends the connection then.
                    connection.send(self.failing)
                    return
                connection.send(openpi_packed(self.answer(observation)))

    def answer(self, observation: dict[str, Any]) -> dict[str, Any]:
        rows = np.tile(observation[STATE][: self.columns], (HORIZON, 1)) + 0.01 * np.arange(HORIZON)[:, None]
        return {"actions": rows, "state": observation[STATE], "policy_timing": {"infer_ms": 1.5}}


def observation_of(place: int) -> dict[str, Any]:
    return {STATE: (np.arange(29) + place).astype(np.float32), "observation.images.front": np.full((4, 4, 3), place, np.uint8)}


# Packed by `openpi_client.msgpack_numpy` 0.1.2.
OPENPI_MESSAGE = bytes.fromhex(
    "84b16f62736572766174696f6e2e737461746584c40b5f5f6e6461727261795f5fc3c40464617461c4080000003f0000a0bf"
    "c4056474797065a33c6634c40573686170659102b86f62736572766174696f6e2e696d616765732e66726f6e7484c40b5f5f"
    "6e6461727261795f5fc3c40464617461c40c000102030405060708090a0bc4056474797065a37c7531c40573686170659302"
    "0203a670726f6d7074ac6c696674207468652063616ea57363616c6583c40d5f5f6e7067656e657269635f5fc3c404646174"
    "61cb4004000000000000c4056474797065a33c6634"
)


def test_messages_have_the_bytes_of_openpi() -> None:
    value: dict[str, Any] = {
        "observation.state": np.array([0.5, -1.25], np.float32),
        "observation.images.front": np.arange(12, dtype=np.uint8).reshape(2, 2, 3),
        "prompt": "lift the can",
        "scale": np.float32(2.5),
    }
    assert msgpack.packb(value, default=packed) == OPENPI_MESSAGE
    read = unpacked(OPENPI_MESSAGE)
    assert read["prompt"] == "lift the can" and read["scale"] == 2.5 and type(read["scale"]) is np.float32
    for name in ("observation.state", "observation.images.front"):
        assert np.array_equal(read[name], value[name]) and read[name].dtype == value[name].dtype


def test_values_without_portable_bytes_are_refused() -> None:
    for value in (np.array([None]), np.array([1j])):
        with pytest.raises(ValueError, match="cannot be sent"):
            msgpack.packb(value, default=packed)
    with pytest.raises(TypeError, match="a set cannot be sent"):
        msgpack.packb({1}, default=packed)
    with pytest.raises(PolicyFailedError, match="no message of openpi's protocol"):
        unpacked(msgpack.packb({b"__ndarray__": True, b"data": b"", b"dtype": "|O", b"shape": (0,)}))
    with pytest.raises(PolicyFailedError, match="no message of openpi's protocol"):
        unpacked(b"\x81\xa1")


def test_rows_of_a_server_are_carried_out_one_by_one(description: Description) -> None:
    with OpenpiServer() as server:
        with contextlib.closing(ServerPolicy(server.address, description, chunk=3)) as policy:
            assert policy.metadata == {"model": "counts"}
            policy.reset({"instruction": "lift the can"})
            given = [policy.act(observation_of(place)) for place in range(5)]
            # The second answer is that to the fourth observation.
            expected = [np.arange(8) + base + 0.01 * row for base, row in ((0, 0), (0, 1), (0, 2), (3, 0), (3, 1))]
            assert np.allclose(given, expected, atol=1e-6)
            policy.reset({"instruction": "drop the can"})
            assert np.allclose(policy.act(observation_of(9)), np.arange(8) + 9)
        assert [one["prompt"] for one in server.seen] == ["lift the can", "lift the can", "drop the can"]
        assert server.seen[1]["observation.images.front"].tolist() == np.full((4, 4, 3), 3).tolist()


# It connects in a way that later versions of websockets advise against.
@pytest.mark.filterwarnings("ignore:connect:DeprecationWarning")
def test_openpis_own_client_gets_the_same_answers(description: Description) -> None:
    client = pytest.importorskip("openpi_client.websocket_client_policy", reason="openpi-client is not installed")
    with OpenpiServer() as server:
        theirs = client.WebsocketClientPolicy("127.0.0.1", server.port)
        with contextlib.closing(ServerPolicy(server.address, description)) as ours:
            assert theirs.get_server_metadata() == ours.metadata == {"model": "counts"}
            for place in range(3):
                observation = {**observation_of(place), "prompt": "lift the can"}
                assert np.array_equal(theirs.infer(observation)["actions"].astype(np.float32), ours.actions(observation))
        theirs._ws.close()
        # Both sent the same.
        for first, second in zip(server.seen[::2], server.seen[1::2], strict=True):
            assert first.keys() == second.keys() and all(np.array_equal(first[name], second[name]) for name in first)


def test_a_server_acts_in_a_rollout(environment: EnvironmentFolder, tmp_path: Path) -> None:
    with OpenpiServer() as server:
        order: dict[str, Any] = {**SHORT, "images": True, "episodes": 2, "chunk": 2}
        order["rename"] = {"observation.images.front": "observation/image"}
        found = rollout([environment.folder], server.address, tmp_path / "out", **order)
    assert found["reasons"] == {"time": 2}
    # Six steps of an episode, two of each answer.
    assert len(server.seen) == 6
    assert set(server.seen[0]) == {STATE, "observation/image", "observation.images.wrist", "prompt"}
    assert server.seen[0]["observation/image"].shape == (48, 48, 3) and server.seen[0]["prompt"] == "put the can on the plate"
    actions = RolloutFolder(tmp_path / "out").actions(0)[0]
    assert np.allclose(actions[1] - actions[0], 0.01, atol=1e-6)


def test_a_server_that_fails_ends_the_episode_and_one_that_is_gone_the_rollout(environment: EnvironmentFolder, tmp_path: Path) -> None:
    out, order = tmp_path / "out", {"episodes": 5, "chunk": 2, **SHORT}
    server = OpenpiServer()
    # Two episodes of one answer each, one of three, and the first two answers of another.
    server.failing, server.failing_for, server.hangs_up_after = "Traceback: no such key", 2, 7
    with server:
        with pytest.raises(PolicyUnavailableError, match="the connection to ws://127.0.0.1:.* ended"):
            rollout([environment.folder], server.address, out, **order)
    records = RolloutFolder(out).records()
    assert [record["reason"] for record in records] == ["policy_error", "policy_error", "time"]
    assert "no such key" in records[0]["error"]
    server.hangs_up_after = 10**9
    with server:
        found = rollout([environment.folder], server.address, out, **order)
    assert found["reasons"] == {"policy_error": 2, "time": 3}


def test_other_numbers_of_a_server_are_refused(description: Description) -> None:
    with OpenpiServer() as server:
        server.columns = 7
        with contextlib.closing(ServerPolicy(server.address, description)) as policy:
            policy.reset({"instruction": ""})
            with pytest.raises(PolicyFailedError, match=r"actions. of shape .horizon, 8. is expected, not .4, 7."):
                policy.act(observation_of(0))
    with pytest.raises(ValueError, match="a chunk of 0 actions"):
        ServerPolicy(server.address, description, chunk=0)
    with pytest.raises(PolicyUnavailableError, match="no policy server answered at ws://127.0.0.1:.* within 0.6 s"):
        ServerPolicy(server.address, description, connect_s=0.6)


def checkpoint_config(inputs: dict[str, tuple[int, ...]], numbers: int) -> Any:
    features = {name: SimpleNamespace(shape=shape) for name, shape in inputs.items()}
    return SimpleNamespace(input_features=features, output_features={"action": SimpleNamespace(shape=(numbers,))})


@pytest.mark.parametrize(
    ("config", "said"),
    [
        (checkpoint_config({"observation.images.top": (3, 48, 48)}, 8), "observes 'observation.images.top', which the environment"),
        (checkpoint_config({"observation.environment_state": (7,)}, 8), "add --object-poses"),
        (checkpoint_config({STATE: (14,)}, 8), "observes 14 numbers as observation.state, the environment has 29"),
        (checkpoint_config({STATE: (29,)}, 22), "actions of 22 numbers, the mode 'joint' .* has 8; choose another --action-mode"),
    ],
)
def test_a_policy_that_was_trained_on_other_data_is_refused(config: Any, said: str, description: Description) -> None:
    with pytest.raises(ValueError, match=said):
        refuse_others("checkpoint", config, description)


def test_a_policy_that_was_trained_on_such_data_is_accepted(environment: EnvironmentFolder) -> None:
    env = SceneEnv(folder=environment.folder, action_mode="recorded")
    whole = description_of(env, environment, "recorded", {})
    env.close()
    refuse_others("checkpoint", checkpoint_config({STATE: (29,), "observation.images.front": (3, 48, 48)}, 22), whole)


def test_lerobot_that_is_missing_is_named(description: Description, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match="is no checkpoint of LeRobot: it has no config.json"):
        LeRobotPolicy(str(tmp_path), description)
    (tmp_path / "config.json").write_text("{}")
    monkeypatch.setitem(sys.modules, "lerobot", None)
    with pytest.raises(MissingPackageError, match="pip install lerobot"):
        LeRobotPolicy(str(tmp_path), description)


def checkpoint(kind: str, folder: Path, dataset: RecordedDataset) -> None:
    """A small policy of LeRobot that was never trained, with numbers in the range of a dataset."""
    torch, factory = imported("torch"), imported("lerobot.policies.factory")
    kinds = imported("lerobot.configs.types")

    def feature(kind: str, *shape: int) -> Any:
        return kinds.PolicyFeature(kinds.FeatureType(kind), shape)

    inputs = {STATE: feature("STATE", 29), "observation.images.front": feature("VISUAL", 3, 48, 48)}
    features: dict[str, Any] = {"input_features": inputs, "output_features": {"action": feature("ACTION", 22)}, "device": "cpu"}
    features["pretrained_backbone_weights"] = None
    if kind == "act":
        small: dict[str, Any] = {"dim_model": 32, "n_heads": 2, "dim_feedforward": 32, "n_encoder_layers": 1, "use_vae": False}
        small |= {"chunk_size": 5, "n_action_steps": 3}
    else:
        small = {"down_dims": (16, 32), "num_inference_steps": 3, "crop_shape": None, "diffusion_step_embed_dim": 16, "n_groups": 4}
        small |= {"horizon": 8, "n_action_steps": 3}
    config = factory.make_policy_config(kind, **features, **small)
    torch.manual_seed(0)
    frames = dataset.frames(0)
    rows = {name: torch.from_numpy(frames[name]) for name in (STATE, "action")}
    stats = {
        name: {"mean": row.mean(0), "std": row.std(0) + 0.01, "min": row.amin(0), "max": row.amax(0) + 0.01} for name, row in rows.items()
    }
    pixels = {"mean": 0.5, "std": 0.25, "min": 0.0, "max": 1.0}
    stats["observation.images.front"] = {name: torch.full((3, 1, 1), value) for name, value in pixels.items()}
    factory.get_policy_class(kind)(config).save_pretrained(folder)
    for processor in factory.make_pre_post_processors(policy_cfg=config, dataset_stats=stats):
        processor.save_pretrained(folder)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", ["act", "diffusion"])
def test_a_checkpoint_acts_as_in_lerobots_own_evaluation(
    kind: str, environment: EnvironmentFolder, task_episodes: RecordedDataset, tmp_path: Path
) -> None:
    pytest.importorskip("lerobot", reason="LeRobot is not installed")
    torch, factory = imported("torch"), imported("lerobot.policies.factory")
    folder, out = tmp_path / "pretrained_model", tmp_path / "out"
    checkpoint(kind, folder, task_episodes)
    found = rollout([environment.folder], f"lerobot:{folder}", out, episodes=2, max_duration_s=0.8)
    assert found["reasons"] == {"time": 2}
    record = RolloutFolder(out).records()[1]

    class Started(LeRobotEnv):
        def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
            return super().reset(seed=seed, options={"start": record["start"]})

    def made() -> LeRobotEnv:
        return Started(SceneEnv(folder=environment.folder, action_mode="recorded", max_duration_s=0.8))

    vector: Any = SyncVectorEnv([made], autoreset_mode=AutoresetMode.SAME_STEP)
    config = imported("lerobot.configs.policies").PreTrainedConfig.from_pretrained(folder)
    policy = factory.get_policy_class(config.type).from_pretrained(folder, config=config)
    overrides = {"device_processor": {"device": "cpu"}}
    before, after = factory.make_pre_post_processors(policy_cfg=config, pretrained_path=str(folder), preprocessor_overrides=overrides)
    same = imported("lerobot.processor.pipeline").PolicyProcessorPipeline(steps=[])
    evaluated = imported("lerobot.scripts.lerobot_eval").rollout
    torch.manual_seed(record["seed"])
    expected = evaluated(vector, policy.eval(), same, same, before, after, seeds=[record["seed"]])["action"][0].numpy()
    vector.close()
    own = RolloutFolder(out).actions(1)[0]
    assert own.shape == (12, 22) and np.ptp(own, axis=0).max() > 0 and np.array_equal(own, expected)
