//! A table of any outline, for tables reconstructed from an image.

use glam::DVec2;

use super::Draft;
use super::shapes::round_leg;
use geometry::Outline;
use geometry::shapes::prism;

/// Overlap between parts.
const JOINT_M: f64 = 0.001;
/// Position of the feet between center and edge, share; the heads of the legs are nearer to the center.
const FEET_OUT: f64 = 0.86;
const HEADS_OUT: f64 = 0.74;

/// Adds a top with this edge on `legs` round, slightly splayed legs, which stand at the farthest corners of the edge.
pub fn outlined_table(draft: &mut Draft, edge: &Outline, legs: usize) {
    draft.add_top(edge.corners());
    let top = draft.underside_m() + JOINT_M;
    let center = center(edge);
    let radius_m = (0.022 * draft.size_m.truncate().min_element()).clamp(0.014, 0.03);
    let plate: Vec<DVec2> = edge.corners().iter().map(|p| center + 0.6 * (*p - center)).collect();
    draft.add_frame(prism(&plate, 0.025).translated(glam::DVec3::Z * (top - 0.025)), glam::DVec3::X);
    for corner in farthest_apart(edge, center, legs) {
        let mut out = 1.0;
        // Concave edges may be closer to the center than the leg is thick.
        while out > 0.1 && edge.depth_inside_m(center + out * FEET_OUT * (corner - center)) < radius_m {
            out *= 0.9;
        }
        let [foot, head] = [FEET_OUT, HEADS_OUT].map(|share| center + share * out * (corner - center));
        let leg = round_leg(foot.extend(0.0), head.extend(top), 0.7 * radius_m, radius_m);
        draft.add_frame(leg, glam::DVec3::Z);
    }
}

/// Centroid of the area.
fn center(edge: &Outline) -> DVec2 {
    let corners = edge.corners();
    let origin = corners[0];
    let (mut area, mut moment) = (0.0, DVec2::ZERO);
    for pair in corners[1..].windows(2) {
        let (a, b) = (pair[0] - origin, pair[1] - origin);
        area += 0.5 * a.perp_dot(b);
        moment += 0.5 * a.perp_dot(b) * (a + b) / 3.0;
    }
    origin + moment / area
}

/// Corners of the edge by farthest-point sampling, starting with the farthest from the center.
fn farthest_apart(edge: &Outline, center: DVec2, count: usize) -> Vec<DVec2> {
    let mut chosen: Vec<DVec2> = Vec::new();
    while chosen.len() < count {
        let distance = |p: &DVec2| {
            let to_chosen = chosen.iter().map(|q| (*p - *q).length()).fold(f64::INFINITY, f64::min);
            if chosen.is_empty() { (*p - center).length() } else { to_chosen }
        };
        let next = edge.corners().iter().copied().max_by(|a, b| distance(a).total_cmp(&distance(b)));
        chosen.extend(next);
    }
    chosen
}
