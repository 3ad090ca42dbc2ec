"""Bodies and keys of requests."""

from __future__ import annotations

import base64
import hashlib
import io
import json
import secrets
import uuid
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any, Protocol, TypeAlias
from urllib.parse import quote

from pydantic import TypeAdapter

ANY: TypeAdapter[Any] = TypeAdapter(Any)
JSON = "application/json"


class Savable(Protocol):
    """An image of Pillow."""

    def save(self, fp: Any, format: str | None = None) -> None: ...


Image: TypeAlias = "str | Path | bytes | Savable"
Query: TypeAlias = "Mapping[str, str | float | bool | datetime | None]"


@dataclass(frozen=True)
class Request:
    """A request, as it is sent again after a failure."""

    method: str
    path: str
    query: Mapping[str, str] = field(default_factory=dict)
    headers: Mapping[str, str] = field(default_factory=dict)
    content: bytes | None = None
    # Whether it may arrive twice.
    repeatable: bool = True
    # Of the answer's next byte; the client's where none.
    timeout_secs: float | None = None

    def __str__(self) -> str:
        return f"{self.method} {self.path}"


def get(path: str, query: Query | None = None, timeout_secs: float | None = None) -> Request:
    return Request("GET", path, plain(query), timeout_secs=timeout_secs)


def post(
    path: str,
    body: Any = None,
    *,
    key: str | None = None,
    query: Query | None = None,
    media_type: str = JSON,
    repeatable: bool = False,
) -> Request:
    """A POST of JSON, or of bytes of the media type; with a key it may be repeated."""
    headers = {"idempotency-key": key} if key else {}
    content = body if body is None or isinstance(body, bytes) else dumped(body)
    if content is not None:
        headers["content-type"] = media_type
    return Request("POST", path, plain(query), headers, content, repeatable or key is not None)


def patch(path: str, changes: Any) -> Request:
    """A PATCH by JSON Merge Patch, which may arrive twice."""
    return Request("PATCH", path, headers={"content-type": "application/merge-patch+json"}, content=dumped(changes))


def delete(path: str, query: Query | None = None) -> Request:
    return Request("DELETE", path, plain(query))


def post_image(path: str, image: Image, request: Mapping[str, Any], key: str) -> Request:
    """A submission with the bytes of an image beside it, as a form; one with the address of an image, as JSON."""
    if isinstance(image, str) and image.startswith(("http://", "https://")):
        return post(path, {**request, "image": {"url": image}}, key=key)
    if isinstance(image, str) and image.startswith("data:"):
        return post(path, {**request, "image": {"base64": image}}, key=key)
    # Of 256 random bits it is in no image.
    boundary = secrets.token_hex(32)
    parts = [
        ('name="request"', JSON, dumped(request)),
        ('name="image"; filename="image"', "application/octet-stream", bytes_of(image)),
    ]
    lines = [
        f"--{boundary}\r\nContent-Disposition: form-data; {name}\r\nContent-Type: {kind}\r\n\r\n".encode() + data + b"\r\n"
        for name, kind, data in parts
    ]
    content = b"".join([*lines, f"--{boundary}--\r\n".encode()])
    return post(path, content, key=key, media_type=f"multipart/form-data; boundary={boundary}")


def bytes_of(image: Image) -> bytes:
    if isinstance(image, bytes):
        return image
    if isinstance(image, str | Path):
        return Path(image).read_bytes()
    file = io.BytesIO()
    image.save(file, "PNG")
    return file.getvalue()


def given(**fields: Any) -> dict[str, Any]:
    """Those fields that are not None."""
    return {name: value for name, value in fields.items() if value is not None}


def dumped(body: Any) -> bytes:
    """JSON of mappings, lists and models; of models, the fields that were set."""
    return ANY.dump_json(body, by_alias=True, exclude_unset=True)


def plain(query: Query | None) -> dict[str, str]:
    """Names and texts of a query, without those that are None."""
    return {name: text_of(value) for name, value in given(**query or {}).items()}


def text_of(value: str | float | bool | datetime) -> str:
    if isinstance(value, datetime):
        return value.isoformat()
    return str(value).lower() if isinstance(value, bool) else str(value)


def escaped(name: str) -> str:
    """A name as a part of a path."""
    return quote(name, safe="")


def new_key() -> str:
    return uuid.uuid4().hex


def key_of(body: Any, repetition: int = 0) -> str:
    """The key of a request by its content: the same for the same request, in whichever process. `repetition` counts
    equal requests that are meant to give several results."""
    content = json.dumps(json.loads(dumped(body)), sort_keys=True, separators=(",", ":"))
    digest = hashlib.sha256(f"{repetition}\n{content}".encode()).digest()
    return base64.urlsafe_b64encode(digest[:24]).decode()
