"""yourdfpy loads every URDF without a word, with the scene's masses, inertias and sizes."""

import logging
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import yourdfpy

from verdict import Verdict, bodies, differs, inertia_tensor, read_scene


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("urdf")
    scene = read_scene(bundle)
    for body in bodies(scene):
        robot = load(verdict, bundle, bundle / "urdf" / body["name"] / f"{body['name']}.urdf")
        if robot is not None:
            check(verdict, body, robot)
    robot = load(verdict, bundle, bundle / "urdf" / "scene.urdf")
    if robot is not None:
        for body in bodies(scene):
            found = robot.get_transform(body["name"], robot.base_link)
            if differs(found, body["world_from_object"], absolute=1e-5):
                verdict.complaints.append(f"urdf/scene.urdf: the pose of {body['name']} is not the scene's")
    check_names(verdict, bundle / "urdf" / "scene.urdf")
    verdict.facts = {"descriptions": len(scene["instances"]) + 2}
    return verdict


def check_names(verdict, path):
    """Names of links, visuals and collisions of an assembly, each of which some loaders use as a key."""
    root = ElementTree.parse(path).getroot()
    for kind in ("link", "visual", "collision"):
        names = [element.get("name") for element in root.iter(kind)]
        if len(set(names)) < len(names):
            verdict.complaints.append(f"urdf/scene.urdf: {len(names) - len(set(names))} names of a {kind} repeat")


def load(verdict, bundle, path):
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


def check(verdict, body, robot):
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
