"""A scene of the server, and what can be done with it."""

from __future__ import annotations

import contextlib
from collections.abc import AsyncIterator, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel
from typing_extensions import Self

from tabletopgen import _archive, _html, _media, _requests, models, rrd, simulators
from tabletopgen._async import io
from tabletopgen._async.execution import AsyncExecution
from tabletopgen._async.recording import AsyncRecording
from tabletopgen._async.resource import AsyncResource
from tabletopgen._requests import Query, escaped, get, given, patch, post
from tabletopgen.errors import ApiError, WorkFailedError

BundleFormat = Literal["usd", "urdf", "mjcf", "sdf", "glb", "all"]
TASKS_SECS = 900.0
REFERENCE = "reference/reference.png"
PreviewWidth = Literal[160, 320, 640]


class AsyncScene(AsyncResource[models.Scene]):
    """A scene, which is `pending`, `ready`, `failed` or `deleted`."""

    _paths, _model = "/scenes", models.Scene

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.id} {self.data.verdict or self.state}>"

    def _repr_html_(self) -> str:
        return _html.card(self.data, self._connection.url, io.at_once(self._shown))

    async def _shown(self) -> tuple[bytes, str] | None:
        """The render of a finished scene, else the reference image, else nothing; with its media type."""
        images: list[tuple[str, Query]] = [("preview", {"width": _html.WIDTH_PX}), (f"artifacts/{escaped(REFERENCE)}", {})]
        for name, query in images:
            # A card without an image is better than none, also of a scene that has been deleted.
            with contextlib.suppress(ApiError):
                return await self._content(name, query)
        return None

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

    # Progress

    async def events(self, after: int = 0, timeout_secs: float | None = None) -> AsyncIterator[models.Event]:
        """Events of the newest job, those to come too, until it has ended; those with a `seq` larger than `after`."""
        if job := self.data.job:
            async for event in self._connection.job_events(str(job.id), after, timeout_secs):
                yield event

    async def wait(self, timeout_secs: float | None = None, *, progress: bool | None = None, check: bool = True) -> Self:
        """The scene once its job has ended; a quarantined one is returned like one that passed (`ok`, `verdict`).

        Raises `WorkFailedError` where there is no scene in the end, unless `check` is false, and `WaitTimeoutError`.
        """
        if self.data.job and self.data.job.finished_at is None:
            with self._bar(progress, "scene") as bar:
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

    async def cancel(self) -> Self:
        """Asks the newest job to stop."""
        if self.data.job is not None:
            await self._connection.send(post(f"/jobs/{self.data.job.id}/cancel", repeatable=True))
        return await self.refresh()

    async def retry(self, from_stage: str | None = None) -> Self:
        """A new job for a scene that is not ready; finished stages are not repeated, but those from `from_stage` on."""
        if self.data.job is not None:
            await self._connection.send(post(f"/jobs/{self.data.job.id}/retry", given(from_stage=from_stage)))
        return await self.refresh()

    # Files

    async def download(self, folder: str | Path, format: BundleFormat | None = None, *, quarantined: bool = False) -> Path:
        """The bundle, unpacked to `scene-<id>` below a folder; the path of that. `format` selects one format."""
        query = {"format": format, "quarantined": quarantined or None}
        return await self._connection.unpacked(f"{self._path}/bundle", folder, _archive.unpack_zip, query)

    async def _bundle(self, format: BundleFormat) -> Path:
        """The bundle in a folder that the client removes when it is closed; downloaded once."""
        name, kept = f"{self.id}/{format}", self._connection.kept
        if name not in kept:
            kept[name] = await self.download(self._connection.place(name), format, quarantined=self.verdict == "quarantine")
        return kept[name]

    async def files(self, *, quarantined: bool = False) -> list[models.BundleFile]:
        """The files of the bundle, each of which `file` reads; with `quarantined` also of a quarantined scene."""
        request = get(f"{self._path}/files", {"quarantined": quarantined or None})
        return (await self._connection.ask(request, models.BundleFileList)).files

    async def file_bytes(self, name: str, *, quarantined: bool = False) -> bytes:
        """A file of the bundle, byte for byte."""
        return (await self._content(f"files/{escaped(name)}", {"quarantined": quarantined or None}))[0]

    async def file(self, name: str, *, quarantined: bool = False) -> Any:
        """A file of the bundle by its media type, as `artifact` gives it."""
        return _media.opened(*await self._content(f"files/{escaped(name)}", {"quarantined": quarantined or None}))

    async def preview(self, width_px: PreviewWidth = 320) -> Any:
        """A small image of the finished scene, also of a quarantined one, as an image of Pillow."""
        return _media.opened(*await self._content("preview", {"width": width_px}))

    async def artifacts(self) -> list[models.Artifact]:
        """Files that finished stages put aside, also while the job runs."""
        return (await self._connection.ask(get(f"{self._path}/artifacts"), models.ArtifactList)).artifacts

    async def artifact_bytes(self, name: str) -> bytes:
        """An artifact, byte for byte."""
        return (await self._artifact(name))[0]

    async def artifact(self, name: str) -> Any:
        """An artifact by its media type: an image of Pillow, a mesh or scene of trimesh, values of JSON, or bytes."""
        return _media.opened(*await self._artifact(name))

    async def _artifact(self, name: str) -> tuple[bytes, str]:
        return await self._content(f"artifacts/{escaped(name)}")

    async def _content(self, name: str, query: Query | None = None) -> tuple[bytes, str]:
        """Bytes of something of the scene, and their media type."""
        answer = await self._connection.send(get(f"{self._path}/{name}", query))
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

    async def to_rerun(self, path: str | Path) -> Path:
        """The scene as a file `.rrd` for the viewer Rerun, with its image in its camera; the path of the file."""
        return await io.blocking_call(rrd.write_scene, await self._bundle("glb"), path)

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
        request = post(f"{self._path}/edits", body, key=idempotency_key or _requests.new_key())
        return await AsyncScene._asked(self._connection, request)

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
        request = post(f"{self._path}/variants", body, key=idempotency_key or _requests.new_key())
        made = await self._connection.ask(request, models.Variants)
        return [await AsyncScene._of(self._connection, str(variant.id)) for variant in made.scenes]

    async def validate_edit(
        self,
        text: str | None = None,
        *,
        operations: Sequence[Mapping[str, Any] | BaseModel] | None = None,
        options: Mapping[str, Any] | models.EditOptions | None = None,
        allow_quarantined: bool | None = None,
    ) -> models.ValidatedEdit:
        """What the server understands of an edit, with predicted places and collisions; nothing is made."""
        body = given(text=text, operations=operations, options=options, allow_quarantined=allow_quarantined)
        return await self._connection.ask(post(f"{self._path}/edits/validate", body, repeatable=True), models.ValidatedEdit)

    async def validate_variants(
        self, count: int, *, seed: int | None = None, randomize: Mapping[str, Any] | models.Randomize | None = None
    ) -> models.ValidatedVariants:
        """The requests that variants would be made from; nothing is made."""
        body = given(count=count, seed=seed, randomize=randomize)
        return await self._connection.ask(post(f"{self._path}/variants/validate", body, repeatable=True), models.ValidatedVariants)

    async def lineage(self) -> models.Lineage:
        """Scenes that this one was made from, and scenes that were made from it."""
        return await self._connection.ask(get(f"{self._path}/lineage"), models.Lineage)

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
        return await self._connection.ask(get(f"{self._path}/tasks", query, TASKS_SECS), models.SceneTasks)

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
        request = post(f"{self._path}/executions", body, key=key, query=query)
        return await AsyncExecution._asked(self._connection, request)

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
        request = post(f"{self._path}/episodes", body, key=idempotency_key or _requests.new_key())
        return await AsyncRecording._asked(self._connection, request)

    # Changes

    async def label(self, changes: Mapping[str, str | None] | None = None, /, **more: str | None) -> Self:
        """Sets labels, and removes those whose value is None; the others stay."""
        changed = await self._connection.ask(patch(self._path, {"labels": {**(changes or {}), **more}}), models.Scene)
        self.data = self.data.model_copy(update={"labels": changed.labels})
        return self

    async def delete(self) -> None:
        """Deletes the scene and cancels what is being done to it; deleting twice is fine."""
        await self._deleted()
