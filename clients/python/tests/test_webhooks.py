"""Signatures of webhooks, beside the reference implementation of Standard Webhooks."""

from __future__ import annotations

import base64
import json
import secrets
from datetime import datetime, timezone

import pytest
from standardwebhooks.webhooks import Webhook

from tabletopgen import webhooks

SECRET = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw"
NOW = 1_800_000_000
BODY = json.dumps({"type": "scene.ready", "data": {"labels": {"name": "Tisch für zwei"}}}, ensure_ascii=False)


def headers(body: str = BODY, secret: str = SECRET, sent_at: int = NOW, message_id: str = "msg_1") -> dict[str, str]:
    """Those that the reference signs."""
    signature = Webhook(secret).sign(message_id, datetime.fromtimestamp(sent_at, timezone.utc), body)
    return {"webhook-id": message_id, "webhook-timestamp": str(sent_at), "webhook-signature": signature}


def test_a_message_that_the_reference_signed_is_accepted() -> None:
    for _ in range(50):
        secret = "whsec_" + base64.b64encode(secrets.token_bytes(24 + secrets.randbelow(40))).decode()
        body = json.dumps({"data": secrets.token_urlsafe(secrets.randbelow(200))})
        assert webhooks.verify(body, headers(body, secret), secret, now=NOW) == json.loads(body)
        assert webhooks.verify(body.encode(), headers(body, secret), secret.removeprefix("whsec_"), now=NOW)


def test_names_of_headers_may_have_any_case() -> None:
    named = {name.title(): value for name, value in headers().items()}
    assert webhooks.verify(BODY, named, SECRET, now=NOW)["type"] == "scene.ready"


def test_one_of_several_signatures_is_enough() -> None:
    given = headers()
    other = Webhook("whsec_" + base64.b64encode(b"x" * 24).decode()).sign("msg_1", datetime.fromtimestamp(NOW, timezone.utc), BODY)
    given["webhook-signature"] = f"v1a,abc {other} {given['webhook-signature']}"
    assert webhooks.verify(BODY, given, SECRET, now=NOW)


@pytest.mark.parametrize("age_secs,accepted", [(0, True), (300, True), (301, False), (-300, True), (-301, False)])
def test_messages_of_other_times_are_refused(age_secs: int, accepted: bool) -> None:
    given = headers(sent_at=NOW - age_secs)
    if accepted:
        webhooks.verify(BODY, given, SECRET, now=NOW)
    else:
        with pytest.raises(webhooks.WebhookVerificationError, match="at most 300 s"):
            webhooks.verify(BODY, given, SECRET, now=NOW)


@pytest.mark.parametrize("changed", ["body", "webhook-id", "webhook-timestamp", "webhook-signature", "version", "secret"])
def test_anything_that_was_changed_is_refused(changed: str) -> None:
    body, secret, given = BODY, SECRET, headers()
    if changed == "body":
        body = BODY.replace("ready", "ready ")
    elif changed == "secret":
        secret = "whsec_" + base64.b64encode(b"y" * 24).decode()
    elif changed == "version":
        given["webhook-signature"] = given["webhook-signature"].replace("v1,", "v2,")
    elif changed == "webhook-timestamp":
        given[changed] = str(NOW + 1)
    else:
        given[changed] = given[changed][:-2] + "x="
    with pytest.raises(webhooks.WebhookVerificationError):
        webhooks.verify(body, given, secret, now=NOW)


@pytest.mark.parametrize("missing", ["webhook-id", "webhook-timestamp", "webhook-signature"])
def test_a_missing_header_is_named(missing: str) -> None:
    given = headers()
    del given[missing]
    with pytest.raises(webhooks.WebhookVerificationError, match=missing):
        webhooks.verify(BODY, given, SECRET, now=NOW)


@pytest.mark.parametrize("secret", ["", "whsec_", "whsec_not base64!"])
def test_a_secret_that_is_none_is_the_callers_fault(secret: str) -> None:
    with pytest.raises(ValueError, match="whsec_"):
        webhooks.verify(BODY, headers(), secret, now=NOW)
