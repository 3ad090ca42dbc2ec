"""Col_O on the visual meshes, measured with Manifold, Embree and FCL.

A pair collides when a sample of the surface of its overlap (spacing at most 1 mm) lies deeper than
min(1 mm, a quarter of the local wall) in either solid, or when one contains the other. The surface of
an overlap is what each surface has inside the other solid, so both surfaces are sampled where their
boxes meet, and no intersection is ever built. FCL's triangle test only chooses the pairs worth sampling.
"""

from pathlib import Path

import fcl
import numpy as np
import trimesh

from solids import FAR_M, Solid, load_solid
from verdict import Verdict, bodies, read_scene

DEPTH_M = 0.001
# Longest edge of a sampled triangle: none of its points is farther than 2/3 of it from the sample inside.
EDGE_M = 0.0014
# Below this nothing counts: it is a quarter of a wall thinner than any body has.
SHALLOW_M = 0.0001
MAX_SAMPLES = 3_000_000


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
    models = {name: fcl_object(solid) for name, solid in solids.items()}
    near, colliding = 0, []
    for i, a in enumerate(names):
        for b in names[i + 1 :]:
            low, high = shared_box(solids[a], solids[b])
            if (low > high).any():
                continue
            near += 1
            depth = collision_depth(solids[a], solids[b], models[a], models[b])
            if depth is not None:
                colliding.append((a, b, depth))
    pairs = len(names) * (len(names) - 1) // 2
    verdict.facts = {
        "pairs": pairs,
        "near": near,
        "colliding": len(colliding),
        "col_o": len(colliding) / pairs if pairs else 0.0,
    }
    verdict.complaints += [f"{a} and {b} collide, {1e3 * depth:.2f} mm deep" for a, b, depth in colliding]
    return verdict


def collision_depth(a: Solid, b: Solid, model_a=None, model_b=None):
    """Largest depth found of a colliding pair in meters, or None if the pair merely touches or is apart."""
    low, high = shared_box(a, b)
    if (low > high).any():
        return None
    if one_box_in_other(a, b):
        overlap = (a.union ^ b.union).volume()
        if overlap > 0.99 * min(a.union.volume(), b.union.volume()):
            return float((high - low).min())
    # Where the boxes merely graze, nothing in between is deeper than the box they share is thin.
    if (opposite(a, b) & (high - low <= SHALLOW_M)).any():
        return None
    if not surfaces_meet(model_a or fcl_object(a), model_b or fcl_object(b)):
        return None
    thinnest = (high - low).argmin()
    depths = [counted_depth(samples(x, low, high), y, thinnest) for x, y in ((a, b), (b, a))]
    return max(depths) if max(depths) > 0.0 else None


def shared_box(a, b):
    return np.maximum(a.low, b.low), np.minimum(a.high, b.high)


def opposite(a, b):
    """Axes along which one box begins and ends before the other, so that a way out is at most their overlap."""
    return ((a.low <= b.low) & (a.high <= b.high)) | ((b.low <= a.low) & (b.high <= a.high))


def one_box_in_other(a, b):
    def inside(a, b):
        return (a.low >= b.low - 1e-6).all() and (a.high <= b.high + 1e-6).all()

    return inside(a, b) or inside(b, a)


def fcl_object(solid):
    model = fcl.BVHModel()
    model.beginModel(len(solid.vertices), len(solid.faces))
    model.addSubModel(solid.vertices, solid.faces)
    model.endModel()
    return fcl.CollisionObject(model)


def surfaces_meet(a, b) -> bool:
    return fcl.collide(a, b, fcl.CollisionRequest(), fcl.CollisionResult()) > 0


