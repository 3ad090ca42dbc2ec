"""What the client does when a server refuses, breaks off or is slow; both clients are of one source."""

from __future__ import annotations

import asyncio
import hashlib
import json
import tarfile
import time
import zipfile
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import httpx
import pytest
import yaml

from fake import AT, SCENE_ID, Answer, Fake, Received, as_json, event, job, problem, scene, stream
from tabletopgen import AsyncClient, Client, errors, models
from tabletopgen._archive import unpack_tar
from tabletopgen._retries import Attempts, retry_after_secs

CONTRACT = Path(__file__).resolve().parents[3] / "openapi.yaml"


def asked(answers: list[Answer] | Callable[[Received], Answer], patience_secs: float = 20) -> tuple[Fake, Client]:
    fake = Fake(answers)
    return fake, Client(fake.url, "tt_key", patience_secs=patience_secs, progress=False)


@pytest.mark.parametrize("status,kind", [(429, "too-many-requests"), (503, "unavailable")])
def test_a_submission_refused_for_now_is_sent_again_with_the_same_key(status: int, kind: str) -> None:
    fake, client = asked([problem(status, kind, "busy", "1"), as_json(scene(), 202)])
    with fake, client:
        began = time.monotonic()
        assert client.generate("a mug", seed=7).id == SCENE_ID
        assert time.monotonic() - began >= 1, "Retry-After is kept"
    first, second = fake.received
    assert first.headers["idempotency-key"] == second.headers["idempotency-key"] != ""
    assert first.body == second.body == b'{"text":"a mug","seed":7}'
    assert first.headers["authorization"] == "Bearer tt_key"


def test_an_answer_that_breaks_off_is_asked_for_again_with_the_same_key() -> None:
    whole = as_json(scene(), 202)
    fake, client = asked([Answer(202, whole.body, whole.headers, cut=20), whole])
    with fake, client:
        assert client.generate("a mug").id == SCENE_ID
    assert len({received.headers["idempotency-key"] for received in fake.received}) == 1 and len(fake.received) == 2


def test_two_submissions_have_two_keys() -> None:
    fake, client = asked([as_json(scene(), 202)])
    with fake, client:
        client.generate("a mug")
        client.generate("a mug")
        client.generate("a mug", idempotency_key="mine")
    first, second, mine = (received.headers["idempotency-key"] for received in fake.received)
    assert first != second and mine == "mine"


def test_a_refusal_that_outlasts_the_patience_is_raised_at_once() -> None:
    fake, client = asked([problem(429, "too-many-requests", "spending_limit", "86400")], patience_secs=5)
    with fake, client, pytest.raises(errors.TooManyRequestsError) as refused:
        client.generate("a mug")
    assert len(fake.received) == 1
    assert refused.value.code == "spending_limit" and "do it otherwise" in str(refused.value)


def test_requests_without_a_key_are_not_repeated_when_their_answer_is_lost() -> None:
    def answered(received: Received) -> Answer:
        if received.path.endswith("/retry"):
            return Answer(202, b"{}" * 50, cut=10)
        return as_json(scene())

    fake, client = asked(answered)
    with fake, client:
        found = client.scene(SCENE_ID)
        with pytest.raises(errors.ConnectionFailedError):
            found.retry()
        assert [received.path for received in fake.received if received.method == "POST"] == [f"/jobs/{job()['id']}/retry"]


def test_no_server_is_an_error_that_names_it() -> None:
    with Client("http://127.0.0.1:1", patience_secs=0.5) as client, pytest.raises(errors.ConnectionFailedError) as failed:
        client.version()
    assert "http://127.0.0.1:1" in str(failed.value)


def test_a_slow_answer_is_given_up_and_asked_for_again() -> None:
    version = {"name": "tabletopgen", "version": "1", "studio": False}
    fake = Fake([Answer(200, b"{}", delay_secs=3), as_json(version)])
    with fake, Client(fake.url, timeout_secs=0.3) as client:
        assert client.version().version == "1"


def test_refusals_are_exceptions_by_type_with_pointers_and_advice() -> None:
    fault = {"pointer": "/options/max_objects", "detail": "at most 64"}
    fake, client = asked([problem(422, "invalid-request", "invalid_body", errors=[fault])])
    with fake, client, pytest.raises(errors.InvalidRequestError) as refused:
        client.generate("a mug", options={"max_objects": 65})
    assert (refused.value.code, refused.value.status) == ("invalid_body", 422)
    assert refused.value.pointers == ["/options/max_objects"]
    message = "POST /scenes: do it otherwise (invalid_body, status 422)\n  /options/max_objects: at most 64"
    assert str(refused.value) == message


