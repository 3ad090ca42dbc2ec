"""usd-core opens robot.usda: an articulation whose joints fit the poses of the links, with the stated masses."""

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics, UsdValidation

from poses import Largest

# The attributes of joints have single precision.
SINGLE = 1e-6


def judge(folder, robot):
    path = str(folder / "robot.usda")
    stage = Usd.Stage.Open(path)
    root = stage.GetDefaultPrim()
    complaints, largest = [], Largest()
    if not root.HasAPI(UsdPhysics.ArticulationRootAPI):
        complaints.append("the default prim is no articulation")
    cache = UsdGeom.XformCache()
    joints = [prim for prim in stage.Traverse() if prim.IsA(UsdPhysics.Joint)]
    for prim in joints:
        joint = UsdPhysics.Joint(prim)
        frames = [frame(stage, cache, joint, which) for which in (0, 1)]
        if all(pose is not None for pose in frames):
            largest.add(frames[0], frames[1], prim.GetName())
    if len(joints) != len(robot["links"]):
        complaints.append(f"{len(joints)} joints for {len(robot['links'])} links")
    for link, mass_kg in zip(robot["links"], robot["masses_kg"]):
        prim = root.GetChild(link)
        if not prim or not prim.HasAPI(UsdPhysics.RigidBodyAPI):
            complaints.append(f"{link} is no rigid body")
        elif mass_kg is not None and abs(UsdPhysics.MassAPI(prim).GetMassAttr().Get() - mass_kg) > SINGLE:
            complaints.append(f"{link} has another mass")
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    for error in UsdValidation.ValidationContext(validators).Validate(stage):
        complaints.append(f"{error.GetName()}: {error.GetMessage()}")
    return {"joints": len(joints), **largest.facts()}, complaints + largest.complaints("joint frames differ", SINGLE)


def frame(stage, cache, joint, which):
    """The frame of a joint at one of its bodies, in the world; `None` without a body."""
    relation = joint.GetBody0Rel() if which == 0 else joint.GetBody1Rel()
    targets = relation.GetTargets()
    if not targets:
        return None
    position = joint.GetLocalPos0Attr().Get() if which == 0 else joint.GetLocalPos1Attr().Get()
    turn = joint.GetLocalRot0Attr().Get() if which == 0 else joint.GetLocalRot1Attr().Get()
    # Matrices of USD act on rows.
    body = np.array(cache.GetLocalToWorldTransform(stage.GetPrimAtPath(targets[0]))).T
    local = np.eye(4)
    local[:3, :3] = quaternion_matrix(turn.GetReal(), *turn.GetImaginary())
    local[:3, 3] = position
    return body @ local


def quaternion_matrix(w, x, y, z):
    w, x, y, z = np.array([w, x, y, z], dtype=float) / np.linalg.norm([w, x, y, z])
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
