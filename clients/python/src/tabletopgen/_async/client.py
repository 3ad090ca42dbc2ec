"""The client: scenes, batches, datasets, recordings and jobs of a server."""

from __future__ import annotations

import os
from collections import Counter, deque
from collections.abc import AsyncIterator, Iterable, Mapping, Sequence, Sized
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import Any, Literal

import httpx
from typing_extensions import Unpack

from tabletopgen import _requests, models
from tabletopgen._async.administration import AsyncAdministration
from tabletopgen._async.batch import AsyncBatch
from tabletopgen._async.connection import AsyncConnection
from tabletopgen._async.dataset import AsyncDataset
from tabletopgen._async.execution import AsyncExecution
from tabletopgen._async.recording import AsyncRecording
from tabletopgen._async.scene import AsyncScene
from tabletopgen._filters import SceneFilters, query_of
from tabletopgen._local_server import LocalServer
from tabletopgen._progress import Bar
from tabletopgen._requests import Image, Query, Request, get, given, post, post_image
from tabletopgen.errors import (
    GoneError,
    InvalidRequestError,
    PayloadTooLargeError,
    TabletopgenError,
    TooManyRequestsError,
    WorkFailedError,
)

# Labels of scenes of a named `map`.
MAP_KEY = "map_key"


@dataclass(frozen=True)
class AsyncMapped:
    """What became of one request of `map`: a finished scene, or the reason why there is none."""

    index: int
    text: str
    seed: int | None
    #: Also where its job failed; none of a request that was refused.
    scene: AsyncScene | None
    error: TabletopgenError | None

    @property
    def ok(self) -> bool:
        """Whether there is a scene whose certificate says pass."""
        return self.scene is not None and self.scene.ok


