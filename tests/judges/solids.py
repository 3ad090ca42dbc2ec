"""A body's visual mesh as a solid: the union of its closed shells, its surface without inner faces."""

from pathlib import Path

import manifold3d
import numpy as np
import trimesh
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from trimesh.ray.ray_pyembree import RayMeshIntersector

FAR_M = 1e9


class Solid:
    """A Manifold in the world and its surface; rays say what lies inside and how far the surface is."""

    def __init__(self, union: manifold3d.Manifold):
        self.union = union
        mesh = union.to_mesh64()
        self.vertices = np.asarray(mesh.vert_properties)[:, :3].astype(float)
        self.faces = np.asarray(mesh.tri_verts).astype(np.int64)
        self.triangles = self.vertices[self.faces]
        self.low, self.high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        self.surface = trimesh.Trimesh(self.vertices, self.faces, process=False)
        cross = np.cross(self.triangles[:, 1] - self.triangles[:, 0], self.triangles[:, 2] - self.triangles[:, 0])
        length = np.linalg.norm(cross, axis=1, keepdims=True)
        self.normals = np.divide(cross, length, out=np.zeros_like(cross), where=length > 0)
        self.rays = RayMeshIntersector(self.surface, scale_to_box=False)

    def first_hits(self, origins, directions):
        """(distance, face) of each ray's first hit; `FAR_M` and -1 where there is none."""
        found = self.rays._scene.run(
            np.ascontiguousarray(origins, dtype=np.float32), np.ascontiguousarray(directions, dtype=np.float32), output=1
        )
        face = found["primID"].astype(np.int64)
        distance = np.where(face >= 0, found["tfar"].astype(float), FAR_M)
        return distance, face

    def winding(self, points):
        """Generalized winding numbers (Jacobson et al. 2013), 1 inside and 0 outside: slow and certain."""
        numbers = np.zeros(len(points))
        for k, point in enumerate(points):
            a, b, c = np.moveaxis(self.triangles - point, 1, 0)
            la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
            volume = np.einsum("ij,ij->i", a, np.cross(b, c))
            dots = [np.einsum("ij,ij->i", p, q) for p, q in ((a, b), (b, c), (c, a))]
            solid_angle = np.arctan2(volume, la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb)
            numbers[k] = solid_angle.sum() / (2 * np.pi)
        return numbers


def load_solid(path: Path, world_from_object):
    """(solid, None), or (None, what is wrong with the mesh).

    The meshes of a body's file are authored z up below the root rotation, which is left out here.
    """
    scene = trimesh.load_scene(path, process=False)
    parts = list(scene.geometry.values())
    offsets = np.cumsum([0] + [len(part.vertices) for part in parts])
    vertices = np.concatenate([part.vertices for part in parts])
    faces = np.concatenate([part.faces + offset for part, offset in zip(parts, offsets)])
    return solid_of(vertices, faces, world_from_object)


def solid_of(vertices, faces, world_from_object=None):
    """The same for a mesh given as arrays; equal positions are one vertex."""
    welded = weld(vertices, faces)
    if welded is None:
        return None, "an edge has a face on one side only"
    points, corners = welded
    if world_from_object is not None:
        points = points @ world_from_object[:3, :3].T + world_from_object[:3, 3]
    whole = manifold3d.Manifold(manifold3d.Mesh64(points, corners.astype(np.uint64)))
    if whole.status() != manifold3d.Error.NoError:
        return None, whole.status().name
    shells = whole.decompose()
    for shell in shells:
        if shell.volume() <= 0.0:
            return None, f"a shell of {shell.num_tri()} faces is inside out or flat"
    return Solid(manifold3d.Manifold.batch_boolean(shells, manifold3d.OpType.Add)), None


def weld(vertices, faces):
    """(points, faces) with each edge shared by two opposite faces, or None where the mesh is open.

    Where more than two faces meet at an edge (two shells that touch there) they are paired off and the
    corners kept apart, so that what comes out is a manifold with the same surface.
    """
    # Adding zero makes one zero of the two.
    points, which = np.unique(np.asarray(vertices, dtype=np.float32) + np.float32(0), axis=0, return_inverse=True)
    faces = which.reshape(-1)[np.asarray(faces)]
    faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
    count = 3 * len(faces)
    start, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    following = np.roll(np.arange(count).reshape(-1, 3), -1, axis=1).reshape(-1)
    edge = np.minimum(start, end).astype(np.int64) * len(points) + np.maximum(start, end)
    order = np.lexsort((np.arange(count), edge))
    there, back = order[(start < end)[order]], order[(start > end)[order]]
    if len(there) != len(back) or (edge[there] != edge[back]).any():
        return None
    rows, columns = np.concatenate([there, following[there]]), np.concatenate([following[back], back])
    same = coo_matrix((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(count, count))
    corners, corner_of = connected_components(same, directed=False)
    apart = np.empty((corners, 3))
    apart[corner_of] = points[start]
    return apart, corner_of.reshape(-1, 3)
