"""PyBullet loads every URDF without a word, with the scene's masses, inertias and hulls; each body at its pose stays there
for five seconds.

With PyBullet's own time step and solver settings, the table fixed, each free body with its inertia from the file.
"""

import math
from pathlib import Path

import numpy as np

from overheard import Overheard
from verdict import Verdict, bodies, differs, inertia_tensor, read_scene

with Overheard():  # it greets on standard output
    import pybullet

DURATION_S = 5.0
STEP_S = 1.0 / 240.0
DISPLACEMENT_M = 0.03
TURN_RAD = math.radians(30)


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("bullet")
    client = pybullet.connect(pybullet.DIRECT)
    try:
        check_descriptions(verdict, bundle, client)
        pybullet.resetSimulation(physicsClientId=client)
        settle(verdict, bundle, client)
    finally:
        pybullet.disconnect(client)
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
    # Bullet fixes what it is told to fix and loads free bodies with their mass.
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


def settle(verdict, bundle, client):
    pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
    pybullet.setTimeStep(STEP_S, physicsClientId=client)
    scene = bodies(read_scene(bundle))
    indices = {body["name"]: place(bundle, body, client) for body in scene}
    movable = [body["name"] for body in scene if body["movable"]]
    start = {name: pose(indices[name], client) for name in movable}
    for _ in range(round(DURATION_S / STEP_S)):
        pybullet.stepSimulation(physicsClientId=client)
    moved = {}
    for name in movable:
        (position, turn), (first_position, first_turn) = pose(indices[name], client), start[name]
        distance = float(np.linalg.norm(position - first_position))
        angle = 2.0 * math.acos(min(1.0, abs(float(turn @ first_turn))))
        moved[name] = (distance, angle) if math.isfinite(distance + angle) else (math.inf, math.pi)
    unstable = {name: (d, a) for name, (d, a) in moved.items() if d >= DISPLACEMENT_M or a >= TURN_RAD}
    verdict.facts = {
        "movable": len(movable),
        "stable": len(movable) - len(unstable),
        "largest_displacement_mm": round(1e3 * max((d for d, _ in moved.values()), default=0.0), 3),
        "unstable": {name: [round(1e3 * d, 1), round(math.degrees(a), 1)] for name, (d, a) in unstable.items()},
    }


def place(bundle, body, client) -> int:
    name = body["name"]
    flags = pybullet.URDF_USE_INERTIA_FROM_FILE
    with Overheard():
        index = pybullet.loadURDF(
            str(bundle / "urdf" / name / f"{name}.urdf"), flags=flags, useFixedBase=not body["movable"],
            physicsClientId=client,
        )
    if body["movable"]:
        # PyBullet places the center of mass; this places the object's frame.
        center = pybullet.getDynamicsInfo(index, -1, physicsClientId=client)[3:5]
        placed = pybullet.multiplyTransforms(body["translation_m"], body["rotation_xyzw"], *center)
        pybullet.resetBasePositionAndOrientation(index, *placed, physicsClientId=client)
    return index


def pose(index, client):
    """Of the center of mass, along the principal axes."""
    position, turn = pybullet.getBasePositionAndOrientation(index, physicsClientId=client)
    return np.asarray(position), np.asarray(turn)
