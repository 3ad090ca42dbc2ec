//! Changes since the start: lifted, moved, rotated, swapped, parted.

use std::f64::consts::PI;

use geometry::pose::wrap_angle_rad;
use scene::predicates::CONTACT_TOLERANCE_M;

use super::{Bound, Measured, Reason, Situation, Unit};
use crate::posed_object::PosedObject;

/// Rise from which an object is lifted (robosuite), meters.
pub const LIFT_M: f64 = 0.04;
/// Displacement from which an object has moved, meters: the one up to which the paper calls it stable.
pub const MOVE_M: f64 = 0.03;
/// Turn from which an object is rotated, radians: the one up to which the paper calls it stable.
pub const TURN_RAD: f64 = PI / 6.0;
/// Distance from the other object's place up to which objects are swapped (RoboTwin's place tests), meters.
pub const SWAP_M: f64 = 0.05;

impl Situation<'_> {
    /// Lifted are objects that have risen and rest on no other object.
    pub(super) fn lifted(&self, now: &PosedObject, start: &PosedObject) -> Measured {
        let rise_m = now.footprint().bottom_m - start.footprint().bottom_m;
        let measured = Measured::at_least_m(rise_m, LIFT_M, Reason::NotRisen);
        if measured.holds && self.is_on_any(now) {
            return Measured { holds: false, reason: Reason::OnAnotherObject, ..measured };
        }
        measured
    }
}

/// Horizontal displacement of the center.
pub(super) fn moved(now: &PosedObject, start: &PosedObject) -> Measured {
    let displacement_m = now.footprint().center().distance(start.footprint().center());
    Measured::at_least_m(displacement_m, MOVE_M, Reason::NotMoved)
}

/// Turn about the vertical, up to half a turn.
pub(super) fn rotated(now: &PosedObject, start: &PosedObject) -> Measured {
    let change = now.world_from_object.rotation * start.world_from_object.rotation.conjugate();
    let turn_rad = wrap_angle_rad(2.0 * change.z.atan2(change.w)).abs();
    Measured::new(turn_rad, TURN_RAD, Bound::AtLeast, Unit::Radians, Reason::NotTurned)
}

/// Each object is where the other one was: its center within [`SWAP_M`], and as high.
pub(super) fn swapped(now: [&PosedObject; 2], start: [&PosedObject; 2]) -> Measured {
    let (now, start) = (now.map(PosedObject::footprint), start.map(PosedObject::footprint));
    let off_m = |k: usize| now[k].center().distance(start[1 - k].center());
    let rise_m = |k: usize| (now[k].bottom_m - start[1 - k].bottom_m).abs();
    let measured = Measured::at_most_m(off_m(0).max(off_m(1)), SWAP_M, Reason::NotExchanged);
    let as_high = rise_m(0).max(rise_m(1)) <= CONTACT_TOLERANCE_M;
    Measured { holds: measured.holds && as_high, ..measured }
}

/// Growth of the free distance.
pub(super) fn parted(now: [&PosedObject; 2], start: [&PosedObject; 2]) -> Measured {
    let free_m = |pair: [&PosedObject; 2]| pair[0].footprint().distance_m(&pair[1].footprint());
    Measured::at_least_m(free_m(now) - free_m(start), MOVE_M, Reason::NotMoved)
}
