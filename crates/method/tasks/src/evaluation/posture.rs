//! Upright, lying, upside down.

use std::f64::consts::{FRAC_PI_2, PI};

use scene::text_account::PredicateKind;

use super::{Bound, Measured, Reason, Unit};
use crate::posed_object::PosedObject;

/// Tolerance of postures, radians (15 degrees).
pub const TILT_RAD: f64 = PI / 12.0;

/// Angle between the upright axis and where the posture has it.
pub(super) fn posture(kind: PredicateKind, object: &PosedObject) -> Measured {
    let tilt_rad = object.tilt_rad();
    let off_rad = match kind {
        PredicateKind::LyingOnSide => (tilt_rad - FRAC_PI_2).abs(),
        PredicateKind::UpsideDown => PI - tilt_rad,
        _ => tilt_rad,
    };
    Measured::new(off_rad, TILT_RAD, Bound::AtMost, Unit::Radians, Reason::WrongPosture)
}
