"""The client against the server itself."""

from __future__ import annotations

import asyncio
import hashlib
import importlib
import json
import os
import signal
import subprocess
import sys
import time
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import pytest

from conftest import SENTENCE, SETTINGS
from tabletopgen import AsyncClient, Client, Recording, Scene, errors
from tabletopgen._sync.connection import digest_of

mujoco: Any = importlib.import_module("mujoco")
IMAGE = Path(__file__).resolve().parents[3] / "docs" / "demo_table.png"


def test_a_sentence_becomes_a_scene(made: Scene) -> None:
    assert (made.ok, made.state, made.verdict, made.seed) == (True, "ready", "pass", 7)
    assert made.metrics and made.metrics.col_o == 0.0
    assert made.labels == {"made": "once"} and made.failure is None


def test_its_model_rests_in_mujoco(made: Scene) -> None:
    model = made.mujoco()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    before = data.body("mug_1").xpos.copy()
    for _ in range(500):
        mujoco.mj_step(model, data)
    assert abs(data.body("mug_1").xpos - before).max() < 0.005


def test_it_opens_in_usd_from_a_path(made: Scene) -> None:
    assert made.usd_path.name == "scene.usda" and made.usd_path.is_file()


def test_downloads_of_two_formats_come_into_one_folder(made: Scene, tmp_path: Path) -> None:
    first = made.download(tmp_path, format="glb")
    second = made.download(tmp_path, format="mjcf")
    assert first == second and {"glb", "mjcf"} <= {path.name for path in first.iterdir()} and not (first / "usd").exists()
    assert list(tmp_path.iterdir()) == [first]


def test_its_artifacts_come_as_what_they_are(made: Scene) -> None:
    artifacts = {artifact.name: artifact for artifact in made.artifacts()}
    image = next(name for name in artifacts if name.endswith(".png"))
    assert made.artifact(image).size[0] > 100
    content = made.artifact_bytes(image)
    assert hashlib.sha256(content).hexdigest() == artifacts[image].sha256
    document = next(name for name in artifacts if name.endswith(".json"))
    assert made.artifact(document) == json.loads(made.artifact_bytes(document))


def test_the_files_of_its_bundle_are_read_one_by_one(made: Scene) -> None:
    files = {file.name: file for file in made.files()}
    assert {"scene.json", "report.html", "mjcf/scene.xml", "glb/scene.glb"} <= set(files)
    content = made.file_bytes("glb/mug_1.glb")
    assert hashlib.sha256(content).hexdigest() == files["glb/mug_1.glb"].sha256
    assert {instance["name"] for instance in made.file("scene.json")["instances"]} == {"mug_1", "apple_1"}
    mug = next(instance for instance in made.file("scene.json")["instances"] if instance["name"] == "mug_1")
    # Files of GLB have +y up.
    assert sorted(made.file("glb/mug_1.glb").extents) == pytest.approx(sorted(mug["size_m"]), abs=1e-3)
    assert "mjcf/scene.xml" in made.file("README.md") and made.file("preview/hero.png").size[0] > 640
    with pytest.raises(errors.NotFoundError):
        made.file("no/such.file")


def test_its_preview_is_as_wide_as_asked(made: Scene) -> None:
    assert [made.preview(width).size for width in (160, 320, 640)] == [(160, 120), (320, 240), (640, 480)]


def test_its_events_can_be_read_again_from_any_of_them(made: Scene) -> None:
    events = list(made.events())
    assert (events[0].kind, events[-1].kind) == ("job_queued", "job_succeeded")
    assert [event.seq for event in made.events(after=events[3].seq)] == [event.seq for event in events[4:]]
    assert {stage.stage for stage in made.stages()} >= {"certify", "bundle"}


def test_it_is_a_card_in_a_notebook(made: Scene) -> None:
    card = made._repr_html_()
    assert made.id in card and "pass" in card and "data:image/jpeg;base64," in card, "the render"
    assert "<script" not in card


def test_labels_change_and_lists_find_scenes_by_them(client: Client, made: Scene) -> None:
    made.label(split="train", draft="yes")
    made.label({"draft": None})
    assert made.labels == made.refresh().labels == {"made": "once", "split": "train"}
    assert [scene.id for scene in client.scenes(label="split:train")] == [made.id]
    assert list(client.scenes(label="split:none")) == []


