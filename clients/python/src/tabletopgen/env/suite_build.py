"""Suites: every combination of scenes, tasks and variations as an environment, frozen with digests.

    from tabletopgen.env.suite_build import build

    suite = build("default", "out/tabletop")
    suite.identity    # {"name": "tabletop", "version": "1", "digest": "4be0..."}
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import tabletopgen
from tabletopgen._local_server import program
from tabletopgen._sync.connection import digest_of
from tabletopgen.env.engine import mujoco
from tabletopgen.env.folder_digest import digest_of_folder
from tabletopgen.env.judge import MANIFEST
from tabletopgen.env.preparation import run
from tabletopgen.env.record_folder import RecordFolder
from tabletopgen.env.suite import DOCUMENT, SCENES, Suite, freeze
from tabletopgen.env.suite_combination import PARTS, CombinationMaker
from tabletopgen.env.suite_order import SceneOrder, SuiteOrder, file_of


class SuiteFolder(RecordFolder):
    """The folder of a suite that is being built."""

    work, request, lines, number, free = "suite", "build.json", "combinations.jsonl", "combination", ("mujoco",)


def build(order: str | Path, out: str | Path, *, finished: Callable[[Mapping[str, Any]], None] | None = None) -> Suite:
    """Builds the suite of a file, or that of the package by the word `default`, in the folder `out`.

    A combination is left out where the program does not do its task, or where the task is broken. A build that was
    stopped goes on where it was, and one that is finished is only compared with its digests. `finished` is called with
    the record of each combination."""
    path = file_of(order)
    asked, folder = SuiteOrder.read(path), SuiteFolder(out)
    bundles = {name: bundle_of(path, scene) for name, scene in asked.scenes.items() if scene.bundle is not None}
    versions = versions_now()
    digests = {name: digest_of_folder(bundle) for name, bundle in bundles.items()}
    with folder.held({**asked.document(), "bundles": digests, **versions}):
        if (folder.folder / DOCUMENT).is_file():
            suite = Suite.read(folder.folder)
            suite.refuse_changed()
            return suite
        for name, scene in asked.scenes.items():
            make_scene(folder.folder, name, scene, bundles.get(name))
        done = {record["combination"] for record in folder.records()}
        maker = CombinationMaker(asked, folder.folder)
        for number, combination in enumerate(asked.combinations()):
            if number not in done:
                record = maker.record(number, combination)
                folder.append(record)
                if finished is not None:
                    finished(record)
        shutil.rmtree(folder.folder / PARTS, ignore_errors=True)
        return freeze(folder.folder, asked, folder.records(), versions)


def bundle_of(path: Path, scene: SceneOrder) -> Path:
    """The bundle of a scene, whose path is relative to the file of the suite."""
    bundle = path.parent / str(scene.bundle)
    if not (bundle / MANIFEST).is_file():
        raise ValueError(f"{bundle} is no folder of a bundle: it has no {MANIFEST}; unpack an archive, or give a text")
    return bundle


def versions_now() -> dict[str, str]:
    """Versions that decide what a suite has."""
    return {"tabletopgen": tabletopgen.__version__, **program_version(), "mujoco": mujoco.__version__}


def program_version() -> dict[str, str]:
    """The version of the program, and its digest, which differs between builds of one version."""
    return {"program": run("--version").strip(), "program_digest": digest_of(program())}


def make_scene(folder: Path, name: str, scene: SceneOrder, bundle: Path | None) -> None:
    """Generates or copies the bundle of a scene, unless it is there."""
    target, part = folder / SCENES / name, folder / PARTS / SCENES
    if target.is_dir():
        return
    shutil.rmtree(part, ignore_errors=True)
    part.parent.mkdir(exist_ok=True)
    if bundle is not None:
        shutil.copytree(bundle, part)
    else:
        run("generate", "--text", scene.text, "--seed", scene.seed, "--out", part, "--quiet")
    target.parent.mkdir(exist_ok=True)
    part.rename(target)
