"""Layouts of a bundle's objects, of any origin: colliding pairs, and five seconds of MuJoCo from there.

    target/judges/bin/python tests/judges/layouts.py LAYOUTS.json

LAYOUTS.json is a list of {"bundle": folder, "world_from_object": {name: 4x4 matrix}}; meters, z up, the table of the
bundle with its top at z = 0. What a layout does not name was not placed. Prints a list of findings in the same order.

The MuJoCo model is made here, of the bundle's collision shapes (those of its URDF bodies), masses, inertias and
friction, with MuJoCo's default contacts; the bundle's own MJCF is not read.
"""

import json
import math
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import mujoco
import numpy as np

from collisions import collision_depth, fcl_object
from rest import DURATION_S
from shapes import shapes
from solids import load_solid
from verdict import read_scene

TIMESTEP_S = 0.002
# Of the measure DSS, by which layouts of others are compared.
DISPLACEMENT_M = 0.03
TURN_RAD = math.radians(30)
AT_ONCE = 2


def judge(layout: dict) -> dict:
    """`colliding` are pairs on the visual meshes, with their depth; `hull_depth_mm` is MuJoCo's deepest contact before
    the first step; `moved_mm` and `turned_deg` are between the layout and five seconds later."""
    bundle, scene = Path(layout["bundle"]), read_scene(Path(layout["bundle"]))
    poses = {name: np.array(rows, dtype=float) for name, rows in layout["world_from_object"].items()}
    found = {"placed": len(poses), "colliding": colliding_pairs(bundle, scene, poses)}
    return found | simulated(bundle, scene, poses)


def colliding_pairs(bundle: Path, scene: dict, poses: dict) -> list:
    """(name, name, depth in mm) of every pair, the table included."""
    solids = {}
    for body in [scene["table"], *(instance for instance in scene["instances"] if instance["name"] in poses)]:
        solid, reason = load_solid(bundle / body["mesh"], poses.get(body["name"], np.eye(4)))
        if solid is None:
            raise RuntimeError(f"{bundle / body['mesh']} is no union of closed shells: {reason}")
        solids[body["name"]] = solid
    names, found = list(solids), []
    models = {name: fcl_object(solid) for name, solid in solids.items()}
    for k, a in enumerate(names):
        for b in names[k + 1 :]:
            depth_m = collision_depth(solids[a], solids[b], models[a], models[b])
            if depth_m is not None:
                found.append([a, b, round(1e3 * depth_m, 3)])
    return found


def simulated(bundle: Path, scene: dict, poses: dict) -> dict:
    model = model_of(bundle, scene, poses)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    hull_depth_m = max((-contact.dist for contact in data.contact), default=0.0)
    start, turn = data.xpos.copy(), data.xquat.copy()
    for _ in range(round(DURATION_S / TIMESTEP_S)):
        mujoco.mj_step(model, data)
    # MuJoCo resets a simulation that diverges, and counts that in this number.
    diverged = bool(data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number)
    moved_mm, turned_deg = {}, {}
    for name in poses:
        body = model.body(name).id
        dot = min(1.0, abs(float(np.dot(data.xquat[body], turn[body]))))
        moved_mm[name] = 1e3 * float(np.linalg.norm(data.xpos[body] - start[body]))
        turned_deg[name] = math.degrees(2 * math.acos(dot))
    at_rest = [
        name for name in poses
        if not diverged and moved_mm[name] < 1e3 * DISPLACEMENT_M and turned_deg[name] < math.degrees(TURN_RAD)
    ]
    return {"hull_depth_mm": max(0.0, 1e3 * hull_depth_m), "at_rest": at_rest, "moved_mm": moved_mm,
            "turned_deg": turned_deg}


def model_of(bundle: Path, scene: dict, poses: dict):
    spec = mujoco.MjSpec()
    spec.option.timestep = TIMESTEP_S
    floor = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    floor.pos = [0, 0, -scene["table"]["height_m"]]
    add_hulls(spec, spec.worldbody.add_body(name="table"), bundle, scene["table"])
    for instance in scene["instances"]:
        if instance["name"] not in poses:
            continue
        pose, quaternion = poses[instance["name"]], np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(pose[:3, :3]).reshape(9))
        body = spec.worldbody.add_body(name=instance["name"], pos=pose[:3, 3], quat=quaternion)
        body.add_freejoint()
        body.explicitinertial = True
        body.mass, body.inertia = instance["mass_kg"], instance["inertia_diagonal_kg_m2"]
        x, y, z, w = instance["principal_axes_xyzw"]
        body.ipos, body.iquat = instance["center_of_mass_m"], [w, x, y, z]
        add_hulls(spec, body, bundle, instance)
    return spec.compile()


def add_hulls(spec, body, bundle: Path, entry: dict):
    found = shapes(bundle, entry["name"])
    if len(found) != entry["hulls"]:
        raise RuntimeError(f"{bundle} has {len(found)} hulls of {entry['name']}, scene.json says {entry['hulls']}")
    for shape in found:
        if shape.kind == "mesh":
            mesh = spec.add_mesh(name=f"{entry['name']}/{shape.path.stem}")
            lines = shape.path.read_text(encoding="utf-8").splitlines()
            mesh.uservert = [float(part) for line in lines if line.startswith("v ") for part in line.split()[1:4]]
            # The body's inertia is given; this only lets hulls as thin as paper pass.
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
            geom = body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name)
        else:
            x, y, z, w = shape.rotation.as_quat()
            geom = body.add_geom(pos=shape.position, quat=[w, x, y, z])
            geom.type, geom.size = simple(shape)
        geom.friction = [entry["friction"]["dynamic"], 0.005, 0.0001]


def simple(shape):
    """Type and size of a geom that is no mesh."""
    if shape.kind == "box":
        return mujoco.mjtGeom.mjGEOM_BOX, [0.5 * side for side in shape.sizes]
    if shape.kind == "cylinder":
        return mujoco.mjtGeom.mjGEOM_CYLINDER, [shape.sizes[0], 0.5 * shape.sizes[1], 0.0]
    return mujoco.mjtGeom.mjGEOM_SPHERE, [shape.sizes[0], 0.0, 0.0]


def main() -> int:
    layouts = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    with ProcessPoolExecutor(AT_ONCE) as pool:
        print(json.dumps(list(pool.map(judge, layouts))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
