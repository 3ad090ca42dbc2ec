# Written by generate.py from `_async`.
"""The client: scenes, batches, datasets, recordings and jobs of a server."""

from __future__ import annotations

import os
from collections import Counter, deque
from collections.abc import Iterable, Iterator, Mapping, Sequence, Sized
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import Any, Literal

import httpx
from typing_extensions import Unpack

from tabletopgen import _requests, models
from tabletopgen._filters import SceneFilters, query_of
from tabletopgen._local_server import LocalServer
from tabletopgen._progress import Bar
from tabletopgen._requests import Image, Query, Request, get, given, post, post_image
from tabletopgen._sync.administration import Administration
from tabletopgen._sync.batch import Batch
from tabletopgen._sync.connection import Connection
from tabletopgen._sync.dataset import Dataset
from tabletopgen._sync.execution import Execution
from tabletopgen._sync.recording import Recording
from tabletopgen._sync.scene import Scene
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
class Mapped:
    """What became of one request of `map`: a finished scene, or the reason why there is none."""

    index: int
    text: str
    seed: int | None
    #: Also where its job failed; none of a request that was refused.
    scene: Scene | None
    error: TabletopgenError | None

    @property
    def ok(self) -> bool:
        """Whether there is a scene whose certificate says pass."""
        return self.scene is not None and self.scene.ok


