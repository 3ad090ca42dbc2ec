"""Keys, the record of changes, webhooks and what the server says of itself."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Iterator
from datetime import timedelta
from pathlib import Path

import pytest

from conftest import SETTINGS
from fake import AT, JOB_ID, Answer, Fake, Received, stream
from tabletopgen import AsyncClient, Client, Scene, SceneFilters, errors, webhooks


@pytest.fixture(scope="module")
def operator(program: Path) -> Iterator[Client]:
    """A client of a server that may send webhooks to this machine."""
    with Client(settings={**SETTINGS, "webhooks.hosts": "127.0.0.1"}, progress=False) as made:
        yield made


def received(fake: Fake, count: int) -> list[Received]:
    """The messages of a webhook, once there are so many."""
    ends = time.monotonic() + 20
    while len(fake.received) < count:
        assert time.monotonic() < ends, f"{len(fake.received)} of {count} messages came"
        time.sleep(0.05)
    return fake.received


def test_a_webhook_is_made_tested_changed_and_deleted(operator: Client) -> None:
    with Fake([Answer(204)]) as fake:
        webhook = operator.create_webhook(f"{fake.url}/hook", events=["scene.succeeded"], description="of a test")
        assert webhook.state == "enabled" and webhook.secret and webhook.data.events == ["scene.succeeded"]
        first = webhook.test()
        message = received(fake, 1)[0]
        assert message.headers["webhook-id"] == first.id and message.path == "/hook"
        assert webhooks.verify(message.body, message.headers, webhook.secret)["type"] == "webhook.test"
        assert [delivery.id for delivery in webhook.deliveries()] == [first.id]
        assert webhook.replay(first).id == first.id
        assert received(fake, 2)[1].headers["webhook-id"] == first.id

        secret = webhook.secret
        assert webhook.rotate_secret().secret not in (None, secret)
        webhook.test()
        last = received(fake, 3)[2]
        for known in (secret, webhook.secret):
            assert known and webhooks.verify(last.body, last.headers, known)

        webhook.change(state="disabled", events=[], description="off")
        assert (webhook.state, webhook.data.events, webhook.data.description) == ("disabled", [], "off")
        assert [other.id for other in operator.webhooks()] == [operator.webhook(webhook.id).id] == [webhook.id]
        assert operator.webhooks()[0].secret is None
        webhook.delete()
        assert operator.webhooks() == []
        with pytest.raises(errors.NotFoundError):
            webhook.refresh()


def test_an_address_that_is_not_allowed_is_refused(operator: Client) -> None:
    with pytest.raises(errors.InvalidRequestError) as refused:
        operator.create_webhook("http://10.0.0.1/")
    assert refused.value.pointers == ["/url"]


def test_keys_are_made_listed_and_revoked_and_that_is_recorded(operator: Client) -> None:
    key = operator.create_key("robot lab", ["read", "submit"], expires_in_secs=3600)
    assert key.key and key.key.startswith("tt_") and key.expires_at and key.expires_at > key.created_at
    (listed,) = operator.keys()
    assert (listed.id, listed.scopes, listed.key, listed.revoked_at) == (key.id, ["read", "submit"], None, None)
    operator.revoke_key(key)
    operator.revoke_key(str(key.id))
    assert next(iter(operator.keys())).revoked_at
    assert [entry.action for entry in operator.audit(since=key.created_at)] == ["revokeKey", "revokeKey", "createKey"]
    assert list(operator.audit(since=key.created_at + timedelta(days=1))) == []


def test_the_server_says_what_it_has(client: Client) -> None:
    mug = next(category for category in client.catalog() if category.name == "mug")
    assert mug.label == "mug" and mug.affordances
    panda = next(robot for robot in client.robots() if robot.name == "panda")
    assert panda.dof == 7 and panda.gripper
    assert {"text", "seed", "options"} <= set(client.settings_schema()["properties"])
    queue = client.queue()
    assert queue.paused is None and queue.storage == "ok"


def test_scenes_are_filtered_and_counted(client: Client, made: Scene) -> None:
    every: SceneFilters = {"label": "made:once", "verdict": "pass", "kind": "text", "category": "apple", "q": "MUG desk", "min_objects": 2}
    found = list(client.scenes(sort="oldest", **every))
    assert [scene.id for scene in found] == [made.id]
    assert list(client.scenes(label="made:once", max_objects=1)) == []
    assert list(client.scenes(label="made:once", created_after=made.data.created_at + timedelta(seconds=1))) == []
    facets = client.facets(label="made:once")
    assert (facets.total, facets.verdict, facets.kind) == (1, {"pass": 1}, {"text": 1})
    assert facets.category == {"mug": 1, "apple": 1} and facets.label["made=once"] == 1


def test_events_of_the_tenant_are_followed_from_any_of_them(client: Client, made: Scene) -> None:
    assert made.data.job
    seen = []
    for event in client.events(after=0):
        seen.append(event)
        if event.job_id == made.data.job.id and event.kind == "job_succeeded":
            break
    assert [event.seq for event in seen] == sorted({event.seq for event in seen})
    mine = [event for event in seen if event.job_id == made.data.job.id]
    assert mine[0].kind == "job_queued" and [event.number for event in mine] == [event.seq for event in made.events()]
    assert next(iter(client.events(after=seen[0].seq))).seq == seen[1].seq


def test_events_to_come_are_not_lost_where_the_stream_breaks_before_the_first() -> None:
    first = {"seq": 42, "number": 1, "at": AT, "kind": "job_queued", "job_id": JOB_ID, "job_kind": "generate", "data": {}}
    first |= dict.fromkeys(("scene_id", "dataset_id", "recording_id"))
    begun = b": what follows is new\nid: 41\nretry: 2000\n\n"
    with Fake([stream(begun), stream(b"id: 42\ndata: " + json.dumps(first).encode() + b"\n\n")]) as fake:
        with Client(fake.url, progress=False) as client:
            assert next(iter(client.events())).seq == 42
    assert "last-event-id" not in fake.received[0].headers and fake.received[1].headers["last-event-id"] == "41"


def test_the_asynchronous_client_does_the_same(operator: Client) -> None:
    async def all_of_it() -> None:
        async with AsyncClient(operator._connection.url, progress=False) as other:
            assert [robot.name for robot in await other.robots()] == [robot.name for robot in operator.robots()]
            assert len(await other.catalog()) > 100 and (await other.queue()).storage == "ok"
            assert (await other.settings_schema())["properties"] and (await other.session()).scopes
            key = await other.create_key("lab", ["read"])
            every = other.keys()
            assert key.id in [listed.id async for listed in every]
            await other.revoke_key(key)
            assert [entry.action async for entry in other.audit(since=key.created_at)][:2] == ["revokeKey", "createKey"]
            webhook = await other.create_webhook("http://127.0.0.1:1/", events=["webhook.test"])
            delivery = await webhook.test()
            assert [one.id async for one in webhook.deliveries()] == [delivery.id]
            assert (await webhook.replay(delivery.id)).id == delivery.id
            assert (await (await webhook.rotate_secret()).change(state="disabled")).state == "disabled"
            assert [one.id for one in await other.webhooks()] == [(await other.webhook(webhook.id)).id]
            await webhook.delete()
            assert (await other.facets()).total == 0 and [scene.id async for scene in other.scenes(verdict="pass")] == []
            with pytest.raises(errors.WaitTimeoutError):
                async for event in other.events(timeout_secs=0.2):
                    pytest.fail(f"nothing was submitted, but {event}")

    asyncio.run(all_of_it())
