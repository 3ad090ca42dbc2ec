"""A scene of the server, and what can be done with it."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel

from tabletopgen import _archive, _html, _media, _requests, models, simulators
from tabletopgen._async import io
from tabletopgen._async.connection import AsyncConnection
from tabletopgen._async.execution import AsyncExecution
from tabletopgen._async.recording import AsyncRecording
from tabletopgen._progress import Bar
from tabletopgen._requests import escaped, get, given, post
from tabletopgen.errors import WorkFailedError

BundleFormat = Literal["usd", "urdf", "mjcf", "sdf", "glb", "all"]
TASKS_SECS = 900.0
PREVIEW = "reference/reference.png"


class AsyncScene:
    """A scene as the server knew it when it was asked last; `refresh` asks again."""

    def __init__(self, connection: AsyncConnection, data: models.Scene):
        self._connection = connection
        #: Everything that the server says of it.
        self.data = data

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.id} {self.data.verdict or self.state}>"

    def _repr_html_(self) -> str:
        return _html.card(self.data, self._connection.url, io.at_once(self._preview))

    async def _preview(self) -> bytes | None:
        names = [artifact.name for artifact in self.data.artifacts or ()]
        return await self.artifact_bytes(PREVIEW) if PREVIEW in names else None

    @property
    def id(self) -> str:
        """The UUID of the scene on this server."""
        return str(self.data.id)

    @property
    def state(self) -> str:
        """`pending`, `ready`, `failed` or `deleted`."""
        return self.data.state

    @property
    def ok(self) -> bool:
        """Whether the scene is finished and its certificate says pass."""
        return self.data.state == "ready"

    @property
    def verdict(self) -> str | None:
        """`pass` or `quarantine`, once certified."""
        return self.data.verdict

    @property
    def failure(self) -> models.Failure | None:
        """Why there is no scene to use: of a failed job, or of a quarantined scene."""
        return self.data.failure

    @property
    def metrics(self) -> models.Metrics | None:
        """What was measured, once certified."""
        return self.data.metrics

    @property
    def seed(self) -> int:
        """The seed that was given or drawn."""
        return self.data.seed

    @property
    def labels(self) -> dict[str, str]:
        """Pairs of words for your own use."""
        return self.data.labels

    async def refresh(self) -> AsyncScene:
        """The same scene, as it is now."""
        self.data = await self._connection.ask(get(f"/scenes/{self.id}"), models.Scene)
        return self

    # Progress

    async def events(self, after: int = 0, timeout_secs: float | None = None) -> AsyncIterator[models.Event]:
        """Events of the newest job, those to come too, until it has ended; those with a `seq` larger than `after`."""
        if job := self.data.job:
            async for event in self._connection.job_events(str(job.id), after, timeout_secs):
                yield event

    async def wait(self, timeout_secs: float | None = None, *, progress: bool | None = None, check: bool = True) -> AsyncScene:
        """The scene once its job has ended; a quarantined one is returned like one that passed (`ok`, `verdict`).

        Raises `WorkFailedError` where there is no scene in the end, unless `check` is false, and `WaitTimeoutError`.
        """
        if self.data.job and self.data.job.finished_at is None:
            shown = self._connection.progress if progress is None else progress
            with Bar(shown, "scene") as bar:
                async for event in self.events(timeout_secs=timeout_secs):
                    bar.show_event(event)
        await self.refresh()
        if check and self.data.job and self.data.job.state in ("failed", "cancelled"):
            raise WorkFailedError(f"scene {self.id}", self.data.job.failure, self.data.job.state)
        return self

    async def stages(self) -> list[models.Stage]:
        """The stages of the newest job, in the order it came to them."""
        if self.data.job is None:
            return []
        return (await self._connection.ask(get(f"/jobs/{self.data.job.id}/stages"), models.StageList)).stages

    async def cancel(self) -> AsyncScene:
        """Asks the newest job to stop."""
        if self.data.job is not None:
            await self._connection.send(post(f"/jobs/{self.data.job.id}/cancel", repeatable=True))
        return await self.refresh()

    async def retry(self, from_stage: str | None = None) -> AsyncScene:
        """A new job for a scene that is not ready; finished stages are not repeated, but those from `from_stage` on."""
        if self.data.job is not None:
            await self._connection.send(post(f"/jobs/{self.data.job.id}/retry", given(from_stage=from_stage)))
        return await self.refresh()

    # Files

    async def download(self, folder: str | Path, format: BundleFormat | None = None, *, quarantined: bool = False) -> Path:
        """The bundle, unpacked to `scene-<id>` below a folder; the path of that. `format` selects one format."""
        query = {"format": format, "quarantined": quarantined or None}
        return await self._connection.unpacked(f"/scenes/{self.id}/bundle", folder, _archive.unpack_zip, query)

    async def _bundle(self, format: BundleFormat) -> Path:
        """The bundle in a folder that the client removes when it is closed; downloaded once."""
        folder = Path(self._connection.files.name) / self.id / format
        if folder.is_dir():
            return next(folder.iterdir())
        partial = folder.with_name(f"{format}.partial")
        bundle = await self.download(partial, format, quarantined=self.verdict == "quarantine")
        partial.rename(folder)
        return folder / bundle.name

    async def artifacts(self) -> list[models.Artifact]:
        """Files that finished stages put aside, also while the job runs."""
        return (await self._connection.ask(get(f"/scenes/{self.id}/artifacts"), models.ArtifactList)).artifacts

    async def artifact_bytes(self, name: str) -> bytes:
        """An artifact, byte for byte."""
        return (await self._artifact(name))[0]

    async def artifact(self, name: str) -> Any:
        """An artifact by its media type: an image of Pillow, a mesh or scene of trimesh, values of JSON, or bytes."""
        return _media.opened(*await self._artifact(name))

    async def _artifact(self, name: str) -> tuple[bytes, str]:
        answer = await self._connection.send(get(f"/scenes/{self.id}/artifacts/{escaped(name)}"))
        return answer.content, answer.headers.get("content-type", "")

    async def mujoco(self) -> Any:
        """The scene as a `mujoco.MjModel`."""
        return simulators.mujoco(await self._bundle("mjcf"))

    async def sapien(self, scene: Any = None) -> Any:
        """Adds table and objects to a `sapien.Scene`, or to a new one without a renderer; that scene."""
        return simulators.sapien(await self._bundle("urdf"), scene)

    async def pybullet(self, client: int = 0) -> dict[str, int]:
        """Loads table and objects into a connected physics client of PyBullet; body by name."""
        return simulators.pybullet(await self._bundle("urdf"), client)

    @property
    async def usd_path(self) -> Path:
        """The USD stage, in a folder that is removed when the client is closed; `download` writes to yours."""
        return simulators.usd_path(await self._bundle("usd"))

    # New scenes

    async def edit(
        self,
        text: str | None = None,
        *,
        operations: Sequence[Mapping[str, Any] | BaseModel] | None = None,
        seed: int | None = None,
        labels: Mapping[str, str] | None = None,
        options: Mapping[str, Any] | models.EditOptions | None = None,
        allow_quarantined: bool | None = None,
        priority: int | None = None,
        not_before: datetime | None = None,
        deadline: datetime | None = None,
        idempotency_key: str | None = None,
    ) -> AsyncScene:
        """A new scene, made from this one by a sentence or by operations."""
        body = given(
            text=text,
            operations=operations,
            seed=seed,
            labels=labels,
            options=options,
            priority=priority,
            allow_quarantined=allow_quarantined,
            not_before=not_before,
            deadline=deadline,
        )
        request = post(f"/scenes/{self.id}/edits", body, key=idempotency_key or _requests.new_key())
        return AsyncScene(self._connection, await self._connection.ask(request, models.Scene))

    async def variants(
        self,
        count: int,
        *,
        seed: int | None = None,
        randomize: Mapping[str, Any] | models.Randomize | None = None,
        labels: Mapping[str, str] | None = None,
        options: Mapping[str, Any] | models.EditOptions | None = None,
        allow_quarantined: bool | None = None,
        priority: int | None = None,
        idempotency_key: str | None = None,
    ) -> list[AsyncScene]:
        """New scenes, made from this one by operations that seeds draw. Where a limit leaves room for some only, the
        list is shorter: the same call with the same key goes on."""
        body = given(
            count=count,
            seed=seed,
            randomize=randomize,
            labels=labels,
            options=options,
            priority=priority,
            allow_quarantined=allow_quarantined,
        )
        request = post(f"/scenes/{self.id}/variants", body, key=idempotency_key or _requests.new_key())
        made = await self._connection.ask(request, models.Variants)
        return [await scene_of(self._connection, str(variant.id)) for variant in made.scenes]

    async def lineage(self) -> models.Lineage:
        """Scenes that this one was made from, and scenes that were made from it."""
        return await self._connection.ask(get(f"/scenes/{self.id}/lineage"), models.Lineage)

    # Robots

    async def tasks(
        self,
        *,
        robot: str | None = None,
        count: int | None = None,
        seed: int | None = None,
        text: str | None = None,
        rehearsed: bool | None = None,
    ) -> models.SceneTasks:
        """Tasks that a robot could do in the scene, or the one of an instruction. Rehearsed ones take minutes."""
        query = {"robot": robot, "count": count, "seed": seed, "text": text, "rehearsed": rehearsed}
        return await self._connection.ask(get(f"/scenes/{self.id}/tasks", query, TASKS_SECS), models.SceneTasks)

    async def execute(
        self,
        task: str | Mapping[str, Any] | models.Task,
        *,
        robot: str | None = None,
        seed: int | None = None,
        base: Mapping[str, float] | models.BasePlace | None = None,
        files: bool = False,
        video: bool | None = None,
        idempotency_key: str | None = None,
    ) -> AsyncExecution:
        """A simulated robot does a task: an instruction in words, or one of `tasks`. With `files` the result is an
        archive for `download`, with the robot in the scene in every format, and with `video` a film of it."""
        source = "text" if isinstance(task, str) else "task"
        body = given(robot=robot, seed=seed, base=base, video=video) | {source: task}
        key, query = idempotency_key or _requests.new_key(), {"format": "zip" if files else "json"}
        request = post(f"/scenes/{self.id}/executions", body, key=key, query=query)
        job = await self._connection.ask(request, models.Job)
        return AsyncExecution(self._connection, job)

    async def record(
        self,
        task: str | Mapping[str, Any] | models.Task | Sequence[str | Mapping[str, Any] | models.Task],
        count: int,
        *,
        robot: str | None = None,
        seed: int | None = None,
        randomize: str | Mapping[str, Any] | models.RandomizationAmplitudes | None = None,
        formats: Sequence[str] | None = None,
        idempotency_key: str | None = None,
        **more: Any,
    ) -> AsyncRecording:
        """Demonstrations of a task, or of several that take turns, recorded as a dataset until `count` succeeded.
        `more` are other fields of `EpisodesSubmission`, such as `record` and `keep_failures`."""
        several = isinstance(task, Sequence) and not isinstance(task, str)
        body = given(
            count=count,
            robot=robot,
            seed=seed,
            randomize=randomize,
            formats=formats,
            **more,
        ) | {"tasks" if several else "task": task}
        request = post(f"/scenes/{self.id}/episodes", body, key=idempotency_key or _requests.new_key())
        return AsyncRecording(self._connection, await self._connection.ask(request, models.Recording))

    # Changes

    async def label(self, changes: Mapping[str, str | None] | None = None, /, **more: str | None) -> AsyncScene:
        """Sets labels, and removes those whose value is None; the others stay."""
        content = _requests.dumped({"labels": {**(changes or {}), **more}})
        headers = {"content-type": "application/merge-patch+json"}
        request = _requests.Request("PATCH", f"/scenes/{self.id}", {}, headers, content)
        changed = await self._connection.ask(request, models.Scene)
        self.data = self.data.model_copy(update={"labels": changed.labels})
        return self

    async def delete(self) -> None:
        """Deletes the scene and cancels what is being done to it; deleting twice is fine."""
        await self._connection.send(_requests.Request("DELETE", f"/scenes/{self.id}"))


async def scene_of(connection: AsyncConnection, scene_id: str) -> AsyncScene:
    return AsyncScene(connection, await connection.ask(get(f"/scenes/{scene_id}"), models.Scene))
