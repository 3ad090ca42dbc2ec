//! Grasps of a solid with a parallel gripper.
//!
//! Two flat fingers close along a line on opposite sides of the surface (an antipodal grasp: Nguyen, "Constructing
//! force-closure grasps", 1988). A grasp is valid if both normals lie within the friction cone about that line and the
//! fingers and the palm between them touch nothing but what they grasp: neither while they approach, nor opened, nor
//! closed. The hand comes from above; on sloped walls it tilts so that its fingers lie along the wall; where neither is
//! possible it comes from a side. Vessels wider than the hand are thus taken by their wall near the rim, or by a
//! handle. Of the valid grasps the one nearest to the center of mass is returned, which minimizes torque.
//!
//! Fingers and palm are tested against the collision hulls, because those are what simulators collide; normals are
//! those of the visual mesh. Object frame, meters; the object stands on a plane at its lowest point, which the hand
//! stays above. Reachability by an arm and neighboring objects are ignored. Milliseconds.

mod candidates;
mod hand;

use std::ops::Range;

use glam::DVec3;
use parry3d_f64::query::{Ray, RayCast};

use self::candidates::candidates;
use self::hand::Hand;
use super::ConvexHull;
use super::solid_query::MeshSolid;

/// Dimensions of the hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gripper {
    /// Widest distance between the fingers, meters.
    pub opening_m: f64,
    /// Of one finger along the closing line, meters.
    pub finger_thickness_m: f64,
    /// Of one finger across the closing line, meters.
    pub finger_width_m: f64,
    /// From the tip of a finger to the palm, meters.
    pub finger_length_m: f64,
}

impl Gripper {
    /// A common gripper: 80 mm of opening, fingers of 20 mm x 10 mm and 45 mm long.
    pub const COMMON: Self =
        Self { opening_m: 0.08, finger_thickness_m: 0.01, finger_width_m: 0.02, finger_length_m: 0.045 };
}

/// The centers of the two finger pads when they are closed, object frame, meters. On curved surfaces the center of a
/// pad is up to a few millimeters from the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParallelGrasp {
    pub contacts_m: [DVec3; 2],
}

/// Smallest thickness between the fingers, meters.
const THINNEST_M: f64 = 0.0005;
/// Least free space beside the object for each opened finger, and so much less than the opening is the thickest object,
/// meters.
const CLEARANCE_M: f64 = 0.0015;
/// Distance from the pad's center to the finger's tip, meters.
const PAD_TO_TIP_M: f64 = 0.008;
/// Distance of the pads from the surface at their center that still is a grip there, meters: walls are curved, and
/// hulls stick out of the mesh.
const MAX_PAD_GAP_M: f64 = 0.006;
/// Slopes of closing lines for which the hand tilts, as sines: flatter ones are taken as horizontal, steeper ones not
/// tried.
const SLOPES: Range<f64> = 0.1..0.82;
/// Cost of turning the hand from the vertical by 90 degrees, meters of distance from the center of mass.
const TILT_COST_M: f64 = 0.05;

/// Cost per sum of both pads' gaps, meters per meter: flat pads on flat parts hold better.
const GAP_COST: f64 = 5.0;

/// The grasp nearest to the center of mass, if any candidate is valid. `friction` is the coefficient between finger and
/// solid; `hulls` are the collision geometry of the solid.
pub fn parallel_grasp(
    solid: &MeshSolid,
    hulls: &[ConvexHull],
    center_of_mass_m: DVec3,
    friction: f64,
    gripper: Gripper,
) -> Option<ParallelGrasp> {
    let subject = Subject {
        solid,
        hulls: hulls.iter().map(hand::Part::of).collect(),
        floor_m: solid.bounds().0.z,
        min_cosine: friction.atan().cos(),
        gripper,
    };
    let candidates = candidates(solid, center_of_mass_m);
    [Approach::Above, Approach::Side].into_iter().find_map(|approach| {
        let mut best: Option<(f64, ParallelGrasp)> = None;
        for candidate in &candidates {
            let nearest_m = candidate.point_m.distance(center_of_mass_m) - 0.5 * gripper.opening_m;
            if best.as_ref().is_some_and(|(cost_m, _)| nearest_m > *cost_m) {
                break;
            }
            for hand in hands(candidate, approach) {
                let Some((grasp, gaps_m)) = subject.grasp(candidate, &hand) else { continue };
                let [a, b] = grasp.contacts_m;
                let tilt = 1.0 - hand.up.z;
                let away_m = (0.5 * (a + b)).distance(center_of_mass_m);
                let cost_m = away_m + TILT_COST_M * tilt + GAP_COST * gaps_m;
                if best.as_ref().is_none_or(|(known_m, _)| cost_m < *known_m) {
                    best = Some((cost_m, grasp));
                }
            }
        }
        best.map(|(_, grasp)| grasp)
    })
}

/// A point of the surface and the direction away from the solid there.
struct Candidate {
    point_m: DVec3,
    normal: DVec3,
}

/// Direction of the hand: from above, tilted at most as a wall is, or horizontal.
#[derive(Clone, Copy, PartialEq)]
enum Approach {
    Above,
    Side,
}

