"""Suites: what is frozen, what is refused, what a result states, and how results are ordered."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from tabletopgen.env.__main__ import main
from tabletopgen.env.counterexample_axes import AXES
from tabletopgen.env.folder import EnvironmentFolder
from tabletopgen.env.folder_digest import digest_of_folder
from tabletopgen.env.recorded_dataset import RecordedDataset
from tabletopgen.env.suite import DOCUMENT, FORMAT, Suite, digest_of_document
from tabletopgen.env.suite_build import build
from tabletopgen.env.suite_leaderboard import leaderboard
from tabletopgen.env.suite_order import DEFAULT, SuiteOrder, file_of, level_of
from tabletopgen.env.suite_result import FORMAT as OF_RESULT
from tabletopgen.env.suite_result import counts, run_suite
from tabletopgen.env.suite_statement import STATED, missing

EXPERT = "tabletopgen.env.suite_expert:SuiteExpert"
# The can has no opening for the sponge.
TASKS = {"lift": {"table": "lift the can"}, "nest": "put the sponge into the can"}
SMALL: dict[str, Any] = {
    "name": "small",
    "version": "1",
    "seed": 5,
    "starts": 1,
    "cameras": ["front"],
    "size_px": 32,
    "tasks": TASKS,
    "variations": {
        "plain": {"randomize": {"position_m": 0.02}},
        "dim": {"randomize": "none", "change": {"light_intensity": 0.5, "camera_turn_rad": 0.1}},
    },
}
# Episodes of six steps.
SHORT: dict[str, Any] = {"images": False, "max_duration_s": 0.4}


@pytest.fixture(scope="module")
def order(task_scene: Path) -> Path:
    """The file of a suite of two environments, beside the bundle that it names."""
    path = task_scene.with_name("small.json")
    path.write_text(json.dumps({**SMALL, "scenes": {"table": {"bundle": task_scene.name}}}), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def suite(order: Path) -> Suite:
    """That suite, built without a stop."""
    return build(order, order.with_name("suite"))


@pytest.fixture(scope="module")
def results(suite: Suite) -> dict[str, Path]:
    """Results of two policies in it."""
    found = {name: suite.folder.with_name(f"run_{name}") for name in ("expert", "random")}
    run_suite(suite.folder, EXPERT, found["expert"], name="expert", trained_on="the starts of the suite", images=False)
    run_suite(suite.folder, "random", found["random"], trained_on="nothing", **SHORT)
    return found


def written(folder: Path, **parts: Any) -> Path:
    """The file of a suite with other parts."""
    path = folder / "other.json"
    path.write_text(json.dumps({**SMALL, "scenes": {"table": {"text": "a table"}}, **parts}), encoding="utf-8")
    return path


def test_the_suite_of_the_package_has_twelve_environments() -> None:
    read = SuiteOrder.read(file_of(DEFAULT))
    assert [len(read.scenes), len(read.tasks), len(read.variations), len(read.combinations())] == [3, 2, 2, 12]


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({"scenes": {}}, "scenes: Dictionary should have at least 1 item"),
        ({"scenes": {"table": {"text": "a table", "bundle": "scene"}}}, "a scene has either a text or a bundle"),
        ({"scenes": {"A table": {"text": "a table"}}}, "scenes.A table"),
        ({"tasks": {"place": {"desk": "lift the can"}}}, "tasks name the scenes desk, which are not among table"),
        ({"variations": {"dim": {"change": {"light": 0.5}}}}, "there is no axis light; choose among mass_factor"),
        ({"variations": {"dim": {"change": {"light_intensity": 3}}}}, "light_intensity of 3.0 is beyond 0.3 to 1.6; stay within"),
        ({"variations": {"dim": {"change": {"color": "pink"}}}}, "color is no 'pink'; give red, green"),
        ({"variations": {"turned": {"change": {"camera_turn_rad": 0.1}}}, "cameras": []}, "change what no camera observes"),
        ({"variations": {"dim": {"randomise": "usual"}}}, "variations.dim.randomise: Extra inputs are not permitted"),
        ({"starts": 0}, "starts: Input should be greater than or equal to 1"),
    ],
)
def test_a_file_that_describes_no_suite_is_refused(parts: dict[str, Any], said: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="describes no suite") as refused:
        SuiteOrder.read(written(tmp_path, **parts))
    assert said in str(refused.value)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("light_intensity", 0.3),
        ("light_intensity", 0.5),
        ("light_intensity", 1.0),
        ("light_intensity", 1.6),
        ("light_elevation_rad", -0.9),
        ("light_elevation_rad", 0.1),
        ("clutter", 3),
    ],
)
def test_values_of_axes_are_those_that_are_given(name: str, value: float) -> None:
    assert AXES[name].value(level_of(AXES[name], value)) == pytest.approx(value)


def test_a_suite_has_what_can_be_done_and_lists_the_rest(suite: Suite, task_scene: Path) -> None:
    assert sorted(suite.environments) == ["table-lift-dim", "table-lift-plain"] and suite.starts == 2
    left_out = suite.document["left_out"]
    assert [one["name"] for one in left_out] == ["table-nest-plain", "table-nest-dim"]
    assert all("soda_can_1 has no opening" in one["reason"] for one in left_out)
    plain, dim = (EnvironmentFolder.read(suite.folder / "environments" / f"table-lift-{name}") for name in ("plain", "dim"))
    for files in (plain, dim):
        assert digest_of_folder(files.folder) == suite.environments[files.folder.name]["digest"]
        assert len(RecordedDataset(suite.folder / "episodes" / files.folder.name).frames(files.starts[0].episode)["action"]) > 10
    assert dim.starts[0].cameras[0].turn_rad == pytest.approx((0.0, 0.1, 0.0))
    assert plain.task == dim.task and plain.cameras[0].width_px == 32
    scene, varied = (json.loads((one / "scene.json").read_text()) for one in (task_scene, dim.scene))
    assert varied["light"]["intensity"] == pytest.approx(0.5) and scene.get("light") != varied["light"]
    page = (suite.folder / "README.md").read_text(encoding="utf-8")
    assert suite.identity["digest"] in page and "has no opening" in page and all(f"| `{path}` |" in page for path in STATED)
    assert not (suite.folder / "parts").exists()


def test_an_interrupted_build_goes_on_to_the_same_digest(
    order: Path, suite: Suite, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    words = ["suite", "build", str(order), "--out", str(out)]
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "start_new_session": True}
    with subprocess.Popen([sys.executable, "-m", "tabletopgen.env", *words], **pipes) as process:
        until_s = time.monotonic() + 120
        while not (out / "combinations.jsonl").is_file() and time.monotonic() < until_s:
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGINT)
        said = process.communicate()[1]
    assert process.returncode == 130 and "Traceback" not in said and f"kept in {out}, and the same command continues" in said
    made = (out / "combinations.jsonl").read_bytes()
    assert 1 <= made.count(b"\n") < 4 and not (out / DOCUMENT).exists()
    with pytest.raises(ValueError, match="is no finished suite"):
        Suite.read(out)
    assert main(words) == 0
    assert (out / "combinations.jsonl").read_bytes().startswith(made)
    *combinations, found = map(json.loads, capsys.readouterr().out.splitlines())
    assert len(combinations) == 4 - made.count(b"\n") and found["digest"] == suite.identity["digest"] and found["left_out"] == 2
    assert Suite.read(out).document["files"] == suite.document["files"]
    before = (out / DOCUMENT).stat().st_mtime_ns
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out) == found and (out / DOCUMENT).stat().st_mtime_ns == before


def test_a_suite_of_another_file_and_one_without_tasks_are_refused(suite: Suite, task_scene: Path, tmp_path: Path) -> None:
    scenes = {"scenes": {"table": {"bundle": str(task_scene)}}}
    with pytest.raises(ValueError, match="the suite of another request .starts: 1 before, 2 now"):
        build(written(tmp_path, starts=2, **scenes), suite.folder)
    with pytest.raises(ValueError, match="no combination of small can be done .table-nest-plain: .*has no opening"):
        build(written(tmp_path, tasks={"nest": TASKS["nest"]}, **scenes), tmp_path / "none")
    with pytest.raises(ValueError, match="is no folder of a bundle: it has no manifest.json"):
        build(written(tmp_path, scenes={"table": {"bundle": "absent"}}), tmp_path / "none")
    with pytest.raises(ValueError, match="is no file of a suite; name one, or the suite 'default' of the package"):
        build(tmp_path / "absent.json", tmp_path / "none")


def changed(suite: Suite, folder: Path, name: str) -> Path:
    """A copy of a suite in which a file has another byte."""
    shutil.copytree(suite.folder, folder)
    with open(folder / name, "a") as file:
        file.write(" ")
    return folder


def test_a_changed_suite_is_refused_by_the_name_of_its_file(suite: Suite, order: Path, tmp_path: Path) -> None:
    name = "environments/table-lift-dim/starts.jsonl"
    folder = changed(suite, tmp_path / "suite", name)
    with pytest.raises(ValueError, match=f"is not the suite that was frozen .changed: {name}.; copy it again"):
        run_suite(folder, "random", tmp_path / "out", trained_on="nothing", **SHORT)
    with pytest.raises(ValueError, match=f"changed: {name}"):
        build(order, folder)
    (folder / name).unlink()
    (folder / "scenes" / "new.json").touch()
    with pytest.raises(ValueError, match=f"missing: {name}; added: scenes/new.json"):
        Suite.read(folder).refuse_changed()
    document = json.loads((folder / DOCUMENT).read_text())
    document["environments"][0]["instruction"] = "lift the plate"
    (folder / DOCUMENT).write_text(json.dumps(document))
    with pytest.raises(ValueError, match="suite.json was changed since it was frozen"):
        Suite.read(folder)


def test_a_result_states_all_that_it_must(suite: Suite, results: dict[str, Path]) -> None:
    found = {name: json.loads((folder / "result.json").read_text()) for name, folder in results.items()}
    for one in found.values():
        assert missing(one) == [] and one["suite"] == suite.identity and one["versions"]["program"].startswith("tabletopgen ")
    expert, random = found["expert"], found["random"]
    assert expert["overall"]["successes"] == expert["episodes"] == 2 and expert["reasons"] == {"done": 2}
    assert expert["outcomes"] == {"table-lift-plain": ["done"], "table-lift-dim": ["done"]}
    assert random["overall"]["successes"] == 0 and random["policy"]["name"] == "random" and random["policy"]["digest"] is None
    assert random["conditions"]["max_duration_s"] == 0.4 and not random["conditions"]["images"]
    assert {name: [row["value"] for row in rows] for name, rows in random["by"].items()} == {
        "task": ["lift"],
        "scene": ["table"],
        "variation": ["dim", "plain"],
        "environment": ["table-lift-dim", "table-lift-plain"],
    }


def test_a_run_that_was_stopped_has_no_result_until_it_goes_on(suite: Suite, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    class StoppedError(Exception):
        pass

    def stop(_: Any) -> None:
        raise StoppedError

    out = tmp_path / "out"
    with pytest.raises(StoppedError):
        run_suite(suite.folder, "random", out, trained_on="nothing", finished=stop, **SHORT)
    with pytest.raises(ValueError, match="result.json does not exist: the run is not finished; give the same `suite run`"):
        leaderboard(suite.folder, [out], tmp_path / "leaderboard.json")
    words = ["suite", "run", str(suite.folder), "--policy", "random", "--trained-on", "nothing", "--no-images", "--max-duration", "0.4"]
    assert main([*words, "--out", str(out)]) == 0
    episode, found = map(json.loads, capsys.readouterr().out.splitlines())
    assert episode["reason"] == "time" and (found["policy"], found["episodes"], found["digest"]) == ("random", 2, suite.identity["digest"])
    with pytest.raises(ValueError, match="state what the policy was trained on"):
        run_suite(suite.folder, "random", out, trained_on=" ")


def test_a_leaderboard_has_what_results_state(
    suite: Suite, results: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "leaderboard.json"
    assert main(["suite", "leaderboard", str(suite.folder), *map(str, results.values()), "--out", str(out)]) == 0
    assert [one["policy"] for one in json.loads(capsys.readouterr().out)["results"]] == ["expert", "random"]
    rows = json.loads(out.read_text())["results"]
    # Two episodes separate no policies.
    assert [row["rank"] for row in rows] == [1, 1] and rows[0]["tied_with"] == ["random"]
    stated = json.loads((results["expert"] / "result.json").read_text())
    assert {name: rows[0][name] for name in stated} == stated
    page = out.with_suffix(".md").read_text(encoding="utf-8")
    assert "| 1 | expert | 2 | 2 | 1.000 | 0.342 to 1.000 | random |" in page and "the starts of the suite" in page


def imagined(folder: Path, starts: int, version: str = "1") -> Suite:
    """The document of a suite whose environments are nowhere."""
    own = {"instruction": "lift the can", "starts": starts, "digest": "0"}
    environments = [{"name": f"can-{task}-usual", "scene": "can", "task": task, "variation": "usual", **own} for task in ("lift", "place")]
    document = {"format": FORMAT, "name": "imagined", "version": version, "environments": environments, "files": {}}
    folder.mkdir()
    (folder / DOCUMENT).write_text(json.dumps({"digest": digest_of_document(document), **document}))
    return Suite.read(folder)


def result_in(suite: Suite, folder: Path, name: str, successes: Sequence[int]) -> Path:
    """A result with so many successes in each environment, without the records of a run."""
    ends = zip(suite.environments.items(), successes, strict=True)
    outcomes = {where: ["done"] * count + ["time"] * (one["starts"] - count) for (where, one), count in ends}
    conditions = {"seed": 0, "action_mode": "joint", "chunk": None, "images": True, "object_poses": False, "max_duration_s": None}
    versions = {path.removeprefix("versions."): "1" for path in STATED if path.startswith("versions.")}
    document = {
        "format": OF_RESULT,
        "suite": suite.identity,
        "policy": {"name": name, "given_as": "own.py:made", "digest": "0", "trained_on": "nothing"},
        "conditions": {**conditions, "rename": {}},
        **counts(suite, outcomes),
        "versions": versions,
    }
    path = folder / f"{name}.json"
    path.write_text(json.dumps(document))
    return path


def test_results_are_ordered_and_overlapping_intervals_tied(tmp_path: Path) -> None:
    suite = imagined(tmp_path / "suite", 20)
    successes = {"weak": (1, 2), "good": (17, 18), "fair": (14, 15), "best": (20, 20), "alike": (15, 14)}
    paths = [result_in(suite, tmp_path, name, counts) for name, counts in successes.items()]
    rows = leaderboard(suite.folder, paths, tmp_path / "leaderboard.json")["results"]
    assert [(row["policy"]["name"], row["rank"], row["tied_with"]) for row in rows] == [
        ("best", 1, ["good"]),
        ("good", 1, ["alike", "best", "fair"]),
        ("alike", 2, ["fair", "good"]),
        ("fair", 2, ["alike", "good"]),
        ("weak", 5, []),
    ]
    page = (tmp_path / "leaderboard.md").read_text(encoding="utf-8")
    assert "| policy | lift | place |" in page and "| fair | 14 of 20 (0.48 to 0.85) | 15 of 20 (0.53 to 0.89) |" in page


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("suite.digest", "0" * 64, "is a result in the suite imagined 1 .000000000000., not in imagined 1 .*; run the policy in this one"),
        ("policy.trained_on", "", "does not state policy.trained_on; run `suite run` again"),
        ("versions.mujoco", None, "does not state versions.mujoco"),
        ("outcomes", {"can-lift-usual": ["done"] * 3}, "has not one outcome from each start of can-place-usual; give the same"),
        ("outcomes", {"can-lift-usual": ["done"] * 3, "can-place-usual": ["done"]}, "has not one outcome .* of can-place-usual"),
        ("overall.successes", 5, "does not agree with its outcomes in overall; give the same"),
        ("reasons", {"done": 6}, "does not agree with its outcomes in reasons"),
        ("format", "tabletopgen-rollout/1", "is no result of `suite run`"),
    ],
)
def test_what_is_no_result_of_the_suite_is_refused(path: str, value: Any, said: str, tmp_path: Path) -> None:
    suite = imagined(tmp_path / "suite", 3)
    file = result_in(suite, tmp_path, "own", (2, 2))
    document = json.loads(file.read_text())
    above, _, name = path.rpartition(".")
    (document[above] if above else document)[name] = value
    file.write_text(json.dumps(document))
    with pytest.raises(ValueError, match=said):
        leaderboard(suite.folder, [file], tmp_path / "leaderboard.json")
    assert not (tmp_path / "leaderboard.json").exists()


def test_names_are_listed_once_and_versions_are_not_mixed(tmp_path: Path) -> None:
    first, second = imagined(tmp_path / "first", 3), imagined(tmp_path / "second", 3, version="2")
    file = result_in(first, tmp_path, "own", (2, 2))
    with pytest.raises(ValueError, match="several results are named own; give the same `suite run` another --name"):
        leaderboard(first.folder, [file, file], tmp_path / "leaderboard.json")
    with pytest.raises(ValueError, match="is a result in the suite imagined 1 .*, not in imagined 2"):
        leaderboard(second.folder, [file], tmp_path / "leaderboard.json")
    with pytest.raises(ValueError, match="is the name of the page"):
        leaderboard(first.folder, [file], tmp_path / "leaderboard.md")


def test_a_result_is_counted_again_from_the_records_beside_it(suite: Suite, results: dict[str, Path], tmp_path: Path) -> None:
    run = tmp_path / "run"
    shutil.copytree(results["random"], run)
    document = json.loads((run / "result.json").read_text())
    better = {**document, **counts(suite, {name: ["done"] for name in suite.environments})}
    (run / "result.json").write_text(json.dumps(better))
    with pytest.raises(ValueError, match="does not agree with the records beside it in overall, by, reasons, outcomes"):
        leaderboard(suite.folder, [run], tmp_path / "leaderboard.json")
    (run / "result.json").write_text(json.dumps({**document, "conditions": {**document["conditions"], "max_duration_s": None}}))
    with pytest.raises(ValueError, match="does not agree with the records beside it in conditions"):
        leaderboard(suite.folder, [run], tmp_path / "leaderboard.json")
    (run / "result.json").write_text(json.dumps(document))
    lines = (run / "episodes.jsonl").read_text().splitlines(keepends=True)
    (run / "episodes.jsonl").write_text(lines[0])
    with pytest.raises(ValueError, match="has 1 of 2 episodes; give the same `suite run` to finish it"):
        leaderboard(suite.folder, [run], tmp_path / "leaderboard.json")
