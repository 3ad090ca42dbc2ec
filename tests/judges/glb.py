"""The Khronos validator finds no error in any GLB; the scene's nodes stand where scene.json says."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import trimesh

from verdict import Verdict, bodies, differs, read_scene

# glTF is y up: (x, y, z) of the world is (x, z, -y) there.
GLTF_FROM_WORLD = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], dtype=float)


def validate(paths) -> list:
    environment = Path(sys.prefix)
    node = environment / "bin" / "node"
    script = Path(__file__).with_name("gltf_validate.mjs")
    run = subprocess.run(
        [str(node), str(script), str(environment / "node")],
        input=json.dumps([os.fspath(path) for path in paths]),
        capture_output=True,
        text=True,
        timeout=300,
    )
    if run.returncode != 0:
        raise RuntimeError(f"the glTF validator did not run: {run.stderr.strip()[:2000]}")
    return json.loads(run.stdout)


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("glb")
    scene = read_scene(bundle)
    wanted = ["glb/scene.glb"] + [body["mesh"] for body in bodies(scene)]
    missing = [path for path in wanted if not (bundle / path).is_file()]
    verdict.complaints += [f"{path} is missing" for path in missing]
    results = validate([bundle / path for path in wanted if path not in missing])
    for result in results:
        if result["errors"]:
            path = Path(result["path"]).relative_to(bundle)
            verdict.complaints.append(f"{path}: {result['errors']} errors: {'; '.join(result['messages'])}")
    warnings = sum(result["warnings"] for result in results)
    verdict.facts = {"files": len(results), "warnings": warnings}
    if warnings:
        verdict.facts["first_warning"] = next(r["messages"][0] for r in results if r["warnings"])
    if not missing:
        check_poses(verdict, bundle, scene)
    return verdict


def check_poses(verdict, bundle, scene):
    loaded = trimesh.load_scene(bundle / "glb" / "scene.glb")
    for body in bodies(scene):
        name = body["name"]
        if name not in loaded.graph.nodes:
            verdict.complaints.append(f"glb/scene.glb has no node {name}")
            continue
        pose, _ = loaded.graph.get(name)
        if differs(pose, GLTF_FROM_WORLD @ body["world_from_object"], absolute=1e-5):
            verdict.complaints.append(f"glb/scene.glb: the pose of {name} is not the scene's")
        low, high = trimesh.load_scene(bundle / body["mesh"]).bounds
        extent = np.asarray(high) - low
        size = np.asarray(body["size_m"])[[0, 2, 1]]
        if differs(extent, size, 1e-3, 2e-4):
            verdict.complaints.append(f"{body['mesh']} measures {extent}, not {size} (y up)")
