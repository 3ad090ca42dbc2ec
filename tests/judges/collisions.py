"""Col_O on the visual meshes, measured with trimesh, FCL and Manifold.

A pair collides when a sample of the surface of its overlap (spacing at most 1 mm) lies deeper than
min(1 mm, a quarter of the local wall) in either solid, or when one contains the other. FCL's triangle
test and boxes only choose the pairs worth measuring.
"""

from pathlib import Path

import manifold3d
import numpy as np
import trimesh

from verdict import Verdict, bodies, read_scene

DEPTH_M = 0.001
SPACING_M = 0.001
# Thinnest wall the samples are checked against: a quarter of it is the smallest depth that counts.
SHALLOW_M = 0.0001


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("collisions")
    solids = {}
    for body in bodies(read_scene(bundle)):
        solid, reason = load_solid(bundle / body["mesh"], body["world_from_object"])
        if solid is None:
            verdict.complaints.append(f"{body['mesh']} is no union of closed shells: {reason}")
        else:
            solids[body["name"]] = solid
    names = list(solids)
    touching = touching_pairs(solids)
    colliding = []
    for i, a in enumerate(names):
        for b in names[i + 1 :]:
            if (a, b) in touching or (b, a) in touching or one_box_in_other(solids[a], solids[b]):
                depth = collision_depth(solids[a], solids[b])
                if depth is not None:
                    colliding.append((a, b, depth))
    pairs = len(names) * (len(names) - 1) // 2
    verdict.facts = {
        "pairs": pairs,
        "colliding": len(colliding),
        "col_o": len(colliding) / pairs if pairs else 0.0,
    }
    verdict.complaints += [f"{a} and {b} collide, {1e3 * depth:.2f} mm deep" for a, b, depth in colliding]
    return verdict


class Solid:
    """A union of closed shells in the world, its surface as a mesh without inner faces."""

    def __init__(self, union):
        self.union = union
        mesh = union.to_mesh()
        vertices = np.asarray(mesh.vert_properties)[:, :3].astype(float)
        self.mesh = trimesh.Trimesh(vertices, np.asarray(mesh.tri_verts), process=False)


def load_solid(path: Path, world_from_object):
    """The meshes of a body's file are authored z up below the root rotation, which is left out here."""
    scene = trimesh.load_scene(path)
    mesh = trimesh.util.concatenate(
        [trimesh.Trimesh(part.vertices, part.faces, process=False) for part in scene.geometry.values()]
    )
    mesh.merge_vertices(merge_tex=True, merge_norm=True, digits_vertex=9)
    mesh.update_faces(mesh.nondegenerate_faces())
    shells = []
    for shell in mesh.split(only_watertight=False, repair=False):
        shell.apply_transform(world_from_object)
        part = manifold3d.Manifold(
            manifold3d.Mesh(
                vert_properties=np.asarray(shell.vertices, dtype=np.float32),
                tri_verts=np.asarray(shell.faces, dtype=np.uint32),
            )
        )
        if part.status() != manifold3d.Error.NoError:
            return None, f"{part.status().name} in a shell of {len(shell.faces)} faces"
        if part.volume() <= 0.0:
            return None, f"a shell of {len(shell.faces)} faces is inside out or flat"
        shells.append(part)
    return Solid(manifold3d.Manifold.batch_boolean(shells, manifold3d.OpType.Add)), None


def touching_pairs(solids):
    manager = trimesh.collision.CollisionManager()
    for name, solid in solids.items():
        manager.add_object(name, solid.mesh)
    _, pairs = manager.in_collision_internal(return_names=True)
    return pairs


def one_box_in_other(a, b):
    (a_low, a_high), (b_low, b_high) = a.mesh.bounds, b.mesh.bounds
    inside = lambda low, high, l, h: (low >= l - 1e-6).all() and (high <= h + 1e-6).all()
    return inside(a_low, a_high, b_low, b_high) or inside(b_low, b_high, a_low, a_high)


def collision_depth(a, b):
    """Largest depth of a colliding pair in meters, or None if the pair merely touches or is apart."""
    overlap = a.union ^ b.union
    volume = overlap.volume()
    if overlap.is_empty() or volume <= 1e-13:
        return None
    contained = volume > 0.99 * min(a.union.volume(), b.union.volume())
    mesh = overlap.to_mesh()
    vertices = np.asarray(mesh.vert_properties)[:, :3].astype(float)
    faces = np.asarray(mesh.tri_verts)
    # Coarse samples first: a deep collision shows at once, and a shallow one has a small overlap.
    deepest = 0.0
    for spacing in (8 * SPACING_M, SPACING_M):
        points, _ = trimesh.remesh.subdivide_to_size(vertices, faces, max_edge=spacing, max_iter=30)
        for solid in (a, b):
            depth = counted_depth(solid, points)
            deepest = max(deepest, depth)
        if deepest > 0.0:
            return deepest
    return 0.0 if contained else None


def counted_depth(solid, points):
    """The largest depth among points that lie deeper than min(1 mm, a quarter of the local wall)."""
    low, high = points.min(axis=0) - 2 * DEPTH_M, points.max(axis=0) + 2 * DEPTH_M
    corners = solid.mesh.triangles
    near = (corners.max(axis=1) >= low).all(axis=1) & (corners.min(axis=1) <= high).all(axis=1)
    if not near.any():
        return 2 * DEPTH_M
    surface = solid.mesh.submesh([np.flatnonzero(near)], append=True, repair=False)
    closest, distance, face = trimesh.proximity.closest_point(surface, points)
    deep = distance > DEPTH_M
    if deep.any():
        return float(distance[deep].max())
    doubtful = np.flatnonzero(distance > SHALLOW_M)
    if not len(doubtful):
        return 0.0
    inward = -surface.face_normals[face[doubtful]]
    origins = closest[doubtful] + 1e-6 * inward
    hits, rays, _ = solid.mesh.ray.intersects_location(origins, inward, multiple_hits=False)
    wall = np.full(len(doubtful), np.inf)
    wall[rays] = np.linalg.norm(hits - origins[rays], axis=1)
    counted = distance[doubtful] > np.minimum(DEPTH_M, 0.25 * wall)
    return float(distance[doubtful][counted].max()) if counted.any() else 0.0
