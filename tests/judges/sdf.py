"""Drake loads every model; mass, center of mass, inertia and hulls are the scene's, and so are the world's poses. Then
everything is simulated for five seconds, or for as long as is asked for. Rest is not promised in Drake
(rest_programs.toml says why), so what moves by a little is a fact and what leaves its place a complaint.

It loads them in a process of its own: Drake does not bear the other programs in one. The world is read as XML, since
Drake 1.51 ends with a segmentation fault on worlds of many models, each of which it loads.
"""

import json
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

from scipy.spatial.transform import Rotation

from overheard import Overheard
from rest import DURATION_S, check_rest
from verdict import Verdict, bodies, differs, inertia_tensor, matrix, read_scene

PROGRAM = "Drake 1.51.0, SDF"
FALLEN_MM = 50.0


def judge(bundle: Path, duration_s: float = DURATION_S) -> Verdict:
    command = [sys.executable, __file__, str(bundle)]
    run = subprocess.run(command, capture_output=True, text=True, timeout=600)
    if run.returncode != 0:
        return Verdict("sdf", [f"Drake fails: {run.stderr.strip()[-500:]}"])
    verdict = Verdict("sdf", **json.loads(run.stdout))
    if not verdict.complaints:
        found = check_rest(verdict, bundle, PROGRAM, duration_s)
        for name, (moved_mm, turned_deg) in found.unstable.items():
            if moved_mm > FALLEN_MM:
                verdict.complaints.append(f"{name} moves by {moved_mm} mm and turns by {turned_deg} degrees in Drake")
        if found.deepest_share > 1.0:
            verdict.complaints.append(f"{found.deepest} are {found.depth_mm:.1f} mm in each other in Drake")
    return verdict


def judge_here(bundle: Path) -> Verdict:
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
    verdict.facts = {"bodies": len(bodies(scene)), "hulls": hulls}
    return verdict


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
    found = judge_here(Path(sys.argv[1]))
    print(json.dumps({"complaints": found.complaints, "facts": found.facts}))
