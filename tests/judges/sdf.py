"""Drake loads the world and every model; mass, center of mass, inertia, pose, friction and hulls are the scene's."""

from pathlib import Path

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from overheard import Overheard
from verdict import Verdict, bodies, differs, inertia_tensor, read_scene

IGNORED = ("world: gravity", "world: light")


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("sdf")
    scene = read_scene(bundle)
    plant, heard = load(bundle / "sdf" / "world.sdf")
    if heard:
        verdict.complaints.append(f"sdf/world.sdf: Drake says {heard[:300]!r}")
    names = {plant.GetModelInstanceName(instance) for instance in model_instances(plant)}
    hulls = 0
    for body in bodies(scene):
        name = body["name"]
        alone, said = load(bundle / "sdf" / "models" / name / "model.sdf")
        if said:
            verdict.complaints.append(f"sdf/models/{name}/model.sdf: Drake says {said[:300]!r}")
        check_body(verdict, body, alone, alone.GetBodyByName(name), None)
        found = next((n for n in names if n.split("::")[-1] == name), None)
        if found is None:
            verdict.complaints.append(f"sdf/world.sdf has no model {name}")
            continue
        link = plant.GetBodyByName(name, plant.GetModelInstanceByName(found))
        hulls += check_body(verdict, body, plant, link, body["world_from_object"])
    verdict.facts = {"bodies": len(bodies(scene)), "hulls": hulls}
    return verdict


def load(path):
    """(plant, what Drake printed)."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.002)
    with Overheard() as overheard:
        Parser(plant).AddModels(str(path))
        plant.Finalize()
    plant.diagram = builder.Build()  # keeps the scene graph alive
    return plant, "\n".join(line for line in overheard.text.splitlines() if line.strip() and not is_known(line))


def is_known(line):
    """Drake has no light and a gravity of its own, and says so."""
    return any(f"Ignoring unsupported SDFormat element in {what}" in line for what in IGNORED)


def model_instances(plant):
    from pydrake.multibody.tree import ModelInstanceIndex

    return [ModelInstanceIndex(k) for k in range(plant.num_model_instances())]


def check_body(verdict, body, plant, link, world_from_object) -> int:
    name = body["name"]
    inertia = link.default_spatial_inertia()
    center = inertia.get_com()
    about_center = inertia.Shift(center).CalcRotationalInertia().CopyToFullMatrix3()
    pairs = {
        "mass": (inertia.get_mass(), body["mass_kg"], 1e-9),
        "center of mass": (center, body["center_of_mass_m"], 1e-6),
        "inertia": (about_center, inertia_tensor(body), 1e-9),
    }
    if world_from_object is not None:
        context = plant.CreateDefaultContext()
        pose = plant.EvalBodyPoseInWorld(context, link).GetAsMatrix4()
        pairs["pose"] = (pose, world_from_object, 1e-6)
    colliders = plant.GetCollisionGeometriesForBody(link)
    pairs["number of hulls"] = (len(colliders), body["hulls"], 0.0)
    for what, (got, wanted, absolute) in pairs.items():
        if differs(got, wanted, absolute=absolute):
            verdict.complaints.append(f"{name}: Drake's {what} is {got}, not {wanted}")
    return len(colliders)
