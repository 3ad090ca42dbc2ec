"""OpenUSD opens the stage and every prop; all of its validators are silent; physics is the scene's."""

import math
from pathlib import Path

import numpy as np
import trimesh
from pxr import Sdf, Usd, UsdGeom, UsdPhysics, UsdSemantics, UsdShade, UsdValidation

from overheard import Overheard
from shapes import shapes
from verdict import Verdict, bodies, differs, inertia_tensor, read_scene, rotation

VALIDATORS = 30
_context = None


def validate(stage) -> list:
    global _context
    if _context is None:
        validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
        assert len(validators) >= VALIDATORS, f"only {len(validators)} validators"
        _context = UsdValidation.ValidationContext(validators)
    return [f"{error.GetName()}: {error.GetMessage()}" for error in _context.Validate(stage)]


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("usd")
    scene = read_scene(bundle)
    files = sorted((bundle / "usd").glob("scene.usd*"))
    if len(files) != 1:
        verdict.complaints.append(f"usd/scene.usd[a] should be one file, found {len(files)}")
        return verdict
    layers = files + sorted((bundle / "usd" / "assets").glob("*/simready_usd/*.usd*")) + packed_layers(files[0])
    errors = 0
    for path in layers:
        name = str(path).removeprefix(f"{bundle}/")
        with Overheard() as heard:
            stage = Usd.Stage.Open(str(path))
        if heard.text:
            verdict.complaints.append(f"{name}: OpenUSD says {heard.text[:300]!r}")
        if not stage or not stage.GetDefaultPrim():
            verdict.complaints.append(f"{name} does not open or has no default prim")
            continue
        if UsdGeom.GetStageUpAxis(stage) != "Z" or UsdGeom.GetStageMetersPerUnit(stage) != 1.0:
            verdict.complaints.append(f"{name} is not z up in meters")
        if UsdPhysics.GetStageKilogramsPerUnit(stage) != 1.0:
            verdict.complaints.append(f"{name} is not in kilograms")
        found = validate(stage)
        errors += len(found)
        verdict.complaints += [f"{name}: {error}" for error in found]
        for prim in stage.Traverse():
            check_extent(verdict, name, prim)
    stage = Usd.Stage.Open(str(files[0]))
    root = stage.GetDefaultPrim().GetPath()
    hulls = 0
    for body in bodies(scene):
        prim = stage.GetPrimAtPath(root.AppendChild(body["name"]))
        if not prim or not prim.HasAPI(UsdPhysics.RigidBodyAPI) or not prim.HasAPI(UsdPhysics.MassAPI):
            verdict.complaints.append(f"{body['name']} is no rigid body with a mass on the stage")
            continue
        hulls += check_body(verdict, body, prim)
        check_words(verdict, body, prim)
        check_shapes(verdict, bundle, body, prim)
    if not any(prim.IsA(UsdPhysics.Scene) for prim in stage.Traverse()):
        verdict.complaints.append("there is no physics scene")
    if len(layers) < len(bodies(scene)) + 1:
        verdict.complaints.append(f"{len(layers)} layers for {len(bodies(scene))} bodies and a stage")
    verdict.facts = {"bodies": len(scene["instances"]) + 1, "hulls": hulls, "layers": len(layers), "validator_errors": errors}
    return verdict


def packed_layers(stage: Path) -> list:
    """Every layer but the first, which is the package itself, in OpenUSD's spelling."""
    if stage.suffix != ".usdz":
        return []
    names = Sdf.ZipFile.Open(str(stage)).GetFileNames()
    return [f"{stage}[{name}]" for name in names[1:] if Path(name).suffix.startswith(".usd")]


def check_extent(verdict, path, prim):
    if prim.IsA(UsdGeom.Mesh):
        authored = UsdGeom.Boundable(prim).GetExtentAttr().Get()
        computed = UsdGeom.PointBased.ComputeExtent(UsdGeom.PointBased(prim).GetPointsAttr().Get())
        if authored is None or differs(authored, computed, 0.0, 1e-10):
            verdict.complaints.append(f"{path}: the extent of {prim.GetPath()} is {authored}, not {computed}")


def check_body(verdict, body, prim) -> int:
    name = body["name"]
    if UsdPhysics.RigidBodyAPI(prim).GetRigidBodyEnabledAttr().Get() != body["movable"]:
        verdict.complaints.append(f"{name}: rigidBodyEnabled should be {body['movable']}")
    mass = UsdPhysics.MassAPI(prim)
    axes = mass.GetPrincipalAxesAttr().Get()
    frame = rotation([*axes.GetImaginary(), axes.GetReal()])
    moments = mass.GetDiagonalInertiaAttr().Get()
    pairs = {
        "mass": (mass.GetMassAttr().Get(), body["mass_kg"]),
        "center of mass": (list(mass.GetCenterOfMassAttr().Get()), body["center_of_mass_m"]),
        "inertia": (frame @ [[moments[0], 0, 0], [0, moments[1], 0], [0, 0, moments[2]]] @ frame.T, inertia_tensor(body)),
    }
    world = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0)
    pairs["pose"] = ([list(row) for row in world.GetTranspose()], body["world_from_object"])
    for what, (found, wanted) in pairs.items():
        if differs(found, wanted, absolute=1e-6 if what in ("pose", "center of mass") else 1e-12):
            verdict.complaints.append(f"{name}: {what} is not the scene's")
    hulls = 0
    for child in Usd.PrimRange(prim):
        if child != prim and child.HasAPI(UsdPhysics.RigidBodyAPI):
            verdict.complaints.append(f"{name}: a rigid body is nested at {child.GetPath()}")
        if child.HasAPI(UsdPhysics.CollisionAPI):
            hulls += 1
            approximation = UsdPhysics.MeshCollisionAPI(child).GetApproximationAttr().Get()
            wanted = "convexHull" if child.IsA(UsdGeom.Mesh) else None
            purpose = UsdGeom.Imageable(child).ComputePurpose()
            if approximation != wanted or purpose != "guide":
                verdict.complaints.append(f"{child.GetPath()}: {approximation}, purpose {purpose}")
            check_material(verdict, body, child)
    if hulls != body["hulls"]:
        verdict.complaints.append(f"{name}: {hulls} hulls instead of {body['hulls']}")
    return hulls