def test_a_refusal_by_a_proxy_is_an_exception_too() -> None:
    fake, client = asked([Answer(418, b"<html>teapot</html>", {"content-type": "text/html"})])
    with fake, client, pytest.raises(errors.ApiError, match="teapot"):
        client.version()


def test_every_type_of_problem_of_the_contract_has_an_exception() -> None:
    contract = yaml.safe_load(CONTRACT.read_text(encoding="utf-8"))
    assert set(errors.BY_TYPE) == set(contract["components"]["schemas"]["ProblemType"]["enum"])


def events_answer(received: Received, cuts: list[int]) -> Answer:
    """Four events; each stream that `cuts` has a number for ends after so many bytes."""
    names = ["job_started", "stage_started", "stage_finished", "job_succeeded"]
    after = int(received.headers["last-event-id"])
    # A line separator of Unicode stands raw in JSON, and ends no line of the stream.
    parts = [event(seq, name, stage="st\u2028age") for seq, name in enumerate(names, 1) if seq > after]
    return stream(b": still here\n\n", *parts, cut=cuts.pop(0) if cuts else None)


@pytest.mark.parametrize("cuts", [[], [0], [20, 150, 210], [150, 150, 150], [400]])
def test_a_stream_of_events_that_is_cut_goes_on_after_the_last_one(cuts: list[int]) -> None:
    left = list(cuts)

    def answered(received: Received) -> Answer:
        return events_answer(received, left) if received.path.endswith("/events") else as_json(scene())

    fake, client = asked(answered)
    with fake, client:
        events = list(client.scene(SCENE_ID).events())
    assert [one.seq for one in events] == [1, 2, 3, 4] and events[0].data.stage == "st\u2028age"

    left = list(cuts)

    async def of_the_asynchronous_client() -> list[int]:
        with Fake(answered) as again:
            async with AsyncClient(again.url, progress=False) as other:
                return [one.seq async for one in (await other.scene(SCENE_ID)).events()]

    assert asyncio.run(of_the_asynchronous_client()) == [1, 2, 3, 4]


def test_waiting_ends_in_time_though_the_stream_is_silent() -> None:
    def answered(received: Received) -> Answer:
        if received.path.endswith("/events"):
            return Answer(200, b": still here\n\n" * 9, {"content-type": "text/event-stream"}, cut=14, delay_secs=0.1)
        return as_json(scene())

    fake, client = asked(answered)
    with fake, client:
        began = time.monotonic()
        with pytest.raises(errors.WaitTimeoutError):
            client.scene(SCENE_ID).wait(timeout_secs=1)
        assert time.monotonic() - began < 5


def test_a_failed_job_is_an_exception_unless_asked_otherwise() -> None:
    failure = {"class": "permanent", "code": "no_room", "message": "take a larger table"}
    failed = scene("failed", job=job("failed", failure=failure, finished_at=AT))
    fake, client = asked([as_json(failed)])
    with fake, client:
        found = client.scene(SCENE_ID)
        with pytest.raises(errors.WorkFailedError, match="take a larger table") as failing:
            found.wait()
        assert failing.value.code == "no_room"
        assert not found.wait(check=False).ok


def archive() -> bytes:
    file = BytesIO()
    with zipfile.ZipFile(file, "w") as made:
        made.writestr("scene-abc/scene.json", "{}" * 3000)
        made.writestr("scene-abc/mjcf/scene.xml", "<mujoco/>")
    return file.getvalue()


def test_a_download_that_is_cut_goes_on_where_it_broke(tmp_path: Path) -> None:
    content = archive()
    tag = {"etag": f'"{hashlib.sha256(content).hexdigest()}"'}

    def answered(received: Received) -> Answer:
        if not received.path.endswith("/bundle"):
            return as_json(scene("ready"))
        if given := received.headers.get("range"):
            begun = int(given.removeprefix("bytes=").removesuffix("-"))
            return Answer(206, content[begun:], tag)
        return Answer(200, content, tag, cut=100)

    fake, client = asked(answered)
    with fake, client:
        folder = client.scene(SCENE_ID).download(tmp_path / "out")
    assert folder == tmp_path / "out" / "scene-abc"
    assert (folder / "mjcf" / "scene.xml").read_text() == "<mujoco/>"
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["scene-abc"], "nothing is left beside it"
    assert fake.received[-1].headers["range"] == "bytes=100-"