class Client(Administration):
    """A client of the server at `url`, with an API key; by default those of the environment variables `TABLETOPGEN_URL`
    and `TABLETOPGEN_API_KEY`.

    Without a URL a local server is started at the first request, and stopped by `close` or when this process ends. Its
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
        transport: httpx.BaseTransport | None = None,
    ):
        url = url or os.environ.get("TABLETOPGEN_URL") or ""
        if url and (data_dir is not None or settings):
            raise ValueError("data_dir and settings are those of a local server; leave them out, or leave out the URL")
        local = None if url else LocalServer(data_dir, settings or {})
        # A local server has no keys.
        key = (key or os.environ.get("TABLETOPGEN_API_KEY")) if url else None
        self._connection = Connection(url, key, local, patience_secs, timeout_secs, progress, transport)

    def __enter__(self) -> Client:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._connection.url or 'of a local server'}>"

    def close(self) -> None:
        """Ends connections, and the local server."""
        self._connection.close()

    def request(self, method: str, path: str, body: Any = None, query: Query | None = None) -> Any:
        """The answer of any operation of the contract, as values of JSON: of those that have no method here. A
        POST or PATCH whose answer is lost is not repeated."""
        headers = {"content-type": _requests.JSON if method != "PATCH" else "application/merge-patch+json"}
        content = None if body is None else _requests.dumped(body)
        repeatable = method not in ("POST", "PATCH")
        request = Request(method, path, _requests.plain(query), headers if content else {}, content, repeatable)
        answer = self._connection.send(request)
        return answer.json() if answer.content else None

    # Scenes

    def generate(
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
    ) -> Scene:
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
        return Scene._asked(self._connection, request)

    def validate(
        self,
        text: str,
        *,
        seed: int | None = None,
        labels: Mapping[str, str] | None = None,
        options: Mapping[str, Any] | models.Options | None = None,
    ) -> models.Validated:
        """What the server understands of a text; nothing is made."""
        body = given(text=text, seed=seed, labels=labels, options=options)
        return self._connection.ask(post("/scenes/validate", body, repeatable=True), models.Validated)

    def scene(self, scene_id: str) -> Scene:
        """The scene with this UUID."""
        return Scene._of(self._connection, scene_id)

    def scenes(
        self,
        *,
        sort: Literal["newest", "oldest"] | None = None,
        **filters: Unpack[SceneFilters],
    ) -> Iterator[Scene]:
        """Scenes that pass all `SceneFilters`, newest first unless `sort` says otherwise."""
        parse = models.ScenePage.model_validate_json
        for scene in self._connection.pages("/scenes", parse, lambda page: page.scenes, {**query_of(filters), "sort": sort}):
            yield Scene(self._connection, scene)

    def facets(self, **filters: Unpack[SceneFilters]) -> models.SceneFacets:
        """How many scenes pass all `SceneFilters`, by state, verdict, kind, category and label."""
        return self._connection.ask(get("/scenes/facets", query_of(filters)), models.SceneFacets)

    def map(
        self,
        texts: Iterable[str],
        *,
        seeds: Iterable[int] | None = None,
        labels: Mapping[str, str] | None = None,
        options: Mapping[str, Any] | models.Options | None = None,
        name: str | None = None,
        window: int = 16,
        progress: bool | None = None,
    ) -> Iterator[Mapped]:
        """A scene for every text, or for every text with every seed, in order; `window` of them are made at a time.

        Keys come from the content of the requests. After a client or a server was killed the same call goes on: scenes
        that exist are found and not made again, for 24 hours. With a `name`, which scenes have as a label, they are
        found as long as they exist. Refused requests and failed jobs are results with an `error`.
        """
        chosen = [None] if seeds is None else list(seeds)
        total = len(texts) * len(chosen) if isinstance(texts, Sized) else None
        found = self._of_map(name) if name else {}
        times: Counter[str] = Counter()
        waiting: deque[Mapped] = deque()
        with Bar(self._connection.progress if progress is None else progress, "scenes", total) as bar:
            for index, (text, seed) in enumerate((text, seed) for text in texts for seed in chosen):
                body = given(text=text, seed=seed, labels={**(labels or {}), **given(map=name)}, options=options)
                equal = _requests.key_of(body)
                key = _requests.key_of(body, times[equal])
                times[equal] += 1
                if name:
                    body["labels"][MAP_KEY] = key
                while len(waiting) >= window:
                    yield ended(waiting.popleft(), bar)
                while (mapped := self._mapped(index, body, key, found, is_last_try=not waiting)) is None:
                    # The queue has room again when a scene of it is finished.
                    yield ended(waiting.popleft(), bar)
                waiting.append(mapped)
            while waiting:
                yield ended(waiting.popleft(), bar)

    def _mapped(self, index: int, body: Mapping[str, Any], key: str, found: Mapping[str, Scene], is_last_try: bool) -> Mapped | None:
        """The scene that was found or submitted, or its refusal; nothing where there is no room for it now."""
        text, seed = body["text"], body.get("seed")
        try:
            scene = found.get(key) or self._submitted(body, key)
            return Mapped(index, text, seed, scene, None)
        except (InvalidRequestError, PayloadTooLargeError, GoneError) as error:
            return Mapped(index, text, seed, None, error)
        except TooManyRequestsError:
            if is_last_try:
                raise
            return None

    def _submitted(self, body: Mapping[str, Any], key: str) -> Scene:
        return Scene._asked(self._connection, post("/scenes", body, key=key))

    def _of_map(self, name: str) -> dict[str, Scene]:
        """Scenes of earlier runs by their keys."""
        return {scene.labels[MAP_KEY]: scene for scene in self.scenes(label=f"map:{name}") if MAP_KEY in scene.labels}

    # Batches

    def submit_batch(
        self,
        requests: Iterable[str | Mapping[str, Any] | models.BatchRequestLine] | None = None,
        *,
        recipe: Mapping[str, Any] | models.BatchRecipe | None = None,
        name: str | None = None,
        budget_usd: float | None = None,
        idempotency_key: str | None = None,
    ) -> Batch:
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
        return Batch._asked(self._connection, request)

    def batch(self, batch_id: str) -> Batch:
        """The batch with this UUID."""
        return Batch._of(self._connection, batch_id)

    def batches(self, *, state: str | None = None) -> Iterator[Batch]:
        """Batches, newest first."""
        parse = models.BatchPage.model_validate_json
        for batch in self._connection.pages("/batches", parse, lambda page: page.batches, {"state": state}):
            yield Batch(self._connection, batch)

    # Datasets

    def freeze_dataset(
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
    ) -> Dataset:
        """Finished scenes, frozen as a version of a dataset: by UUIDs, by a label `key:value`, or of a batch. `more`
        are other fields of `DatasetSubmission`."""
        body = given(name=name, scenes=scenes, label=label, batch=batch, splits=splits, filter=filter, **more)
        request = post("/datasets", body, key=idempotency_key or _requests.new_key())
        return Dataset._asked(self._connection, request)

    def dataset(self, dataset_id: str) -> Dataset:
        """The version of a dataset with this UUID."""
        return Dataset._of(self._connection, dataset_id)

    def datasets(self, *, name: str | None = None, state: str | None = None) -> Iterator[Dataset]:
        """Versions of datasets, newest first."""
        parse, query = models.DatasetPage.model_validate_json, {"name": name, "state": state}
        for dataset in self._connection.pages("/datasets", parse, lambda page: page.datasets, query):
            yield Dataset(self._connection, dataset)

    # Recordings, executions and jobs

    def recording(self, recording_id: str) -> Recording:
        """The recording with this UUID."""
        return Recording._of(self._connection, recording_id)

    def recordings(self, *, scene: str | None = None, state: str | None = None) -> Iterator[Recording]:
        """Recordings, newest first."""
        parse, query = models.RecordingPage.model_validate_json, {"scene": scene, "state": state}
        for recording in self._connection.pages("/episodes", parse, lambda page: page.recordings, query):
            yield Recording(self._connection, recording)

    def execution(self, execution_id: str) -> Execution:
        """The execution with this UUID."""
        return Execution._of(self._connection, execution_id)

    def job(self, job_id: str) -> models.Job:
        """The job with this UUID."""
        return self._connection.ask(get(f"/jobs/{job_id}"), models.Job)

    def jobs(self, **query: str) -> Iterator[models.Job]:
        """Jobs, newest first, by `state`, `kind`, `scene`, `dataset`, `recording`, `batch` or `created_after`."""
        parse = models.JobPage.model_validate_json
        return self._connection.pages("/jobs", parse, lambda page: page.jobs, query)


def ended(mapped: Mapped, bar: Bar) -> Mapped:
    """The result once the job of its scene has ended."""
    bar.show(mapped.index, mapped.text)
    if mapped.scene is None:
        return mapped
    try:
        mapped.scene.wait(progress=False)
        return mapped
    except WorkFailedError as error:
        return Mapped(mapped.index, mapped.text, mapped.seed, mapped.scene, error)
