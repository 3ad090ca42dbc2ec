"""Requests, streams and downloads over HTTP, repeated where that is safe."""

from __future__ import annotations

import hashlib
import json
import tempfile
import time
from collections.abc import AsyncGenerator, AsyncIterator, Callable
from contextlib import aclosing
from pathlib import Path
from typing import Protocol, TypeVar

import httpx
from pydantic import BaseModel

from tabletopgen import models
from tabletopgen._async import io
from tabletopgen._local_server import LocalServer
from tabletopgen._requests import Query, Request, get
from tabletopgen._retries import Attempts
from tabletopgen._sse import Parser, SentEvent
from tabletopgen.errors import ApiError, ConnectionFailedError, DownloadDamagedError, WaitTimeoutError, refusal

M = TypeVar("M", bound=BaseModel)
T = TypeVar("T")

# The server sends a line every 15 s.
STREAM_SILENCE_SECS = 45.0
STREAM = "text/event-stream"
PAGE_SIZE = 100
JOB_ENDED = ("job_succeeded", "job_failed", "job_cancelled")
ENDED = 204
PARTIAL = 206


class Page(Protocol):
    """Some items of a list, and the token of the next ones."""

    next_page_token: str | None


P = TypeVar("P", bound=Page)


class AsyncConnection:
    """A server, and how patiently it is asked."""

    def __init__(
        self,
        url: str,
        key: str | None,
        local: LocalServer | None,
        patience_secs: float,
        timeout_secs: float,
        progress: bool | None,
        transport: httpx.AsyncBaseTransport | None,
    ):
        headers = {"authorization": f"Bearer {key}"} if key else {}
        # A local server is asked directly, whatever proxy the environment names.
        self.http = httpx.AsyncClient(headers=headers, timeout=timeout_secs, transport=transport, trust_env=local is None)
        self.url = url.rstrip("/")
        self.local = local
        self.patience_secs = patience_secs
        self.progress = progress
        self.files = tempfile.TemporaryDirectory(prefix="tabletopgen-files-")
        # What was unpacked there, by name.
        self.kept: dict[str, Path] = {}

    async def address(self, path: str) -> str:
        """The URL of a path. A local server that does not run is started."""
        if self.local is not None:
            self.url = await io.blocking_call(self.local.start)
        return f"{self.url}{path}"

    async def send(self, request: Request) -> httpx.Response:
        """The answer, which is no refusal."""
        attempts = Attempts(self.patience_secs, request.repeatable)
        while True:
            try:
                response = await self.http.request(
                    request.method,
                    await self.address(request.path),
                    params=request.query or None,
                    headers=request.headers,
                    content=request.content,
                    timeout=request.timeout_secs or self.http.timeout,
                    # A server may have files in a bucket, and send its address.
                    follow_redirects=request.method == "GET",
                )
                if response.status_code < 400:
                    return response
            except httpx.TransportError as error:
                await self.pause(attempts, error, request)
            else:
                await self.pause(attempts, response, request)

    async def pause(self, attempts: Attempts, failure: httpx.Response | httpx.TransportError, request: Request) -> None:
        """Waits before the next attempt, or raises where there is none."""
        secs = attempts.pause_secs(failure)
        if secs is not None:
            await io.sleep(secs)
        elif isinstance(failure, httpx.Response):
            await failure.aread()
            raise refusal_of(failure, str(request))
        else:
            words = str(failure) or type(failure).__name__
            raise ConnectionFailedError(f"{request} got no answer from {self.url}: {words}") from failure

    async def ask(self, request: Request, model: type[M]) -> M:
        """The answer as one of the models."""
        return model.model_validate_json((await self.send(request)).content)

    async def pages(
        self, path: str, parse: Callable[[bytes], P], items: Callable[[P], list[T]], query: Query | None = None
    ) -> AsyncIterator[T]:
        """Every item of a list, page by page."""
        token: str | None = None
        while True:
            answer = await self.send(get(path, {**(query or {}), "page_size": PAGE_SIZE, "page_token": token}))
            page = parse(answer.content)
            for item in items(page):
                yield item
            token = page.next_page_token
            if token is None:
                return

    async def events(
        self, path: str, model: type[M], is_last: Callable[[M], bool], after: int | None = 0, timeout_secs: float | None = None
    ) -> AsyncIterator[M]:
        """Events as they happen, until their subject has ended; those to come where `after` is None. A stream that
        breaks off goes on after the last one."""
        deadline = None if timeout_secs is None else time.monotonic() + timeout_secs
        request = Request("GET", path)
        attempts = Attempts(self.patience_secs, repeatable=True)
        while True:
            try:
                async with aclosing(self._stream(path, after, deadline)) as stream:
                    async for piece in stream:
                        # Also a line without an event says that the server is there.
                        attempts.renew(is_progress=bool(piece))
                        for sent in piece:
                            after = int(sent.id)
                            if not sent.data:
                                continue
                            event = model.model_validate_json(sent.data)
                            yield event
                            if is_last(event):
                                return
                        check_deadline(deadline, path)
                    return
            except httpx.TransportError as error:
                check_deadline(deadline, path)
                await self.pause(attempts, error, request)
            except StreamRefusedError as error:
                await self.pause(attempts, error.response, request)

    def job_events(self, job_id: str, after: int, timeout_secs: float | None) -> AsyncIterator[models.Event]:
        """Events of a job."""
        path = f"/jobs/{job_id}/events"
        return self.events(path, models.Event, lambda event: event.kind in JOB_ENDED, after, timeout_secs)

    async def _stream(self, path: str, after: int | None, deadline: float | None) -> AsyncGenerator[list[SentEvent], None]:
        """One stream, piece by piece. Raises a transport error where it ends before its subject has."""
        headers = {"accept": STREAM} | ({} if after is None else {"last-event-id": str(after)})
        silence = STREAM_SILENCE_SECS
        if deadline is not None:
            silence = min(silence, max(0.05, deadline - time.monotonic()))
        timeout = httpx.Timeout(self.http.timeout.connect, read=silence)
        async with self.http.stream("GET", await self.address(path), headers=headers, timeout=timeout) as response:
            if response.status_code == ENDED:
                return
            if response.status_code >= 400:
                await response.aread()
                raise StreamRefusedError(response)
            if response.headers.get("content-type", "").partition(";")[0] != STREAM:
                raise ConnectionFailedError(f"GET {path} was not answered with a stream of events; is {self.url} tabletopgen?")
            parser = Parser()
            async for piece in response.aiter_bytes():
                yield parser.feed(piece)
        # The next stream says whether there is more to come.
        raise httpx.RemoteProtocolError("the stream of events ended")

    async def download(self, path: str, target: Path, query: Query, is_tag_digest: bool = True) -> None:
        """Bytes into a file, which appears when it is whole. A connection that breaks is picked up where it broke.
        `is_tag_digest` says that the `ETag` is the SHA-256 of the bytes, which are compared with it."""
        request = get(path, query)
        partial = target.with_name(f"{target.name}.part")
        partial.unlink(missing_ok=True)
        attempts = Attempts(self.patience_secs, repeatable=True)
        while True:
            begun = partial.stat().st_size if partial.exists() else 0
            try:
                tag = await self._piece(request, partial, begun)
                break
            except httpx.TransportError as error:
                if partial.exists() and partial.stat().st_size > begun:
                    attempts.renew(is_progress=True)
                await self.pause(attempts, error, request)
            except StreamRefusedError as error:
                await self.pause(attempts, error.response, request)
        if is_tag_digest and await io.blocking_call(digest_of, partial) != tag:
            partial.unlink()
            raise DownloadDamagedError(f"{request} has other bytes than its ETag says; ask for it again")
        partial.replace(target)

    async def unpacked(
        self,
        path: str,
        folder: str | Path,
        unpack: Callable[[Path, Path], Path],
        query: Query | None = None,
        is_tag_digest: bool = True,
    ) -> Path:
        """An archive, unpacked into a folder; the path of its content."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder, prefix=".download-") as place:
            archive = Path(place) / "archive"
            await self.download(path, archive, query or {}, is_tag_digest)
            return await io.blocking_call(unpack, archive, folder)

    def place(self, name: str) -> Path:
        """The path of a folder that is removed with the client."""
        return Path(self.files.name) / name

    async def _piece(self, request: Request, partial: Path, begun: int) -> str:
        """Adds to a file what is missing; the `ETag` of the whole."""
        headers = {"accept-encoding": "identity"} | ({"range": f"bytes={begun}-"} if begun else {})
        address = await self.address(request.path)
        arguments = {"params": request.query or None, "headers": headers, "follow_redirects": True}
        async with self.http.stream("GET", address, **arguments) as response:  # type: ignore[arg-type]
            if response.status_code >= 400:
                await response.aread()
                raise StreamRefusedError(response)
            with open(partial, "ab" if response.status_code == PARTIAL else "wb") as file:
                async for piece in response.aiter_bytes():
                    file.write(piece)
            tag: str = response.headers.get("etag", "")
            return tag.strip('"')

    async def aclose(self) -> None:
        await self.http.aclose()
        self.files.cleanup()
        if self.local is not None:
            await io.blocking_call(self.local.stop)


class StreamRefusedError(Exception):
    """A stream or download that was answered with a refusal, until it is known whether it is asked for again."""

    def __init__(self, response: httpx.Response):
        self.response = response


def check_deadline(deadline: float | None, path: str) -> None:
    if deadline is not None and time.monotonic() > deadline:
        raise WaitTimeoutError(f"{path} has not ended in time; the server goes on with it")


def refusal_of(response: httpx.Response, request: str) -> ApiError:
    try:
        problem = json.loads(response.content)
    except ValueError:
        problem = None
    if not isinstance(problem, dict):
        problem = {"detail": response.text[:300].strip() or response.reason_phrase}
    return refusal(response.status_code, problem, request)


def digest_of(path: Path) -> str:
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while piece := file.read(1 << 20):
            digest.update(piece)
    return digest.hexdigest()