def test_a_damaged_download_is_not_kept(tmp_path: Path) -> None:
    def answered(received: Received) -> Answer:
        if received.path.endswith("/bundle"):
            return Answer(200, archive(), {"etag": f'"{"0" * 64}"'})
        return as_json(scene("ready"))

    fake, client = asked(answered)
    with fake, client, pytest.raises(errors.DownloadDamagedError):
        client.scene(SCENE_ID).download(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_an_image_is_sent_as_a_form_with_its_bytes(tmp_path: Path) -> None:
    path = tmp_path / "table.png"
    path.write_bytes(b"\x89PNG bytes")
    fake, client = asked([as_json(scene(), 202)])
    with fake, client:
        client.generate("a mug", image=path, seed=3)
        client.generate(image="https://example.com/table.png")
        client.generate(image="data:image/png;base64,aGk=")
    form, named, inline = fake.received
    assert form.headers["content-type"].startswith("multipart/form-data; boundary=")
    assert b"\r\n\r\n\x89PNG bytes\r\n" in form.body and b'{"text":"a mug","seed":3}' in form.body
    assert json.loads(named.body) == {"image": {"url": "https://example.com/table.png"}}
    assert json.loads(inline.body) == {"image": {"base64": "data:image/png;base64,aGk="}}


def test_fields_that_were_not_set_are_not_sent_and_unknown_ones_are() -> None:
    fake, client = asked([as_json(scene(), 202)])
    with fake, client:
        client.generate("a mug", options=models.Options(max_objects=4))
        client.generate("a mug", options=models.Options.model_validate({"max_objetcs": 4}))
    assert [json.loads(received.body)["options"] for received in fake.received] == [{"max_objects": 4}, {"max_objetcs": 4}]


def test_map_takes_scenes_out_of_a_full_queue_before_it_gives_up() -> None:
    waiting: set[str] = set()

    def answered(received: Received) -> Answer:
        if received.method == "POST":
            if len(waiting) == 2:
                return problem(429, "too-many-requests", "queue_full", "60")
            waiting.add(received.headers["idempotency-key"])
            return as_json(scene(), 202)
        if received.path.endswith("/events"):
            waiting.pop()
            return stream(event(1, "job_succeeded"))
        return as_json(scene("ready", job=job("succeeded", finished_at=AT)))

    fake, client = asked(answered, patience_secs=1)
    with fake, client:
        results = list(client.map([f"a mug and {count} spoons" for count in range(2, 7)]))
    assert [result.index for result in results] == [0, 1, 2, 3, 4] and all(result.ok for result in results)


def test_map_gives_refused_requests_as_results_with_their_error() -> None:
    def answered(received: Received) -> Answer:
        if b"zorgle" in received.body:
            return problem(422, "invalid-request", "not_understood")
        return as_json(scene("ready", job=job("succeeded", finished_at=AT)), 202)

    fake, client = asked(answered)
    with fake, client:
        first, second = client.map(["a zorgle", "a mug"])
    assert isinstance(first.error, errors.InvalidRequestError) and first.scene is None
    assert second.ok and second.error is None


def test_keys_of_map_come_from_the_content_and_count_repetitions() -> None:
    fake, client = asked([as_json(scene("ready", job=job("succeeded", finished_at=AT)), 202)])
    with fake, client:
        for _ in range(2):
            list(client.map(["a mug", "a cup", "a mug"], seeds=[1, 2]))
    keys = [received.headers["idempotency-key"] for received in fake.received if received.method == "POST"]
    assert keys[:6] == keys[6:] and len(set(keys)) == 6


def test_retry_after_may_be_a_date() -> None:
    response = httpx.Response(503, headers={"retry-after": "Wed, 21 Oct 2015 07:28:00 GMT"})
    assert retry_after_secs(response) == 0
    assert retry_after_secs(httpx.Response(503, headers={"retry-after": "soon"})) == 0


def test_pauses_are_random_below_a_bound_that_doubles() -> None:
    attempts = Attempts(1000, repeatable=True, clock=lambda: 0)
    error = httpx.ReadError("cut")
    pauses = [attempts.pause_secs(error) for _ in range(12)]
    bounds = [min(0.2 * 2**k, 10) for k in range(12)]
    assert all(pause is not None and 0 <= pause <= bound for pause, bound in zip(pauses, bounds))
    assert len(set(pauses)) == 12


def test_an_archive_that_would_write_elsewhere_is_refused(tmp_path: Path) -> None:
    archive = tmp_path / "archive.tar"
    with tarfile.open(archive, "w") as made:
        made.addfile(tarfile.TarInfo("dataset/good"), BytesIO())
        made.addfile(tarfile.TarInfo("dataset/../../bad"), BytesIO())
    (tmp_path / "out").mkdir()
    with pytest.raises(ValueError, match="bad"):
        unpack_tar(archive, tmp_path / "out")
    assert list((tmp_path / "out").iterdir()) == [] and not (tmp_path / "bad").exists()
