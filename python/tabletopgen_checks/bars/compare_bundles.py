"""Do two builds of tabletopgen write the same bundles? For refactorings, which change no byte but those they name.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.compare_bundles OLD_BINARY NEW_BINARY --work DIR \\
        [--renamed yaw=yaw_rad] [--image docs/demo_table.png]

Both binaries make every scene of sentences.toml, and one from an image. Files are equal to the byte, or equal after the
scene's id and the keys named with --renamed are replaced, or they differ. USD files are compared as text; that needs
the Python of the judges' environment (`target/judges/bin/python`).
"""

import argparse
import json
import re
import sys
from collections import Counter
from pathlib import Path

from tabletopgen_checks.language.sentences import sentences
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import ROOT
from tabletopgen_checks.scene.generation import generate


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--work", type=Path, required=True, help="folder for the scenes of both")
    parser.add_argument("--renamed", action="append", default=[], metavar="OLD=NEW", help="a key of JSON files")
    parser.add_argument("--image", type=Path, default=ROOT / "docs/demo_table.png")
    given = parser.parse_args()
    renamed = dict(pair.split("=", 1) for pair in given.renamed)
    scenes = [(s.name, s.text, s.seed) for s in sentences()] + [("image", given.image, 1)]
    total = Counter()
    for name, source, seed in scenes:
        old, new = (given.work / side / name for side in ("old", "new"))
        generate(given.old, old, source, seed, threads=2)
        generate(given.new, new, source, seed, threads=2)
        counts, differing = compare(old, new, renamed)
        total += counts
        print(f"{name}: {dict(counts)} {'; '.join(differing[:8])}", flush=True)
    print(f"all: {dict(total)}")
    return 1 if total["differs"] or total["missing"] else 0


def compare(old: Path, new: Path, renamed: dict):
    """How many files are the same, the same but for names, other, or in one folder alone; and the latter two by
    name."""
    listed = [{p.relative_to(side) for p in side.rglob("*") if p.is_file()} for side in (old, new)]
    ids = [json.loads((side / "scene.json").read_text())["id"] for side in (old, new)]
    counts, differing = Counter(), []
    for path in sorted(listed[0] | listed[1]):
        if path not in listed[0] or path not in listed[1]:
            verdict = "missing"
        elif (old / path).read_bytes() == (new / path).read_bytes():
            verdict = "same bytes"
        else:
            texts = [text(side / path) for side in (old, new)]
            expected = with_names(texts[0].replace(ids[0], ids[1]), path, renamed)
            verdict = "same but for names" if expected == with_names(texts[1], path, {}) else "differs"
        counts[verdict] += 1
        if verdict in ("missing", "differs"):
            differing.append(f"{path} {verdict}")
    return counts, differing


def text(path: Path) -> str:
    if path.suffix == ".usdc":
        from pxr import Sdf  # pyright: ignore[reportMissingImports] (the judges' environment has it)

        return Sdf.Layer.OpenAsAnonymous(str(path)).ExportToString()
    return path.read_bytes().decode("utf-8", errors="replace")


def with_names(content: str, path: Path, renamed: dict):
    """JSON files as values with their keys renamed, reports with the settings they list renamed, other files as they
    are."""
    if path.name == "manifest.json":
        return sorted(paths_of(json.loads(content)))
    if path.suffix == ".json":
        return named(json.loads(content), renamed)
    if path.suffix == ".html":
        return re.sub(r"(?<=\.)\w+(?=</dt>)", lambda key: renamed.get(key[0], key[0]), content)
    return content


def paths_of(manifest) -> list:
    """The manifest's files; their digests follow from the files, which are compared themselves."""
    return [entry["path"] for entry in manifest["files"]]


def named(value, renamed: dict):
    if isinstance(value, dict):
        return {renamed.get(key, key): named(item, renamed) for key, item in value.items()}
    if isinstance(value, list):
        return [named(item, renamed) for item in value]
    return renamed.get(value, value) if isinstance(value, str) else value


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Problem as problem:
        sys.exit(f"comparing: {problem}")
