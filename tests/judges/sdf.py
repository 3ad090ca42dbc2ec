"""Drake loads every model; mass, center of mass, inertia and hulls are the scene's, and so are the world's poses. Then
all models together stay where they are for five seconds of hydroelastic contact, or for as long as is asked for.

It does so in a process of its own: Drake does not bear the other programs in one. The world is read as XML, since
Drake 1.51 ends with a segmentation fault on worlds of many models, each of which it loads.
"""

import json
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from overheard import Overheard
from verdict import Verdict, bodies, differs, inertia_tensor, matrix, read_scene

STEP_S = 0.005
DURATION_S = 5.0
DISPLACEMENT_M = 0.03
# Apples slide into each other by 3 mm in a bowl; a ruler that sank did so by 7 mm.
SINKING_M = 0.005


def judge(bundle: Path, duration_s: float = DURATION_S) -> Verdict:
    command = [sys.executable, __file__, str(bundle), str(duration_s)]
    run = subprocess.run(command, capture_output=True, text=True, timeout=600)
    if run.returncode != 0:
        return Verdict("sdf", [f"Drake fails: {run.stderr.strip()[-500:]}"])
    return Verdict("sdf", **json.loads(run.stdout))


def judge_here(bundle: Path, duration_s: float) -> Verdict:
    verdict = Verdict("sdf")
    scene = read_scene(bundle)
    world = ElementTree.parse(bundle / "sdf" / "world.sdf").getroot().find("world")
    models = {model.get("name"): model for model in world.findall("model")}
    hulls = 0
    for body in bodies(scene):
        name = body["name"]
        plant, said = load(bundle / "sdf" / "models" / name / "model.sdf")
        if said:
            verdict.complaints.append(f"sdf/models/{name}/model.sdf: Drake says {said[:300]!r}")
        hulls += check_body(verdict, body, plant, plant.GetBodyByName(name))
        if name not in models:
            verdict.complaints.append(f"sdf/world.sdf has no model {name}")
        else:
            check_placed(verdict, body, models[name], bundle)
    verdict.facts = {"bodies": len(bodies(scene)), "hulls": hulls, "simulated_s": duration_s}
    if not verdict.complaints:
        check_rest(verdict, bundle, scene, duration_s)
    return verdict


def check_rest(verdict, bundle, scene, duration_s):
    """Drake's own steps: nothing leaves its place, and nothing sinks."""
    from pydrake.common.eigen_geometry import Quaternion
    from pydrake.math import RigidTransform
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=STEP_S)
    for body in bodies(scene):
        Parser(plant).AddModels(str(bundle / "sdf" / "models" / body["name"] / "model.sdf"))
    for instance in scene["instances"]:
        x, y, z, w = instance["rotation_xyzw"]
        pose = RigidTransform(Quaternion(w, x, y, z), instance["translation_m"])
        plant.SetDefaultFloatingBaseBodyPose(plant.GetBodyByName(instance["name"]), pose)
    plant.Finalize()
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(duration_s)
    context = plant.GetMyContextFromRoot(simulator.get_context())
    moved, sunk = {}, {}
    for instance in scene["instances"]:
        name = instance["name"]
        way = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(name)).translation() - instance["translation_m"]
        moved[name], sunk[name] = float(np.linalg.norm(way)), float(-way[2])
        if not moved[name] < DISPLACEMENT_M:
            verdict.complaints.append(f"{name} moves by {1e3 * moved[name]:.1f} mm in Drake")
        elif sunk[name] > SINKING_M:
            verdict.complaints.append(f"{name} sinks by {1e3 * sunk[name]:.1f} mm in Drake")
    verdict.facts["largest_displacement_mm"] = round(1e3 * max(moved.values(), default=0.0), 3)
    verdict.facts["largest_sinking_mm"] = round(1e3 * max(sunk.values(), default=0.0), 3)


def check_placed(verdict, body, model, bundle):
    name = body["name"]
    x, y, z, roll, pitch, yaw = map(float, model.find("pose").text.split())
    turn = Rotation.from_euler("xyz", [roll, pitch, yaw]).as_quat()
    if differs(matrix([x, y, z], turn), body["world_from_object"], absolute=1e-6):
        verdict.complaints.append(f"{name}: the world's pose is not the scene's")
    if (model.find("static").text == "true") == body["movable"]:
        verdict.complaints.append(f"{name}: static is {model.find('static').text}")
    if differs(float(model.find("link/inertial/mass").text), body["mass_kg"]):
        verdict.complaints.append(f"{name}: the world's mass is not the scene's")
    for uri in model.iter("uri"):
        if not (bundle / "sdf" / uri.text).is_file():
            verdict.complaints.append(f"{name}: {uri.text} is missing")


def load(path):
    """(plant, what Drake printed)."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.002)
    with Overheard() as overheard:
        Parser(plant).AddModels(str(path))
        plant.Finalize()
    plant.diagram = builder.Build()  # keeps the scene graph alive
    # Restitution, resistance to spinning and the friction beside Drake's own are for Gazebo.
    known = ("Ignoring unsupported SDFormat element in ", "When drake contact parameters are fully specified")
    lines = [line for line in overheard.text.splitlines() if line.strip()]
    return plant, "\n".join(line for line in lines if not any(words in line for words in known))


def check_body(verdict, body, plant, link) -> int:
    name = body["name"]
    inertia = link.default_spatial_inertia()
    center = inertia.get_com()
    about_center = inertia.Shift(center).CalcRotationalInertia().CopyToFullMatrix3()
    pairs = {
        "mass": (inertia.get_mass(), body["mass_kg"], 1e-9),
        "center of mass": (center, body["center_of_mass_m"], 1e-6),
        "inertia": (about_center, inertia_tensor(body), 1e-9),
    }
    colliders = plant.GetCollisionGeometriesForBody(link)
    pairs["number of hulls"] = (len(colliders), body["hulls"], 0.0)
    for what, (got, wanted, absolute) in pairs.items():
        if differs(got, wanted, absolute=absolute):
            verdict.complaints.append(f"{name}: Drake's {what} is {got}, not {wanted}")
    return len(colliders)


if __name__ == "__main__":
    found = judge_here(Path(sys.argv[1]), float(sys.argv[2]))
    print(json.dumps({"complaints": found.complaints, "facts": found.facts}))
