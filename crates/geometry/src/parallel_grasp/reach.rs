//! Whether the hand of a gripper reaches a closing line: from above or, across the line, from either side.
//!
//! The fingers stand open at both ends of the line and must be free from their tips to beyond the palm. What lies
//! between and behind them ends before the palm. From the side, the hand must also clear what the object stands on.

use glam::DVec3;

use super::{Gripper, first_hit};
use crate::solid_query::MeshSolid;

/// Half the height of a hand that comes from the side: its line lies at least this far above the bottom, and nothing is
/// beside its palm within it, meters.
const HALF_HAND_M: f64 = 0.03;

/// Points along the palm at which it is tested, as shares of its length.
const PALM_SHARES: [f64; 7] = [0.0, 0.17, 0.33, 0.5, 0.67, 0.83, 1.0];

/// Whether some approach reaches the fingers' `tips`, which are open and close along the horizontal `inward` from the
/// first to the second. Object frame, meters.
pub(super) fn is_reachable(solid: &MeshSolid, tips: [DVec3; 2], inward: DVec3, gripper: Gripper) -> bool {
    let aside = DVec3::Z.cross(inward);
    let stands_high = tips[0].z - solid.bounds().0.z >= HALF_HAND_M;
    let half_width_m = 0.5 * gripper.finger_width_m;
    reaches(solid, tips, inward, (DVec3::Z, half_width_m), gripper)
        || stands_high
            && [aside, -aside]
                .into_iter()
                .any(|back| reaches(solid, tips, inward, (back, HALF_HAND_M), gripper))
}

/// Whether a hand reaches the tips whose palm lies in the direction `back` from them, of unit length, and extends by
/// `half_palm_m` to both sides of the plane of the fingers.
fn reaches(
    solid: &MeshSolid,
    tips: [DVec3; 2],
    inward: DVec3,
    (back, half_palm_m): (DVec3, f64),
    gripper: Gripper,
) -> bool {
    let half = 0.5 * gripper.finger_thickness_m;
    let centers = [tips[0] - half * inward, tips[1] + half * inward];
    let across = back.cross(inward);
    let sides_m = |half_m: f64| [0.0, half_m, -half_m];
    let fingers_free = || {
        centers.iter().all(|center| {
            let sides_m = sides_m(0.5 * gripper.finger_width_m);
            sides_m.iter().all(|side| first_hit(solid, *center + *side * across, back, f64::MAX).is_none())
        })
    };
    let (low, high) = solid.bounds();
    let far_m = (high - low).length() + gripper.finger_length_m;
    let palm_free = || {
        PALM_SHARES.iter().all(|share| {
            sides_m(half_palm_m).iter().all(|side| {
                let origin = centers[0].lerp(centers[1], *share) + *side * across + far_m * back;
                // The distance to the palm's plane; nothing may come before it.
                first_hit(solid, origin, -back, far_m - gripper.finger_length_m).is_none()
            })
        })
    };
    fingers_free() && palm_free()
}
