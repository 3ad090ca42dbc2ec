"""PyBullet and yourdfpy load every URDF without a word, with the scene's masses, inertias and hulls."""

import logging
from pathlib import Path

import numpy as np
import yourdfpy

from overheard import Overheard
from verdict import Verdict, bodies, differs, inertia_tensor, read_scene

with Overheard():  # it greets on standard output
    import pybullet


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("urdf")
    scene = read_scene(bundle)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        for body in bodies(scene):
            name = body["name"]
            path = bundle / "urdf" / name / f"{name}.urdf"
            index = load_bullet(verdict, bundle, path, client)
            if index is not None:
                check_bullet(verdict, body, index, client)
            robot = load_yourdfpy(verdict, bundle, path)
            if robot is not None:
                check_yourdfpy(verdict, body, robot)
            pybullet.resetSimulation(physicsClientId=client)
        path = bundle / "urdf" / "scene.urdf"
        index = load_bullet(verdict, bundle, path, client)
        wanted = len(scene["instances"]) + 1
        if index is not None and pybullet.getNumJoints(index, physicsClientId=client) != wanted:
            verdict.complaints.append(f"urdf/scene.urdf does not hold {wanted} bodies")
        robot = load_yourdfpy(verdict, bundle, path)
        if robot is not None:
            for body in bodies(scene):
                found = robot.get_transform(body["name"], robot.base_link)
                if differs(found, body["world_from_object"], absolute=1e-5):
                    verdict.complaints.append(f"urdf/scene.urdf: the pose of {body['name']} is not the scene's")
    finally:
        pybullet.disconnect(client)
    verdict.facts = {"descriptions": len(scene["instances"]) + 2}
    return verdict


def load_bullet(verdict, bundle, path, client):
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


def check_bullet(verdict, body, index, client):
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


def load_yourdfpy(verdict, bundle, path):
    heard = []

    class Listener(logging.Handler):
        def emit(self, record):
            heard.append(record.getMessage())

    listener = Listener(logging.WARNING)
    loggers = [logging.getLogger(name) for name in ("yourdfpy", "yourdfpy.urdf")]
    for logger in loggers:
        logger.addHandler(listener)
    try:
        robot = yourdfpy.URDF.load(str(path), load_collision_meshes=True, build_collision_scene_graph=True)
        if not robot.validate():
            verdict.complaints.append(f"{path.relative_to(bundle)}: yourdfpy: {robot.errors}")
    except Exception as error:  # a reader may raise anything on a file it does not like
        verdict.complaints.append(f"{path.relative_to(bundle)}: yourdfpy: {error!r}")
        robot = None
    finally:
        for logger in loggers:
            logger.removeHandler(listener)
    if heard:
        verdict.complaints.append(f"{path.relative_to(bundle)}: yourdfpy says {heard[0]!r}")
    return robot


def check_yourdfpy(verdict, body, robot):
    name = body["name"]
    link = robot.link_map[name]
    pairs = {
        "mass": (link.inertial.mass, body["mass_kg"], 1e-9),
        "inertia": (link.inertial.inertia, inertia_tensor(body), 1e-9),
        "center of mass": (link.inertial.origin[:3, 3], body["center_of_mass_m"], 1e-9),
    }
    for what, (got, wanted, absolute) in pairs.items():
        if differs(got, wanted, 1e-6, absolute):
            verdict.complaints.append(f"{name}: yourdfpy's {what} is {got}, not {wanted}")
    low, high = robot.scene.bounds
    if differs(np.asarray(high) - low, body["size_m"], 1e-3, 2e-4):
        verdict.complaints.append(f"{name}: the visual mesh measures {high - low}, not {body['size_m']}")
