//! Detection of self-intersections.

use glam::DVec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::shape::TriMesh;

use crate::shells::{CONVEX_M, Shell};

/// Whether an edge of a triangle passes through another triangle, beyond touching. Triangles that share an edge are not
/// compared, so a fold of the surface onto itself is not detected.
pub(super) fn crosses_itself(shell: &Shell) -> bool {
    if shell.is_convex() {
        return false;
    }
    let Ok(surface) = TriMesh::new(shell.points.clone(), shell.triangles.clone()) else { return false };
    let bvh = surface.bvh();
    let mut corners = shell.corners();
    let (one, all) = (corners.by_ref(), &shell.triangles);
    one.zip(all).enumerate().any(|(index, (corners, t))| {
        let [a, b, c] = corners;
        let aabb = Aabb::new(a.min(b).min(c), a.max(b).max(c));
        bvh.intersect_aabb(&aabb).any(|other| {
            let u = all[other as usize];
            let shared = t.iter().filter(|v| u.contains(v)).count();
            other as usize != index
                && shared < 2
                && edges_of(shell, *t).any(|(from, to, ends)| {
                    !ends.iter().any(|v| u.contains(v))
                        && passes_through(from, to, u.map(|v| shell.points[v as usize]))
                })
        })
    })
}

fn edges_of(shell: &Shell, t: [u32; 3]) -> impl Iterator<Item = (DVec3, DVec3, [u32; 2])> + '_ {
    (0..3).map(move |k| {
        let ends = [t[k], t[(k + 1) % 3]];
        (shell.points[ends[0] as usize], shell.points[ends[1] as usize], ends)
    })
}

/// Whether the segment runs from one side of the triangle to the other through its inside.
fn passes_through(from: DVec3, to: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let Some(normal) = (b - a).cross(c - a).try_normalize() else { return false };
    let (above, below) = (normal.dot(from - a), normal.dot(to - a));
    if above.min(below) > -CONVEX_M || above.max(below) < CONVEX_M {
        return false;
    }
    let at = from + above / (above - below) * (to - from);
    [(a, b), (b, c), (c, a)]
        .into_iter()
        .all(|(p, q)| normal.cross(q - p).normalize_or_zero().dot(at - p) > CONVEX_M)
}