def test_lists_have_every_scene_on_however_many_pages(client: Client, made: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    others = [client.generate("a mug", seed=seed, not_before=None) for seed in range(3)]
    monkeypatch.setattr("tabletopgen._sync.connection.PAGE_SIZE", 1)
    ids = [scene.id for scene in client.scenes()]
    assert len(ids) == len(set(ids)) and {made.id, *(other.id for other in others)} <= set(ids)
    assert {str(job.scene_id) for job in client.jobs(kind="generate")} >= set(ids)
    for other in others:
        other.delete()
    with pytest.raises(errors.GoneError) as gone:
        client.scene(others[0].id)
    assert gone.value.code == "scene_deleted" and "data:image" not in others[0]._repr_html_()


def test_edits_and_variants_are_new_scenes(client: Client, made: Scene) -> None:
    edited = made.edit("remove the apple").wait()
    assert edited.ok and edited.id != made.id and edited.data.parent == made.data.id
    variants = [variant.wait() for variant in made.variants(2, seed=3, randomize={"layout": True})]
    assert len({made.id, edited.id, *(variant.id for variant in variants)}) == 4
    children = {str(child.id) for child in made.lineage().children}
    assert children == {edited.id, *(variant.id for variant in variants)}
    assert {scene.id for scene in client.scenes(parent=made.id)} == children


def test_edits_and_variants_are_understood_without_making_them(client: Client, made: Scene) -> None:
    before = made.lineage().children
    understood = made.validate_edit("remove the apple")
    assert understood.valid and understood.prediction
    drawn = made.validate_variants(2, seed=3, randomize={"layout": True}).requests
    assert len({request.seed for request in drawn}) == 2
    with pytest.raises(errors.InvalidRequestError):
        made.validate_edit("remove the sextant")
    assert made.lineage().children == before


def test_an_image_is_accepted(client: Client) -> None:
    scene = client.generate(image=IMAGE, seed=7)
    assert scene.data.request.input.kind == "image" and scene.state == "pending"
    # The README waits for one.
    scene.delete()


def test_a_refused_request_says_what_to_change(client: Client) -> None:
    with pytest.raises(errors.InvalidRequestError) as refused:
        client.generate("a mug", options={"max_objects": 65, "tables": 1})
    assert refused.value.code == "invalid_body" and refused.value.pointers and refused.value.detail
    with pytest.raises(errors.NotFoundError):
        client.scene("00000000-0000-7000-8000-000000000000")
    assert client.validate("two mugs", seed=1).valid


def test_operations_without_a_method_are_asked_by_path(client: Client) -> None:
    assert client.request("GET", "/readyz") == {"status": "ready"}
    pages = client.request("GET", "/jobs", query={"page_size": 1})
    assert set(pages) == {"jobs", "next_page_token"}
    with pytest.raises(errors.InvalidRequestError):
        client.request("POST", "/scenes", "no object")
    assert client.request("DELETE", f"/scenes/{client.generate('a mug').id}") is None


def test_a_key_repeated_with_another_body_is_refused(client: Client) -> None:
    first = client.generate("a mug", seed=1, idempotency_key="k")
    assert client.generate("a mug", seed=1, idempotency_key="k").id == first.id
    with pytest.raises(errors.InvalidRequestError) as refused:
        client.generate("a mug", seed=2, idempotency_key="k")
    assert refused.value.code == "idempotency_key_reused"
    assert not first.cancel().wait(check=False).ok or first.ok


def test_a_failed_job_says_why(client: Client) -> None:
    with pytest.raises(errors.WorkFailedError) as failed:
        client.generate("a mug and two spoons", seed=1, options={"max_objects": 1}).wait()
    assert failed.value.code and failed.value.detail


def test_tasks_are_proposed_and_read(made: Scene) -> None:
    proposed = made.tasks(count=2, rehearsed=False)
    assert proposed.robot == "panda" and proposed.proposed
    instructed = made.tasks(text="put the apple to the right of the mug", rehearsed=False).instructed
    assert instructed is not None


def test_a_robot_does_a_task(made: Scene, tmp_path: Path) -> None:
    execution = made.execute("lift the apple", seed=3, files=True).wait()
    folder = execution.download(tmp_path / "run")
    verdict = json.loads((folder / "execution.json").read_text())
    assert verdict["execution"]["succeeded"] in (True, False) and (folder / "trajectory.json").is_file()
    assert [event.kind for event in execution.events()][-1] == "job_succeeded"


def test_a_task_that_cannot_be_attempted_says_why(made: Scene) -> None:
    with pytest.raises(errors.ApiError) as refused:
        made.execute("put the sextant on the apple").wait()
    assert refused.value.code and refused.value.status in (409, 422)


def test_a_recording_becomes_a_dataset_for_lerobot(recorded: Recording, tmp_path: Path) -> None:
    assert (recorded.state, recorded.formats, recorded.data.attempts.get("success")) == ("finished", ["lerobot-v3.0"], 1)
    root = recorded.to_lerobot(tmp_path)
    assert json.loads((root / "meta" / "info.json").read_text())["total_episodes"] == 1
    listed = {file.path.removeprefix("lerobot-v3.0/"): file.sha256 for file in recorded.files()}
    assert listed == {str(path.relative_to(root)): digest_of(path) for path in root.rglob("*") if path.is_file()}
    assert [event.kind for event in recorded.events()][-2:] == ["assembling", "finished"]


def test_a_recording_is_followed_and_cancelled(client: Client, made: Scene) -> None:
    recording = made.record("lift the apple", count=1, formats=["lerobot-v3.0"])
    assert recording.id in [other.id for other in client.recordings(scene=made.id)]
    assert next(iter(recording.events())).kind == "queued"
    recording.cancel()
    with pytest.raises(errors.WorkFailedError, match="cancelled"):
        recording.wait()
    recording.delete()
    with pytest.raises(errors.GoneError):
        client.recording(recording.id)


def test_a_batch_gives_results_and_scenes(client: Client) -> None:
    batch = client.submit_batch(["a mug", "a plate", "a mug", "zorgle"], name="four").wait()
    counts = batch.data.request_counts
    assert (batch.state, counts.total) == ("finished", 4)
    assert [result.custom_id for result in batch.results()][:2] == ["request-000001", "request-000002"]
    assert [result.custom_id for result in batch.errors()] == ["request-000004"]
    assert len(list(batch.scenes())) >= 2
    assert client.batch(batch.id).id in [other.id for other in client.batches(state="finished")]
    recipe = {"templates": ["a {color} mug"], "slots": {"color": ["red", "blue"]}, "seeds": [1]}
    assert client.submit_batch(recipe=recipe).cancel().id
    batch.delete(scenes=True)


def test_a_dataset_is_frozen_verified_and_downloaded(client: Client, made: Scene, tmp_path: Path) -> None:
    dataset = client.freeze_dataset("kitchen", scenes=[made.id], splits={"train": 1.0}).wait()
    assert (dataset.state, dataset.data.version) == ("finished", 1)
    folder = dataset.download(tmp_path)
    assert {file.path for file in dataset.files()} == {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}
    assert json.loads(dataset.file("dataset.json"))
    verified = dataset.verify().wait().data.verification
    assert verified and verified.found and not verified.found.faults
    assert [other.id for other in client.datasets(name="kitchen")] == [dataset.id]
    dataset.delete()


def test_the_asynchronous_client_does_the_same(client: Client, made: Scene) -> None:
    async def several() -> list[str]:
        async with AsyncClient(client._connection.url, progress=False) as other:
            scenes = [await other.generate(SENTENCE, seed=7) for _ in range(2)]
            ended = await asyncio.gather(*(scene.wait() for scene in scenes))
            model = await ended[0].mujoco()
            assert model.nbody >= 4 and (await ended[0].usd_path).is_file()
            assert len([event async for event in ended[1].events()]) > 4
            assert "data:image" not in ended[0]._repr_html_(), "an image would have to be awaited"
            return [scene.id async for scene in other.scenes(label="made:once")]

    assert asyncio.run(several()) == [made.id]


def test_the_asynchronous_client_orders_all_kinds_of_work(client: Client, made: Scene, recorded: Recording, tmp_path: Path) -> None:
    async def several() -> None:
        async with AsyncClient(client._connection.url, progress=False) as other:
            scene = await other.scene(made.id)
            assert (await scene.file("scene.json"))["seed"] == 7 and (await scene.preview()).size == (320, 240)
            assert [file.name for file in await scene.files()] == [file.name for file in made.files()]
            assert (await scene.to_rerun(tmp_path / "scene.rrd")).is_file()
            assert (await scene.label(other="yes")).labels["other"] == "yes" and "other" not in (await scene.label(other=None)).labels
            assert (await scene.validate_edit("remove the apple")).valid and len((await scene.validate_variants(2)).requests) == 2
            execution = await (await scene.execute("lift the apple", seed=3)).wait()
            assert (await execution.result()).execution and (await other.execution(execution.id)).state == "succeeded"
            recording = await other.recording(recorded.id)
            assert (await recording.to_rerun(tmp_path / "episode.rrd")).is_file()
            assert [event.kind async for event in recording.events()][-1] == "finished"
            assert recorded.id in [one.id async for one in other.recordings(scene=made.id)]
            batch = await (await other.submit_batch(["a mug", "zorgle"], name="two")).wait()
            assert [len(await batch.results()), len(await batch.errors()), len([one async for one in batch.scenes()])] == [1, 1, 2]
            assert batch.id in [one.id async for one in other.batches()] and (await other.batch(batch.id)).state == "finished"
            dataset = await (await other.freeze_dataset("two", batch=batch.id, splits={"train": 1.0})).wait()
            assert (await dataset.download(tmp_path / "two")).is_dir() and (await (await dataset.verify()).wait()).state == "finished"
            assert [one.id async for one in other.datasets(name="two")] == [(await other.dataset(dataset.id)).id]
            await dataset.delete()
            await batch.delete(scenes=True)
            mapped = [one async for one in other.map(["a mug", "zorgle", "a mug"], seeds=[1], name="async")]
            assert [(one.ok, one.error is None) for one in mapped] == [(True, True), (False, False), (True, True)]
            again = [one async for one in other.map(["a mug", "zorgle", "a mug"], seeds=[1], name="async")]
            assert [one.scene and one.scene.id for one in again] == [one.scene and one.scene.id for one in mapped]

    asyncio.run(several())


def test_a_local_server_keeps_its_data_and_is_started_again_after_it_was_killed(program: Path, tmp_path: Path) -> None:
    with Client(data_dir=tmp_path / "data", settings=SETTINGS, progress=False) as first:
        scene = first.generate("a mug", seed=1, not_before=datetime(2100, 1, 1, tzinfo=timezone.utc))
        local = first._connection.local
        assert local is not None and local.process is not None
        server = int(subprocess.check_output(["pgrep", "-P", str(local.process.pid), "tabletopgen"], text=True).split()[0])
        os.kill(server, signal.SIGKILL)
        local.process.wait(20)
        assert first.scene(scene.id).state == "pending"
    with Client(data_dir=tmp_path / "data", settings=SETTINGS, progress=False) as second:
        assert second.scene(scene.id).state == "pending"

    async def of_the_asynchronous_client() -> str:
        async with AsyncClient(data_dir=tmp_path / "data", settings=SETTINGS, progress=False) as third:
            return (await third.scene(scene.id)).state

    assert asyncio.run(of_the_asynchronous_client()) == "pending"


def test_no_local_server_is_left_when_its_client_is_killed(program: Path, tmp_path: Path) -> None:
    script = (
        "import time; from tabletopgen import Client; c = Client(); print(c.version() and c._connection.url, flush=True); time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        url = process.stdout.readline().strip()
        process.kill()
    ends = time.monotonic() + 30
    with Client(url, patience_secs=0.1) as other:
        while time.monotonic() < ends:
            try:
                other.version()
                time.sleep(0.1)
            except errors.ConnectionFailedError:
                return
    pytest.fail("the server is still there")


def test_a_missing_program_is_an_error_that_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.delenv("TABLETOPGEN_URL", raising=False)
    with pytest.raises(errors.ProgramMissingError, match="pip install tabletopgen"):
        Client()


def test_a_local_server_that_does_not_start_shows_its_log(program: Path) -> None:
    with Client(settings={"no.such.setting": 1}) as broken, pytest.raises(errors.LocalServerError, match="no.such.setting"):
        broken.version()


def test_the_environment_names_server_and_key(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TABLETOPGEN_URL", client._connection.url)
    monkeypatch.setenv("TABLETOPGEN_API_KEY", "tt_secret")
    with Client() as other:
        assert other.version() == client.version()
        assert other._connection.http.headers["authorization"] == "Bearer tt_secret" and "secret" not in repr(other)
    with pytest.raises(ValueError, match="local server"):
        Client(data_dir="data")
