"""What the splits of a frozen dataset share. Reads the bundles themselves, not what the manifest says of them.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.batches.leaks datasets/NAME/v1
"""

import hashlib
import io
import json
import re
import sys
import tarfile
import zipfile
from collections import defaultdict
from pathlib import Path


def bundles(version: Path):
    """(split, id, archive) of every scene."""
    for shard in sorted((version / "shards").glob("*.tar")):
        split = shard.stem.rpartition("-")[0]
        with tarfile.open(shard) as members:
            for member in members:
                if member.name.endswith(".zip"):
                    content = members.extractfile(member)
                    assert content is not None, f"{member.name} of {shard} is no file"
                    yield split, member.name[:-4], content.read()
    if (version / "scenes").is_dir():
        dataset = json.loads((version / "dataset.json").read_text(encoding="utf-8"))
        for entry in dataset["scenes"]:
            yield entry["split"], entry["id"], (version / entry["path"]).read_bytes()


def marks(archive: bytes):
    """What a scene may share with another one: itself, its parent, its text, the meshes of its objects."""
    with zipfile.ZipFile(io.BytesIO(archive)) as bundle:
        names = {name.split("/", 1)[1]: name for name in bundle.namelist() if "/" in name}
        scene = json.loads(bundle.read(names["scene.json"]))
        given = scene["request"]["input"]
        yield "lineage", scene["id"]
        if given.get("parent"):
            yield "lineage", given["parent"]
        if given["kind"] == "text":
            yield "text", " ".join(re.sub(r"[^\w\s]", " ", given["text"].lower()).split())
        if given.get("sha256"):
            yield "image", given["sha256"]
        for instance in scene["instances"]:
            yield "mesh", hashlib.sha256(bundle.read(names[instance["mesh"]])).hexdigest()


def leaks(version: Path) -> tuple:
    """(scenes, scenes by split, what several splits share by kind)."""
    seen, counts = defaultdict(set), defaultdict(int)
    for split, _, archive in bundles(version):
        counts[split] += 1
        for mark in marks(archive):
            seen[mark].add(split)
    shared = defaultdict(int)
    for (kind, _), splits in seen.items():
        shared[kind] += len(splits) > 1
    return sum(counts.values()), dict(counts), {kind: count for kind, count in shared.items() if count}


if __name__ == "__main__":
    scenes, counts, shared = leaks(Path(sys.argv[1]))
    print(f"{scenes} scenes: {counts}; shared by several splits: {shared or 'nothing'}")
    sys.exit(1 if shared else 0)