class AsyncClient(AsyncAdministration):
    """A client of the server at `url`, with an API key; by default those of the environment variables `TABLETOPGEN_URL`
    and `TABLETOPGEN_API_KEY`.

    Without a URL a local server is started at the first request, and stopped by `aclose` or when this process ends. Its
    data stay in `data_dir`; without one they are temporary. `settings` are settings of the local server, by name.

    Requests that were refused for now or got no answer are repeated for `patience_secs`. No request has its effect
    twice. `progress` turns bars on or off; by default they are shown on terminals and in notebooks.
    """

    def __init__(
        self,
        url: str | None = None,
        key: str | None = None,
        *,
        data_dir: str | Path | None = None,
        settings: Mapping[str, object] | None = None,
        patience_secs: float = 120.0,
        timeout_secs: float = 60.0,
        progress: bool | None = None,
        transport: httpx.AsyncBaseTransport | None = None,
    ):
        url = url or os.environ.get("TABLETOPGEN_URL") or ""
        if url and (data_dir is not None or settings):
            raise ValueError("data_dir and settings are those of a local server; leave them out, or leave out the URL")
        local = None if url else LocalServer(data_dir, settings or {})
        # A local server has no keys.
        key = (key or os.environ.get("TABLETOPGEN_API_KEY")) if url else None
        self._connection = AsyncConnection(url, key, local, patience_secs, timeout_secs, progress, transport)

    async def __aenter__(self) -> AsyncClient:
        return self

    async def __aexit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        await self.aclose()

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._connection.url or 'of a local server'}>"

    async def aclose(self) -> None:
        """Ends connections, and the local server."""
        await self._connection.aclose()

    async def request(self, method: str, path: str, body: Any = None, query: Query | None = None) -> Any:
        """The answer of any operation of the contract, as values of JSON: of those that have no method here. A
        POST or PATCH whose answer is lost is not repeated."""
        headers = {"content-type": _requests.JSON if method != "PATCH" else "application/merge-patch+json"}
        content = None if body is None else _requests.dumped(body)
        repeatable = method not in ("POST", "PATCH")
        request = Request(method, path, _requests.plain(query), headers if content else {}, content, repeatable)
        answer = await self._connection.send(request)
        return answer.json() if answer.content else None

    # Scenes

    async def generate(
        self,
        text: str | None = None,
        *,
        image: Image | None = None,
        seed: int | None = None,
        labels: Mapping[str, str] | None = None,
        options: Mapping[str, Any] | models.Options | None = None,
        priority: int | None = None,
        not_before: datetime | None = None,
        deadline: datetime | None = None,
        idempotency_key: str | None = None,
    ) -> AsyncScene:
        """A scene from a text or an image, which a job of the server makes: `wait` for it.

        `image` is a path, the bytes of a file, an image of Pillow or an address; a text beside it names what it shows.
        """
        body = given(
            text=text,
            seed=seed,
            labels=labels,
            options=options,
            priority=priority,
            not_before=not_before,
            deadline=deadline,
        )
        key = idempotency_key or _requests.new_key()
        request = post("/scenes", body, key=key) if image is None else post_image("/scenes", image, body, key)
        return await AsyncScene._asked(self._connection, request)

    async def validate(
        self,
        text: str,
        *,
        seed: int | None = None,
        labels: Mapping[str, str] | None = None,
        options: Mapping[str, Any] | models.Options | None = None,
    ) -> models.Validated:
        """What the server understands of a text; nothing is made."""
        body = given(text=text, seed=seed, labels=labels, options=options)
        return await self._connection.ask(post("/scenes/validate", body, repeatable=True), models.Validated)

    async def scene(self, scene_id: str) -> AsyncScene:
        """The scene with this UUID."""
        return await AsyncScene._of(self._connection, scene_id)

    async def scenes(
        self,
        *,
        sort: Literal["newest", "oldest"] | None = None,
        **filters: Unpack[SceneFilters],
    ) -> AsyncIterator[AsyncScene]:
        """Scenes that pass all `SceneFilters`, newest first unless `sort` says otherwise."""
        parse = models.ScenePage.model_validate_json
        async for scene in self._connection.pages("/scenes", parse, lambda page: page.scenes, {**query_of(filters), "sort": sort}):
            yield AsyncScene(self._connection, scene)

    async def facets(self, **filters: Unpack[SceneFilters]) -> models.SceneFacets:
        """How many scenes pass all `SceneFilters`, by state, verdict, kind, category and label."""
        return await self._connection.ask(get("/scenes/facets", query_of(filters)), models.SceneFacets)

    async def map(
        self,
        texts: Iterable[str],
        *,
        seeds: Iterable[int] | None = None,
        labels: Mapping[str, str] | None = None,
        options: Mapping[str, Any] | models.Options | None = None,
        name: str | None = None,
        window: int = 16,
        progress: bool | None = None,
    ) -> AsyncIterator[AsyncMapped]:
        """A scene for every text, or for every text with every seed, in order; `window` of them are made at a time.

        Keys come from the content of the requests. After a client or a server was killed the same call goes on: scenes
        that exist are found and not made again, for 24 hours. With a `name`, which scenes have as a label, they are
        found as long as they exist. Refused requests and failed jobs are results with an `error`.
        """
        chosen = [None] if seeds is None else list(seeds)
        total = len(texts) * len(chosen) if isinstance(texts, Sized) else None
        found = await self._of_map(name) if name else {}
        times: Counter[str] = Counter()
        waiting: deque[AsyncMapped] = deque()
        with Bar(self._connection.progress if progress is None else progress, "scenes", total) as bar:
            for index, (text, seed) in enumerate((text, seed) for text in texts for seed in chosen):
                body = given(text=text, seed=seed, labels={**(labels or {}), **given(map=name)}, options=options)
                equal = _requests.key_of(body)
                key = _requests.key_of(body, times[equal])
                times[equal] += 1
                if name:
                    body["labels"][MAP_KEY] = key
                while len(waiting) >= window:
                    yield await ended(waiting.popleft(), bar)
                while (mapped := await self._mapped(index, body, key, found, is_last_try=not waiting)) is None:
                    # The queue has room again when a scene of it is finished.
                    yield await ended(waiting.popleft(), bar)
                waiting.append(mapped)
            while waiting:
                yield await ended(waiting.popleft(), bar)

    async def _mapped(
        self, index: int, body: Mapping[str, Any], key: str, found: Mapping[str, AsyncScene], is_last_try: bool
    ) -> AsyncMapped | None:
        """The scene that was found or submitted, or its refusal; nothing where there is no room for it now."""
        text, seed = body["text"], body.get("seed")
        try:
            scene = found.get(key) or await self._submitted(body, key)
            return AsyncMapped(index, text, seed, scene, None)
        except (InvalidRequestError, PayloadTooLargeError, GoneError) as error:
            return AsyncMapped(index, text, seed, None, error)
        except TooManyRequestsError:
            if is_last_try:
                raise
            return None

    async def _submitted(self, body: Mapping[str, Any], key: str) -> AsyncScene:
        return await AsyncScene._asked(self._connection, post("/scenes", body, key=key))

    async def _of_map(self, name: str) -> dict[str, AsyncScene]:
        """Scenes of earlier runs by their keys."""
        return {scene.labels[MAP_KEY]: scene async for scene in self.scenes(label=f"map:{name}") if MAP_KEY in scene.labels}

    # Batches

    async def submit_batch(
        self,
        requests: Iterable[str | Mapping[str, Any] | models.BatchRequestLine] | None = None,
        *,
        recipe: Mapping[str, Any] | models.BatchRecipe | None = None,
        name: str | None = None,
        budget_usd: float | None = None,
        idempotency_key: str | None = None,
    ) -> AsyncBatch:
        """Many scenes at once: texts or lines with `custom_id` and `body`, or a recipe that the server expands."""
        if (requests is None) == (recipe is None):
            raise ValueError("a batch wants either requests or a recipe")
        body: Any = recipe
        if requests is not None:
            lines = [
                {"custom_id": f"request-{number:06}", "body": {"text": line}} if isinstance(line, str) else line
                for number, line in enumerate(requests, 1)
            ]
            body = b"\n".join(map(_requests.dumped, lines))
        request = post(
            "/batches",
            body,
            key=idempotency_key or _requests.new_key(),
            query={"name": name, "budget_usd": budget_usd},
            media_type=_requests.JSON if requests is None else "application/jsonl",
        )
        return await AsyncBatch._asked(self._connection, request)

    async def batch(self, batch_id: str) -> AsyncBatch:
        """The batch with this UUID."""
        return await AsyncBatch._of(self._connection, batch_id)

    async def batches(self, *, state: str | None = None) -> AsyncIterator[AsyncBatch]:
        """Batches, newest first."""
        parse = models.BatchPage.model_validate_json
        async for batch in self._connection.pages("/batches", parse, lambda page: page.batches, {"state": state}):
            yield AsyncBatch(self._connection, batch)

    # Datasets

    async def freeze_dataset(
        self,
        name: str,
        *,
        scenes: Sequence[str] | None = None,
        label: str | None = None,
        batch: str | None = None,
        splits: Mapping[str, float] | None = None,
        filter: Mapping[str, Any] | models.DatasetFilter | None = None,
        idempotency_key: str | None = None,
        **more: Any,
    ) -> AsyncDataset:
        """Finished scenes, frozen as a version of a dataset: by UUIDs, by a label `key:value`, or of a batch. `more`
        are other fields of `DatasetSubmission`."""
        body = given(name=name, scenes=scenes, label=label, batch=batch, splits=splits, filter=filter, **more)
        request = post("/datasets", body, key=idempotency_key or _requests.new_key())
        return await AsyncDataset._asked(self._connection, request)

    async def dataset(self, dataset_id: str) -> AsyncDataset:
        """The version of a dataset with this UUID."""
        return await AsyncDataset._of(self._connection, dataset_id)

    async def datasets(self, *, name: str | None = None, state: str | None = None) -> AsyncIterator[AsyncDataset]:
        """Versions of datasets, newest first."""
        parse, query = models.DatasetPage.model_validate_json, {"name": name, "state": state}
        async for dataset in self._connection.pages("/datasets", parse, lambda page: page.datasets, query):
            yield AsyncDataset(self._connection, dataset)

    # Recordings, executions and jobs

    async def recording(self, recording_id: str) -> AsyncRecording:
        """The recording with this UUID."""
        return await AsyncRecording._of(self._connection, recording_id)

    async def recordings(self, *, scene: str | None = None, state: str | None = None) -> AsyncIterator[AsyncRecording]:
        """Recordings, newest first."""
        parse, query = models.RecordingPage.model_validate_json, {"scene": scene, "state": state}
        async for recording in self._connection.pages("/episodes", parse, lambda page: page.recordings, query):
            yield AsyncRecording(self._connection, recording)

    async def execution(self, execution_id: str) -> AsyncExecution:
        """The execution with this UUID."""
        return await AsyncExecution._of(self._connection, execution_id)

    async def job(self, job_id: str) -> models.Job:
        """The job with this UUID."""
        return await self._connection.ask(get(f"/jobs/{job_id}"), models.Job)

    def jobs(self, **query: str) -> AsyncIterator[models.Job]:
        """Jobs, newest first, by `state`, `kind`, `scene`, `dataset`, `recording`, `batch` or `created_after`."""
        parse = models.JobPage.model_validate_json
        return self._connection.pages("/jobs", parse, lambda page: page.jobs, query)


async def ended(mapped: AsyncMapped, bar: Bar) -> AsyncMapped:
    """The result once the job of its scene has ended."""
    bar.show(mapped.index, mapped.text)
    if mapped.scene is None:
        return mapped
    try:
        await mapped.scene.wait(progress=False)
        return mapped
    except WorkFailedError as error:
        return AsyncMapped(mapped.index, mapped.text, mapped.seed, mapped.scene, error)
