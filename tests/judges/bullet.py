"""PyBullet loads every URDF without a word, with the scene's masses, inertias and hulls; everything rests for five
seconds or for as long as is asked for, as rest.py measures it.
"""

from pathlib import Path

import numpy as np

from overheard import Overheard
from rest import DURATION_S, check_rest
from verdict import Verdict, bodies, differs, inertia_tensor, read_scene

with Overheard():  # it greets on standard output
    import pybullet

PROGRAM = "PyBullet 3.2.7"


def judge(bundle: Path, duration_s: float = DURATION_S) -> Verdict:
    verdict = Verdict("bullet")
    client = pybullet.connect(pybullet.DIRECT)
    try:
        check_descriptions(verdict, bundle, client)
    finally:
        pybullet.disconnect(client)
    if not verdict.complaints:
        check_rest(verdict, bundle, PROGRAM, duration_s)
    return verdict


def check_descriptions(verdict, bundle, client):
    scene = read_scene(bundle)
    for body in bodies(scene):
        path = bundle / "urdf" / body["name"] / f"{body['name']}.urdf"
        index = load(verdict, bundle, path, client)
        if index is not None:
            check(verdict, body, index, client)
        pybullet.resetSimulation(physicsClientId=client)
    index = load(verdict, bundle, bundle / "urdf" / "scene.urdf", client)
    wanted = len(scene["instances"]) + 1
    if index is not None and pybullet.getNumJoints(index, physicsClientId=client) != wanted:
        verdict.complaints.append(f"urdf/scene.urdf does not hold {wanted} bodies")


def load(verdict, bundle, path, client):
    index = None
    with Overheard() as overheard:
        try:
            flags = pybullet.URDF_USE_INERTIA_FROM_FILE
            index = pybullet.loadURDF(str(path), flags=flags, physicsClientId=client)
        except pybullet.error as error:
            verdict.complaints.append(f"{path.relative_to(bundle)}: PyBullet: {error}")
    spoken = [line for line in overheard.text.splitlines() if line.strip()]
    if spoken:
        verdict.complaints.append(f"{path.relative_to(bundle)}: PyBullet says {spoken[0]!r} ({len(spoken)} lines)")
    return index


def check(verdict, body, index, client):
    name = body["name"]
    info = pybullet.getDynamicsInfo(index, -1, physicsClientId=client)
    # Bullet loads free bodies with their mass, and fixes the others.
    moments = np.sort(np.linalg.eigvalsh(inertia_tensor(body)))
    shapes = pybullet.getCollisionShapeData(index, -1, physicsClientId=client)
    visuals = pybullet.getVisualShapeData(index, physicsClientId=client)
    pairs = {
        "mass": (info[0], body["mass_kg"], 1e-4, 1e-9),
        "principal moments": (np.sort(info[2]), moments, 1e-3, 1e-12),
        "center of mass": (info[3], body["center_of_mass_m"], 1e-4, 1e-6),
        "lateral friction": (info[1], body["friction"]["dynamic"], 1e-4, 1e-9),
        "restitution": (info[5], body["restitution"], 1e-4, 1e-9),
        "number of hulls": (len(shapes), body["hulls"], 0.0, 0.0),
    }
    for what, (got, wanted, relative, absolute) in pairs.items():
        if differs(got, wanted, relative, absolute):
            verdict.complaints.append(f"{name}: PyBullet's {what} is {got}, not {wanted}")
    if not visuals:
        verdict.complaints.append(f"{name}: PyBullet finds no visual mesh")