def check_words(verdict, body, prim):
    # No text of USD holds a NUL.
    pairs = {"label": (prim.GetDisplayName(), body["label"].replace("\0", "\ufffd"))}
    if "category" in body:
        pairs["category"] = (list(labels(prim, "class")), [body["category"]])
    for what, (found, wanted) in pairs.items():
        if found != wanted:
            verdict.complaints.append(f"{body['name']}: {what} is {found!r}, not {wanted!r}")
    if not all(item.startswith("Q") for item in labels(prim, "wikidata_qcode")):
        verdict.complaints.append(f"{body['name']}: no item of Wikidata")


def labels(prim, kind):
    return UsdSemantics.LabelsAPI(prim, kind).GetLabelsAttr().Get() or []


def check_shapes(verdict, bundle, body, prim):
    """Kinds, places and volumes of colliders, and extents of what is seen, against the URDF, whose meshes trimesh
    reads."""
    meshes = [UsdGeom.Mesh(child) for child in Usd.PrimRange(prim) if child.IsA(UsdGeom.Mesh)]
    colliders = sorted((c for c in Usd.PrimRange(prim) if c.HasAPI(UsdPhysics.CollisionAPI)), key=lambda c: str(c.GetPath()))
    for k, (collider, expected) in enumerate(zip(colliders, shapes(bundle, body["name"]))):
        kind, volume = measured(collider)
        wanted = trimesh.load_mesh(expected.path).volume if expected.kind == "mesh" else expected.volume()
        # URDF has no capsules.
        if kind != expected.kind and kind != "capsule" or differs(volume, wanted, 1e-4 if kind != "capsule" else 0.05, 1e-12):
            verdict.complaints.append(f"{body['name']}: collider {k} is a {kind} of {volume} m^3, not {expected.kind} of {wanted}")
        place = UsdGeom.Xformable(collider).GetLocalTransformation().ExtractTranslation()
        if expected.kind != "mesh" and differs(list(place), expected.position, 0.0, 1e-9):
            verdict.complaints.append(f"{body['name']}: collider {k} is at {place}, not at {expected.position}")
    seen = [as_trimesh(mesh) for mesh in meshes if not mesh.GetPrim().HasAPI(UsdPhysics.CollisionAPI)]
    low = np.min([mesh.bounds[0] for mesh in seen], axis=0)
    high = np.max([mesh.bounds[1] for mesh in seen], axis=0)
    if differs(high - low, body["size_m"], 1e-5, 1e-6):
        verdict.complaints.append(f"{body['name']}: what is seen measures {high - low}, not {body['size_m']}")


def measured(collider):
    """(kind, volume) of a collider."""
    if collider.IsA(UsdGeom.Mesh):
        return "mesh", as_trimesh(UsdGeom.Mesh(collider)).volume
    if collider.IsA(UsdGeom.Cube):
        scale = UsdGeom.Xformable(collider).GetLocalTransformation().GetDeterminant()
        return "box", UsdGeom.Cube(collider).GetSizeAttr().Get() ** 3 * scale
    radius = collider.GetAttribute("radius").Get()
    ball = 4 / 3 * math.pi * radius**3
    if collider.IsA(UsdGeom.Sphere):
        return "sphere", ball
    side = math.pi * radius**2 * collider.GetAttribute("height").Get()
    return ("cylinder", side) if collider.IsA(UsdGeom.Cylinder) else ("capsule", side + ball)


def as_trimesh(mesh):
    faces = np.asarray(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    return trimesh.Trimesh(np.asarray(mesh.GetPointsAttr().Get(), dtype=float), faces, process=False)


def check_material(verdict, body, collider):
    material, _ = UsdShade.MaterialBindingAPI(collider).ComputeBoundMaterial("physics")
    contact = UsdPhysics.MaterialAPI(material.GetPrim()) if material else None
    wanted = [body["friction"]["static"], body["friction"]["dynamic"], body["restitution"]]
    found = contact and [
        contact.GetStaticFrictionAttr().Get(),
        contact.GetDynamicFrictionAttr().Get(),
        contact.GetRestitutionAttr().Get(),
    ]
    if not found or differs(found, wanted):
        verdict.complaints.append(f"{collider.GetPath()}: friction and restitution are {found}, not {wanted}")
