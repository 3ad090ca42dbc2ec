"""Environments made by the program from a bundle, and kept for later."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tabletopgen._local_server import program
from tabletopgen.env.folder import DESCRIPTION, EnvironmentFolder, write_environment
from tabletopgen.env.judge import MANIFEST
from tabletopgen.env.recorded_dataset import RECORDS, RecordedDataset
from tabletopgen.errors import TabletopgenError

# Exit code of an execution that failed, which writes its files nevertheless.
TASK_FAILED = 6


class PreparationError(TabletopgenError):
    """A command of the program that failed."""


def prepare(
    folder: str | Path,
    scene: str | Path,
    task: str | Path | None = None,
    robot: str = "panda",
    *,
    dataset: str | Path | None = None,
    starts: int = 20,
    seed: int = 0,
    cameras: Sequence[str] = (),
    size_px: int = 224,
    fps: int = 15,
) -> EnvironmentFolder:
    """Writes the folder of an environment for a task in the scene of a bundle.

    The task is an instruction in words or the file of a task. Its starts are those of the episodes of `dataset`, as
    `tabletopgen episodes` wrote it; without one, `starts` episodes are recorded first, with the usual randomization,
    `seed`, `cameras` of `size_px` and `fps`."""
    folder, bundle = Path(folder), Path(scene)
    if not (bundle / MANIFEST).is_file():
        raise ValueError(f"{bundle} is no folder of a bundle: it has no {MANIFEST}; unpack an archive, or `generate --out` a scene")
    if folder.exists():
        raise ValueError(f"{folder} exists; name another folder, or remove it")
    if task is None and dataset is None:
        raise ValueError("name a task, or a dataset that has one")
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}-") as place:
        executed, recorded = Path(place) / "execution", Path(place) / "dataset"
        if dataset is None:
            shown = ["--cameras", ",".join(cameras) or "none", "--size", size_px, "--fps", fps]
            order = ["episodes", "--bundle", bundle, "--task", task, "--robot", robot, "--count", starts, "--seed", seed]
            run(*order, "--format", "parquet-png", *shown, "--out", recorded, "--json")
        read = RecordedDataset(recorded if dataset is None else dataset)
        if task is None:
            task = Path(place) / "task.json"
            task.write_text(json.dumps(read.entries[0]["record"]["task"]), encoding="utf-8")
        run("execute", "--bundle", bundle, "--task", task, "--robot", robot, "--out", executed, "--json", accepted=(0, TASK_FAILED))
        write_environment(Path(place) / "environment", bundle, executed, read)
        (Path(place) / "environment").rename(folder)
    return EnvironmentFolder.read(folder)


def prepared(scene: str | Path, task: str | Path | None, robot: str, dataset: str | Path | None, **options: Any) -> EnvironmentFolder:
    """The environment of these, made by the first call and kept in the cache of the user."""
    folder = cache() / digest_of(Path(scene), task, robot, dataset, options)
    with locked(folder.with_suffix(".lock")):
        if (folder / DESCRIPTION).is_file():
            return EnvironmentFolder.read(folder)
        return prepare(folder, scene, task, robot, dataset=dataset, **options)


def cache() -> Path:
    """Where environments are kept: below `XDG_CACHE_HOME`, else below `~/.cache`."""
    root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return root / "tabletopgen" / "environments"


def digest_of(bundle: Path, task: str | Path | None, robot: str, dataset: str | Path | None, options: Mapping[str, Any]) -> str:
    """Names an environment by the content of what it is made from."""
    parts = [(bundle / MANIFEST).read_bytes() if (bundle / MANIFEST).is_file() else str(bundle).encode()]
    is_file = task is not None and str(task).endswith(".json")
    parts += [Path(str(task)).read_bytes() if is_file else str(task).encode(), robot.encode()]
    parts += [(RecordedDataset(dataset).folder / RECORDS).read_bytes() if dataset is not None else b""]
    parts += [json.dumps(options, sort_keys=True, default=list).encode()]
    return hashlib.sha256(b"\0".join(hashlib.sha256(part).digest() for part in parts)).hexdigest()[:20]


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Lets one process at a time go on."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def run(*words: object, accepted: Sequence[int] = (0,)) -> str:
    """The output of a command of the program."""
    return completed(*words, accepted=accepted).stdout


def completed(*words: object, accepted: Sequence[int] = (0,)) -> subprocess.CompletedProcess[str]:
    """A command of the program that ended with one of these exit codes."""
    command = [str(word) for word in (program(), *words)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode not in accepted:
        raise PreparationError(f"`{' '.join(command)}` ended with exit code {done.returncode}: {complaint(done)}")
    return done


def complaint(done: subprocess.CompletedProcess[str]) -> str:
    """What a command said about its failure."""
    return (done.stderr.strip() or done.stdout.strip())[-2000:]
