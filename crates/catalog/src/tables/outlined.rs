//! A table of any outline, as it was seen in a picture.

use glam::DVec2;

use super::Draft;
use super::shapes::round_leg;
use geometry::Outline;
use geometry::shapes::prism;

/// How far parts reach into each other.
const JOINT_M: f64 = 0.001;
/// Feet stand at this share of the way from the middle to the edge, heads nearer.
const FEET_OUT: f64 = 0.86;
const HEADS_OUT: f64 = 0.74;

/// Adds a top with this edge on `legs` round, slightly splayed legs, which stand where the edge reaches farthest out.
pub fn outlined_table(draft: &mut Draft, edge: &Outline, legs: usize) {
    draft.add_top(edge.corners());
    let top = draft.underside_m() + JOINT_M;
    let middle = middle(edge);
    let radius_m = (0.022 * draft.size_m.truncate().min_element()).clamp(0.014, 0.03);
    let plate: Vec<DVec2> = edge.corners().iter().map(|p| middle + 0.6 * (*p - middle)).collect();
    draft.add_frame(prism(&plate, 0.025).translated(glam::DVec3::Z * (top - 0.025)), glam::DVec3::X);
    for corner in farthest_apart(edge, middle, legs) {
        let mut out = 1.0;
        // Hollow edges may come nearer to the middle than the leg is thick.
        while out > 0.1 && edge.depth_inside_m(middle + out * FEET_OUT * (corner - middle)) < radius_m {
            out *= 0.9;
        }
        let [foot, head] = [FEET_OUT, HEADS_OUT].map(|share| middle + share * out * (corner - middle));
        let leg = round_leg(foot.extend(0.0), head.extend(top), 0.7 * radius_m, radius_m);
        draft.add_frame(leg, glam::DVec3::Z);
    }
}

/// Centroid of the area.
fn middle(edge: &Outline) -> DVec2 {
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

/// Corners of the edge, each the farthest from those before it, the first from the middle.
fn farthest_apart(edge: &Outline, middle: DVec2, count: usize) -> Vec<DVec2> {
    let mut chosen: Vec<DVec2> = Vec::new();
    while chosen.len() < count {
        let distance = |p: &DVec2| {
            let to_chosen = chosen.iter().map(|q| (*p - *q).length()).fold(f64::INFINITY, f64::min);
            if chosen.is_empty() { (*p - middle).length() } else { to_chosen }
        };
        let next = edge.corners().iter().copied().max_by(|a, b| distance(a).total_cmp(&distance(b)));
        chosen.extend(next);
    }
    chosen
}
