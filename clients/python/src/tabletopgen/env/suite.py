"""A frozen suite: environments whose files never change, named by a digest.

    suite.json        name, version, environments, digests of all files, and the digest of the suite
    README.md         commands, and what a result must state
    environments/     an environment for each combination of scene, task and variation, as `prepare` writes one
    episodes/         numbers of the recorded episodes whose starts the environments have
    scenes/           bundles of the scenes before they are varied
    build.json, combinations.jsonl    what it was made from, and what each combination came to
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from tabletopgen._sync.connection import digest_of
from tabletopgen.env.folder import EnvironmentFolder
from tabletopgen.env.folder_digest import digest_of_folder
from tabletopgen.env.record_folder import write_whole
from tabletopgen.env.suite_order import SuiteOrder
from tabletopgen.env.suite_statement import readme

FORMAT = "tabletopgen-suite/1"
DOCUMENT, README = "suite.json", "README.md"
ENVIRONMENTS, EPISODES, SCENES = "environments", "episodes", "scenes"
# What the digest leaves out: what was not made, and with which versions the rest was.
OUTSIDE = ("digest", "left_out", "versions")
# Names of files that a message has.
SHOWN = 5


@dataclass(frozen=True)
class Suite:
    """The folder of a suite, and the content of its `suite.json`."""

    folder: Path
    document: Mapping[str, Any]

    @classmethod
    def read(cls, folder: str | Path) -> Suite:
        folder = Path(folder)
        path = folder / DOCUMENT
        if not path.is_file():
            raise ValueError(f"{folder} is no finished suite: it has no {DOCUMENT}; make one by `python -m tabletopgen.env suite build`")
        document = json.loads(path.read_text(encoding="utf-8"))
        if document.get("format") != FORMAT:
            found = document.get("format")
            raise ValueError(f"{path} has the format {found!r}, where this version reads {FORMAT!r}; build the suite again")
        if document["digest"] != digest_of_document(document):
            raise ValueError(f"{path} was changed since it was frozen; copy the suite again")
        return cls(folder, document)

    @property
    def identity(self) -> dict[str, str]:
        """What names the suite in results."""
        return {"name": self.document["name"], "version": self.document["version"], "digest": self.document["digest"]}

    @cached_property
    def environments(self) -> dict[str, Mapping[str, Any]]:
        """The environments by name."""
        return {one["name"]: one for one in self.document["environments"]}

    @property
    def starts(self) -> int:
        """The number of starts of all environments."""
        return sum(one["starts"] for one in self.environments.values())

    def refuse_changed(self) -> None:
        """Compares all files with their digests."""
        frozen, found = self.document["files"], digests_in(self.folder)
        kinds = {
            "changed": [path for path in frozen if path in found and found[path] != frozen[path]],
            "missing": [path for path in frozen if path not in found],
            "added": [path for path in found if path not in frozen],
        }
        if faults := [f"{kind}: {listed(paths)}" for kind, paths in kinds.items() if paths]:
            raise ValueError(f"{self.folder} is not the suite that was frozen ({'; '.join(faults)}); copy it again, or build it elsewhere")


def digest_of_document(document: Mapping[str, Any]) -> str:
    """The digest of a suite: of its document in one form."""
    inside = {name: part for name, part in document.items() if name not in OUTSIDE}
    return hashlib.sha256(json.dumps(inside, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def digests_in(folder: Path) -> dict[str, str]:
    """The digests of all frozen files, by their paths."""
    paths = sorted(path for name in (ENVIRONMENTS, EPISODES, SCENES) for path in (folder / name).rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): digest_of(path) for path in paths}


def listed(names: Sequence[str]) -> str:
    """Names in words, of which the last are counted."""
    return ", ".join(names[:SHOWN]) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")


def freeze(folder: Path, order: SuiteOrder, records: Sequence[Mapping[str, Any]], versions: Mapping[str, str]) -> Suite:
    """Writes the documents of a suite whose combinations are all made, `suite.json` as the last one."""
    own = ("name", "scene", "task", "variation", "instruction")
    environments = [
        {
            **{key: record[key] for key in own},
            "starts": len(EnvironmentFolder.read(folder / ENVIRONMENTS / record["name"]).starts),
            "digest": digest_of_folder(folder / ENVIRONMENTS / record["name"]),
        }
        for record in records
        if record["reason"] is None
    ]
    if not environments:
        reasons = "; ".join(f"{record['name']}: {record['reason']}" for record in records)
        raise ValueError(f"no combination of {order.name} can be done ({reasons}); change its tasks, and name another folder")
    document: dict[str, Any] = {
        "format": FORMAT,
        "name": order.name,
        "version": order.version,
        "order": order.document(),
        "environments": environments,
        "files": digests_in(folder),
        "left_out": [{key: record[key] for key in (*own, "reason")} for record in records if record["reason"] is not None],
        "versions": dict(versions),
    }
    suite = Suite(folder, {"digest": digest_of_document(document), **document})
    write_whole(folder / README, readme(suite.document).encode())
    write_whole(folder / DOCUMENT, (json.dumps(suite.document, indent=1) + "\n").encode())
    return suite
