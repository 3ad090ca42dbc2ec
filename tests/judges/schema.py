"""scene.json fits the schema it ships with; the manifest tells every file as it is."""

import hashlib
import json
from pathlib import Path

import jsonschema

from verdict import Verdict, read_scene


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("schema")
    schema = json.loads((bundle / "scene.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    scene = read_scene(bundle)
    for error in jsonschema.Draft202012Validator(schema).iter_errors(scene):
        verdict.complaints.append(f"scene.json at {error.json_path}: {error.message[:200]}")
    check_supports(verdict, scene)
    manifest = json.loads((bundle / "manifest.json").read_text(encoding="utf-8"))
    listed = {entry["path"]: entry for entry in manifest["files"]}
    found = {p.relative_to(bundle).as_posix() for p in bundle.rglob("*") if p.is_file()}
    # Stage artifacts may lie beside a bundle that was written unpacked.
    found = {path for path in found if not path.startswith("artifacts/")}
    for path in sorted(set(listed) ^ (found - {"manifest.json"})):
        verdict.complaints.append(f"{path} is {'missing' if path in listed else 'not in the manifest'}")
    for path in sorted(set(listed) & found):
        content = (bundle / path).read_bytes()
        entry = listed[path]
        if len(content) != entry["size"] or hashlib.sha256(content).hexdigest() != entry["sha256"]:
            verdict.complaints.append(f"{path} is not the file of the manifest")
    verdict.facts = {"files": len(found)}
    return verdict


def check_supports(verdict, scene):
    """Every chain of supports ends at the table."""
    parents = {o["name"]: o["support"]["parent"] for o in scene["instances"]}
    if len(parents) != len(scene["instances"]):
        verdict.complaints.append("two instances share a name")
    for name in parents:
        at, steps = name, 0
        while at in parents and steps <= len(parents):
            at, steps = parents[at], steps + 1
        if at != scene["table"]["name"]:
            verdict.complaints.append(f"the supports of {name} do not end at the table")
