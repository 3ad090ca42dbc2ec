"""Bundles loaded in simulators, as the README of each bundle has it. Functions import their packages when called."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tabletopgen._media import imported


def mujoco(bundle: Path) -> Any:
    """The `mujoco.MjModel` of the whole scene. Collision shapes are in geom group 3, visual meshes in group 2."""
    return imported("mujoco").MjModel.from_xml_path(str(bundle / "mjcf" / "scene.xml"))


def pybullet(bundle: Path, client: int = 0) -> dict[str, int]:
    """Loads table and objects into the connected physics client `client`; body by name. Its gravity stays as it is."""
    p = imported("pybullet")
    # Hulls then touch without margins, which lift objects by 2 mm.
    p.setPhysicsEngineParameter(enableSAT=1, physicsClientId=client)
    flags = p.URDF_USE_INERTIA_FROM_FILE | p.URDF_INITIALIZE_SAT_FEATURES
    bodies = {}
    for body in bodies_of(bundle):
        path = str(bundle / "urdf" / body["name"] / f"{body['name']}.urdf")
        fixed = "translation_m" not in body
        number = p.loadURDF(path, useFixedBase=fixed, flags=flags, physicsClientId=client)
        bodies[body["name"]] = number
        if not fixed:
            # PyBullet places the center of mass; this places the frame of the object.
            center = p.getDynamicsInfo(number, -1, physicsClientId=client)[3:5]
            pose = p.multiplyTransforms(body["translation_m"], body["rotation_xyzw"], *center)
            p.resetBasePositionAndOrientation(number, *pose, physicsClientId=client)
    return bodies


def sapien(bundle: Path, scene: Any = None) -> Any:
    """Adds table and objects to a `sapien.Scene`, such as that of ManiSkill, and returns the scene. Without one, it is
    a new scene without a renderer, with contacts for small objects; a scene of yours keeps its settings."""
    package = imported("sapien")
    if scene is None:
        # With the usual contacts PhysX finds hulls inside each other that are not: cups and coins jump.
        package.physx.set_scene_config(enable_pcm=False)
        package.physx.set_shape_config(contact_offset=0.002)
        scene = package.Scene([package.physx.PhysxCpuSystem()])
    is_drawn = has_renderer(scene)
    for body in bodies_of(bundle):
        loader = scene.create_urdf_loader()
        loader.set_material(body["friction"]["static"], body["friction"]["dynamic"], body["restitution"])
        _, [builder], _ = loader.parse(str(bundle / "urdf" / body["name"] / f"{body['name']}.urdf"))
        if not is_drawn:
            builder.visual_records.clear()
        x, y, z, w = body.get("rotation_xyzw", (0, 0, 0, 1))
        builder.set_initial_pose(package.Pose(body.get("translation_m", (0, 0, 0)), (w, x, y, z)))
        builder.set_physx_body_type("dynamic" if "translation_m" in body else "kinematic")
        builder.build(body["name"])
    return scene


def has_renderer(scene: Any) -> bool:
    """Whether a `sapien.Scene` can draw, without which shapes to draw are refused."""
    try:
        scene.get_system("render")
    except RuntimeError:
        return False
    return True


def usd_path(bundle: Path) -> Path:
    """The stage that references the layers of all bodies."""
    return next(path for path in sorted((bundle / "usd").glob("scene.usd*")))


def bodies_of(bundle: Path) -> list[dict[str, Any]]:
    """The table, which has no pose, and the objects."""
    scene = json.loads((bundle / "scene.json").read_text(encoding="utf-8"))
    return [scene["table"], *scene["instances"]]
