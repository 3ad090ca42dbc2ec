//! Bodies that carry another one beside its supporter.
//!
//! The support tree gives each body one supporter. In a pyramid it stands on two: on its supporter and on a neighbor of
//! it whose top is level with the supporter's. Such neighbors are recognized by their poses: they carry too, so the
//! body may touch them, is dropped on them, and its center of mass may be above the gap between them. World frame,
//! meters.

use glam::{DVec2, DVec3};

use super::Scene;
use super::tree::TABLE;
use geometry::Pose;
use geometry::polygon::{convex_hull_2d, depth_in_convex_m};

/// Tops that differ by less are level, meters: objects of one kind differ by less after settling.
const LEVEL_M: f64 = 0.004;
/// A neighbor reaches under the body by at least this along both axes, meters.
const MIN_OVERLAP_M: f64 = 0.002;

/// The neighbors of the supporter of a body that carry it too; none of a body on the table or in a container.
pub(super) fn carriers_beside(scene: &Scene, body: usize, poses: &[Pose]) -> Vec<usize> {
    let parent = scene.tree.parent(body);
    if parent == TABLE || scene.tree.is_contained(body) {
        return Vec::new();
    }
    let bounds = |k: usize| scene.shapes[k].bounds(&poses[k]);
    let (own, top_m) = (bounds(body), bounds(parent).1.z);
    let is_level = |&other: &usize| {
        if other == TABLE || other == body || other == parent || scene.tree.is_contained(other) {
            return false;
        }
        let is_related = scene.tree.is_below(other, parent)
            || scene.tree.is_below(parent, other)
            || scene.tree.is_below(other, body);
        !is_related && reaches_under(bounds(other), own, top_m)
    };
    (0..poses.len()).filter(is_level).collect()
}

/// Depth below which the center of mass is too close to its supporter's outline, meters.
pub(super) const MIN_DEPTH_OVER_PARENT_M: f64 = 0.002;

/// Depth of the projected center of mass inside the supporter's outline, meters; where that is little, inside the hull
/// of the outlines of all that carry the body.
pub(super) fn depth_over_parent_m(scene: &Scene, body: usize, parent: usize, poses: &[Pose]) -> f64 {
    let center = poses[body].transform_point(scene.problem.bodies[body].mass.center_of_mass_m).truncate();
    let outline = scene.footprint(parent, poses);
    let depth_m = depth_in_convex_m(&outline, center);
    if depth_m >= MIN_DEPTH_OVER_PARENT_M {
        return depth_m;
    }
    let beside = carriers_beside(scene, body, poses);
    if beside.is_empty() {
        return depth_m;
    }
    let points: Vec<DVec2> = outline
        .into_iter()
        .chain(beside.into_iter().flat_map(|other| scene.footprint(other, poses)))
        .collect();
    depth_m.max(depth_in_convex_m(&convex_hull_2d(&points), center))
}

/// Whether `lower` carries `upper` beside its supporter.
pub(super) fn carries_beside(scene: &Scene, lower: usize, upper: usize, poses: &[Pose]) -> bool {
    carriers_beside(scene, upper, poses).contains(&lower)
}

/// Whether a box ends at the height of a top and lies below another box in part.
fn reaches_under(other: (DVec3, DVec3), own: (DVec3, DVec3), top_m: f64) -> bool {
    let overlap = other.1.min(own.1) - other.0.max(own.0);
    (other.1.z - top_m).abs() <= LEVEL_M && overlap.x >= MIN_OVERLAP_M && overlap.y >= MIN_OVERLAP_M
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_reach_under_others_at_the_height_of_a_top() {
        let block = |x: f64, z: f64| (DVec3::new(x, 0.0, z), DVec3::new(x + 0.1, 0.1, z + 0.1));
        let upper = block(0.052, 0.1);
        for (lower, expected) in [
            (block(0.104, 0.0), true),
            (block(0.104, 0.003), true),
            (block(0.104, -0.02), false),
            (block(0.151, 0.0), false),
            (block(0.3, 0.0), false),
        ] {
            assert_eq!(reaches_under(lower, upper, 0.1), expected, "{lower:?}");
        }
    }
}
