"""Webhooks by the Standard Webhooks specification: the check of a signature, with the standard library alone."""

from __future__ import annotations

import base64
import binascii
import hashlib
import hmac
import json
import time
from collections.abc import Mapping
from typing import Any

PREFIX = "whsec_"
TOLERANCE_SECS = 300


class WebhookVerificationError(ValueError):
    """A message that does not come from the server that has the secret, or that came at another time."""


def verify(
    payload: bytes | str,
    headers: Mapping[str, str],
    secret: str,
    *,
    tolerance_secs: float = TOLERANCE_SECS,
    now: float | None = None,
) -> Any:
    """The message as JSON, if one of its signatures was made with the secret and it was sent lately.

    `payload` is the body byte for byte, as it came. `now` is the time in seconds since 1970; the clock's by default.

    Raises `WebhookVerificationError`: answer such a request with 400, and do not act on it.
    """
    body = payload.encode() if isinstance(payload, str) else payload
    named = {name.lower(): value for name, value in headers.items()}
    try:
        message_id, sent_at, signatures = (named[f"webhook-{part}"] for part in ("id", "timestamp", "signature"))
    except KeyError as missing:
        raise WebhookVerificationError(f"the request has no header {missing}") from None
    try:
        age_secs = (time.time() if now is None else now) - int(sent_at)
    except ValueError:
        raise WebhookVerificationError("webhook-timestamp is no whole number of seconds") from None
    if abs(age_secs) > tolerance_secs:
        when = "old" if age_secs > 0 else "in the future"
        raise WebhookVerificationError(f"the message is {abs(age_secs):.0f} s {when}; at most {tolerance_secs:.0f} s are allowed")
    signed = b".".join((message_id.encode(), sent_at.encode(), body))
    wanted = base64.b64encode(hmac.new(key_of(secret), signed, hashlib.sha256).digest())
    versions = (part.partition(",") for part in signatures.split(" "))
    if not any(version == "v1" and hmac.compare_digest(wanted, given.encode()) for version, _, given in versions):
        raise WebhookVerificationError("no signature of the message was made with this secret")
    return json.loads(body)


def key_of(secret: str) -> bytes:
    """The bytes of a secret such as `whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw`."""
    try:
        key = base64.b64decode(secret.removeprefix(PREFIX), validate=True)
    except binascii.Error:
        key = b""
    if not key:
        raise ValueError(f"the secret of a webhook is {PREFIX} and base64; give it as the server showed it")
    return key
