//! The frames of a motion without the idle ones at its ends.

use std::ops::Range;

use manipulation::execution::Frame;

/// Targets that differ by less are the same, radians and meters.
const STILL_RAD: f64 = 1e-3;
const STILL_M: f64 = 1e-4;
/// So long a motion may rest at its end, seconds.
const REST_S: f64 = 0.2;

/// From the first frame whose targets are about to move to shortly after the last that moved.
pub(crate) fn motion_window(frames: &[Frame], rate_hz: f64) -> Range<usize> {
    let moves = |pair: &[Frame]| {
        let arm = pair[0].joint_targets.iter().zip(&pair[1].joint_targets);
        let arm_moves = arm.into_iter().any(|(now, next)| (next - now).abs() > STILL_RAD);
        arm_moves || (pair[1].opening_target_m - pair[0].opening_target_m).abs() > STILL_M
    };
    let moving = || frames.windows(2).map(moves);
    let Some(first) = moving().position(|moves| moves) else { return 0..0 };
    let last = moving().rposition(|moves| moves).unwrap_or(first);
    let rest = (REST_S * rate_hz).floor() as usize;
    first..(last + 2 + rest).min(frames.len())
}
