"""MuJoCo loads the scene, finds the scene's masses, and everything rests for five seconds, as rest.py measures it.

The file of each object loads alone, and its sites enclose it as loaders of robosuite's kind expect.
"""

from pathlib import Path

import mujoco
import numpy as np

from rest import check_rest
from verdict import Verdict, bodies, differs, inertia_tensor, read_scene

PROGRAM = "MuJoCo 4.0.0"


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("mjcf")
    scene = read_scene(bundle)
    try:
        model = mujoco.MjModel.from_xml_path(str(bundle / "mjcf" / "scene.xml"))
    except ValueError as error:
        verdict.complaints.append(f"MuJoCo does not load it: {error}")
        return verdict
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for body in bodies(scene):
        check_body(verdict, model, data, body)
        if body["movable"]:
            check_object(verdict, bundle, body)
    if not verdict.complaints:
        verdict.facts["start_depth_mm"] = round(1e3 * max((-contact.dist for contact in data.contact), default=0.0), 3)
        check_rest(verdict, bundle, PROGRAM)
    return verdict


def check_object(verdict, bundle, body):
    name = body["name"]
    path = bundle / "mjcf" / name / f"{name}.xml"
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        verdict.complaints.append(f"mjcf/{name}/{name}.xml: MuJoCo does not load it: {error}")
        return
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    sites = {model.site(k).name: data.site_xpos[k] for k in range(model.nsite)}
    missing = {"bottom_site", "top_site", "horizontal_radius_site"} - set(sites)
    found = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "object")
    if missing or found < 0:
        verdict.complaints.append(f"mjcf/{name}/{name}.xml lacks {sorted(missing) or 'the body object'}")
        return
    corners = [visual_corners(model, data, g) for g in range(model.ngeom) if model.geom_group[g] == 1]
    hulls = [g for g in range(model.ngeom) if model.geom_group[g] == 0]
    corners = np.concatenate(corners)
    pairs = {
        "mass": (model.body_mass[found], body["mass_kg"], 1e-12),
        "number of hulls": (len(hulls), body["hulls"], 0.0),
        "bottom": (sites["bottom_site"][2], corners[:, 2].min(), 1e-5),
        "top": (sites["top_site"][2], corners[:, 2].max(), 1e-5),
        "radius": (sites["horizontal_radius_site"][0], np.linalg.norm(corners[:, :2], axis=1).max(), 1e-5),
    }
    for what, (got, wanted, absolute) in pairs.items():
        if differs(got, wanted, absolute=absolute):
            verdict.complaints.append(f"mjcf/{name}/{name}.xml: {what} is {got}, not {wanted}")


def visual_corners(model, data, geom):
    """Corners of the mesh of a geom, in the frame of the file."""
    mesh = model.geom_dataid[geom]
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    turn = data.geom_xmat[geom].reshape(3, 3)
    return model.mesh_vert[first : first + count] @ turn.T + data.geom_xpos[geom]


def check_body(verdict, model, data, body):
    name = body["name"]
    found = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
    if found < 0:
        verdict.complaints.append(f"there is no body {name}")
        return
    free = any(model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE for j in range(model.njnt) if model.jnt_bodyid[j] == found)
    if free != body["movable"]:
        verdict.complaints.append(f"{name}: a free joint is {'there' if free else 'missing'}")
    axes = np.zeros(9)
    mujoco.mju_quat2Mat(axes, model.body_iquat[found])
    axes = axes.reshape(3, 3)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = data.xmat[found].reshape(3, 3), data.xpos[found]
    collides = [g for g in range(model.ngeom) if model.geom_bodyid[g] == found and model.geom_contype[g]]
    pairs = {
        "mass": (model.body_mass[found], body["mass_kg"], 1e-12),
        "center of mass": (model.body_ipos[found], body["center_of_mass_m"], 1e-6),
        "inertia": (axes @ np.diag(model.body_inertia[found]) @ axes.T, inertia_tensor(body), 1e-12),
        "pose": (pose, body["world_from_object"], 1e-6),
        "number of hulls": (len(collides), body["hulls"], 0.0),
    }
    for geom in collides:
        pairs[f"friction of geom {geom}"] = (model.geom_friction[geom][0], body["friction"]["dynamic"], 1e-6)
    for what, (got, wanted, absolute) in pairs.items():
        if differs(got, wanted, absolute=absolute):
            verdict.complaints.append(f"{name}: {what} is {got}, not {wanted}")