/// The hands that close at a candidate.
fn hands(candidate: &Candidate, approach: Approach) -> Vec<Hand> {
    let inward = -candidate.normal;
    let flat = inward.with_z(0.0).try_normalize();
    match approach {
        Approach::Above => {
            let tilted = SLOPES.contains(&inward.z.abs()).then_some(inward);
            flat.into_iter().chain(tilted).filter_map(Hand::upright).collect()
        }
        Approach::Side => {
            let sideways =
                |closing: DVec3| [1.0, -1.0].map(|side| Hand::new(closing, side * closing.cross(DVec3::Z)));
            flat.into_iter().flat_map(sideways).collect()
        }
    }
}

/// The object to be grasped, the plane below it, and the gripper.
struct Subject<'a> {
    solid: &'a MeshSolid,
    hulls: Vec<hand::Part<'a>>,
    /// Height of the plane that the object stands on.
    floor_m: f64,
    min_cosine: f64,
    gripper: Gripper,
}

impl Subject<'_> {
    /// The grasp of that hand at a candidate, and the sum of the gaps between its pads and the surface, meters.
    fn grasp(&self, candidate: &Candidate, hand: &Hand) -> Option<(ParallelGrasp, f64)> {
        if -candidate.normal.dot(hand.closing) < self.min_cosine {
            return None;
        }
        let Gripper { opening_m, finger_thickness_m, finger_width_m, finger_length_m } = self.gripper;
        let point_m = candidate.point_m;
        let pad_m = point_m.dot(hand.up);
        let reach_m = finger_thickness_m + 2.0 * CLEARANCE_M;
        let tip_m = hand.tip_above(point_m, pad_m - PAD_TO_TIP_M, reach_m, finger_width_m, self.floor_m)?;
        if tip_m > pad_m {
            return None;
        }
        let column = hand::Column { point_m, half_width_m: 0.5 * finger_width_m };
        // The fingers come down through all that is above them.
        let spans = hand.spans(&self.hulls, &column, [tip_m, f64::INFINITY]);
        let at_m = point_m.dot(hand.closing);
        let found =
            spans.iter().position(|[from, to]| from - MAX_PAD_GAP_M <= at_m && at_m <= to + MAX_PAD_GAP_M)?;
        let [from_m, to_m] = spans[found];
        let thickness_m = to_m - from_m;
        if thickness_m < THINNEST_M || thickness_m > opening_m - 2.0 * CLEARANCE_M {
            return None;
        }
        let needed_m = finger_thickness_m + CLEARANCE_M;
        let has_room = found.checked_sub(1).is_none_or(|below| from_m - spans[below][1] >= needed_m)
            && spans.get(found + 1).is_none_or(|above| above[0] - to_m >= needed_m);
        if !has_room {
            return None;
        }
        let mid_m = 0.5 * (from_m + to_m);
        let palm_half_m = 0.5 * opening_m + finger_thickness_m;
        let palm_m = tip_m + finger_length_m;
        let lowest_m = point_m.z + (palm_m - pad_m) * hand.up.z - palm_half_m * hand.closing.z.abs();
        if lowest_m < self.floor_m {
            return None;
        }
        let above = hand.spans(&self.hulls, &column, [palm_m, f64::INFINITY]);
        if above.iter().any(|[from, to]| *to > mid_m - palm_half_m && *from < mid_m + palm_half_m) {
            return None;
        }
        self.grips(hand, point_m, [from_m, to_m])
    }

    /// The closed pads, if they press on the surface at their center within the friction cone, and the sum of their
    /// gaps.
    fn grips(&self, hand: &Hand, point_m: DVec3, [from_m, to_m]: [f64; 2]) -> Option<(ParallelGrasp, f64)> {
        let at = |along_m: f64| point_m + (along_m - point_m.dot(hand.closing)) * hand.closing;
        // Simplified hulls may lie inside the mesh as well as around it.
        let gap_m = |pad_m: DVec3, inward: DVec3| {
            hit(self.solid, pad_m - MAX_PAD_GAP_M * inward, inward, 2.0 * MAX_PAD_GAP_M)
                .filter(|(_, normal)| -normal.dot(inward) >= self.min_cosine)
                .map(|(distance_m, _)| (distance_m - MAX_PAD_GAP_M).abs())
        };
        let (a, b) = (at(from_m), at(to_m));
        let gaps_m = gap_m(a, hand.closing)? + gap_m(b, -hand.closing)?;
        Some((ParallelGrasp { contacts_m: [a, b] }, gaps_m))
    }
}

/// Distance to the first surface along a ray, and its normal on the ray's side.
fn hit(solid: &MeshSolid, origin: DVec3, direction: DVec3, max_m: f64) -> Option<(f64, DVec3)> {
    let ray = Ray::new(origin, direction);
    let hits = solid.shells().iter().filter_map(|shell| {
        let hit = shell.surface.cast_local_ray_and_get_normal(&ray, max_m, false)?;
        Some((hit.time_of_impact, hit.normal))
    });
    hits.min_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests;
