"""PyBullet loads every body's URDF at its pose, and everything stays where it is for five seconds.

With PyBullet's own time step and solver settings, the table fixed, each free body with its inertia from the file.
"""

import math
from pathlib import Path

import numpy as np

from overheard import Overheard
from verdict import Verdict, bodies, read_scene

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
        settle(verdict, bundle, client)
    finally:
        pybullet.disconnect(client)
    return verdict


def settle(verdict, bundle, client):
    pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
    pybullet.setTimeStep(STEP_S, physicsClientId=client)
    scene = bodies(read_scene(bundle))
    indices = {body["name"]: load(bundle, body, client) for body in scene}
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


def load(bundle, body, client) -> int:
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