def samples(solid, low, high):
    """Points of the surface inside a box, at most a millimeter apart.

    Triangles are halved across their longest edge until they are small; the halves that miss the box
    are dropped on the way, so slivers and large faces cost no more than the area in the box.
    """
    # Three arrays of corners: NumPy is slow along short axes.
    corners = [np.ascontiguousarray(solid.triangles[:, k]) for k in range(3)]
    done = []
    while len(corners[0]):
        a, b, c = corners
        lowest, highest = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
        meets = within(lowest, -np.inf, high) & within(highest, low, np.inf)
        a, b, c = a[meets], b[meets], c[meets]
        sides = [np.einsum("ij,ij->i", q - p, q - p) for p, q in ((a, b), (b, c), (c, a))]
        longest = np.maximum(np.maximum(sides[0], sides[1]), sides[2])
        settled = longest <= EDGE_M**2
        done.append((a[settled] + b[settled] + c[settled]) / 3)
        halves = []
        for side, (p, q, apex) in zip(sides, ((a, b, c), (b, c, a), (c, a, b))):
            # Each triangle across one edge only, the first of its longest.
            split = ~settled & (side == longest)
            settled = settled | split
            midpoint = 0.5 * (p[split] + q[split])
            halves += [(p[split], midpoint, apex[split]), (midpoint, q[split], apex[split])]
        corners = [np.concatenate([half[k] for half in halves]) for k in range(3)]
        if len(corners[0]) > MAX_SAMPLES:
            raise RuntimeError(f"{len(corners[0])} samples of one surface: the box two bodies share is too large")
    points = np.concatenate(done)
    return points[within(points, low, high)]


def within(points, low, high):
    x, y, z = points.T
    low, high = np.broadcast_to(low, 3), np.broadcast_to(high, 3)
    return (x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1]) & (z >= low[2]) & (z <= high[2])


def counted_depth(points, solid, thinnest) -> float:
    """The largest depth among points that lie deeper than min(1 mm, a quarter of the local wall); else 0.

    `thinnest` is the axis along which the box of the points is thinnest: the way out is short there.
    """
    points = suspects(points, solid, thinnest)
    for chunk in np.array_split(points, len(points) // 256 + 1):
        if not len(chunk):
            break
        closest, depth, face = trimesh.proximity.closest_point(solid.surface, chunk)
        counted = depth > allowed_depth(solid, closest, face, 0.0)
        for k in np.argsort(-np.where(counted, depth, 0.0))[: min(8, counted.sum())]:
            # Rays may slip through an edge; the winding number does not.
            if solid.winding(chunk[k : k + 1])[0] > 0.5:
                return float(depth[k])
    return 0.0


def suspects(points, solid, thinnest):
    """Points inside whose depth may count, the deepest first.

    Rays go out along the six directions of the axes, the thinnest first: a first hit is no nearer than the
    surface, so what is hit soon lies shallow, and most points are dismissed by two or three rays.
    """
    axes = [thinnest] + [k for k in range(3) if k != thinnest]
    votes = np.zeros(len(points), dtype=int)
    bound, nearest = np.full(len(points), FAR_M), np.full(len(points), -1)
    for k, axis in enumerate(axes):
        for sign in (1.0, -1.0):
            leaving, distance, face = leaves(points, sign * np.eye(3)[axis], solid)
            votes += leaving
            closer = distance < bound
            bound[closer], nearest[closer] = distance[closer], face[closer]
        # A point inside leaves the solid in every direction; rays that slip through an edge are rare.
        kept = (bound > SHALLOW_M) & (nearest >= 0) & (votes >= k + 1)
        kept[kept] = bound[kept] > allowed_depth(solid, points[kept], nearest[kept], bound[kept])
        points, votes, bound, nearest = points[kept], votes[kept], bound[kept], nearest[kept]
    return points[np.argsort(-bound)]


def leaves(points, direction, solid):
    """Whether a ray's first hit is the back of the surface, with its distance and face."""
    distance, face = solid.first_hits(points, np.broadcast_to(direction, points.shape))
    return (face >= 0) & (solid.normals[face] @ direction > 0), distance, face


def allowed_depth(solid, near, face, distance):
    """min(1 mm, a quarter of the wall behind each face), measured by a ray inward from `near` it.

    `near` lies `distance` inside the face, or on it.
    """
    inward = -solid.normals[face]
    wall, _ = solid.first_hits(near + 1e-6 * inward, inward)
    return np.minimum(DEPTH_M, 0.25 * (wall + distance))
