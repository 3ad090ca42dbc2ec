//! The frames of a motion without the idle ones at its ends.

use std::ops::Range;

use manipulation::execution::Frame;

/// References that differ by less are the same, radians and meters.
const STILL_RAD: f64 = 1e-3;
const STILL_M: f64 = 1e-4;
/// Time that a motion may rest at its end, seconds.
const REST_S: f64 = 0.2;

/// From the first frame whose references are about to move to shortly after the last that moved.
pub(crate) fn motion_window(frames: &[Frame], rate_hz: f64) -> Range<usize> {
    let moves = |pair: &[Frame]| {
        let arm = pair[0].joint_references.iter().zip(&pair[1].joint_references);
        let arm_moves = arm.into_iter().any(|(now, next)| (next - now).abs() > STILL_RAD);
        arm_moves || (pair[1].opening_reference_m - pair[0].opening_reference_m).abs() > STILL_M
    };
    let moving = || frames.windows(2).map(moves);
    let Some(first) = moving().position(|moves| moves) else { return 0..0 };
    let last = moving().rposition(|moves| moves).unwrap_or(first);
    let rest = (REST_S * rate_hz).floor() as usize;
    first..(last + 2 + rest).min(frames.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use manipulation::execution::Phase;

    fn frames(targets: &[f64]) -> Vec<Frame> {
        let frame = |(index, target): (usize, &f64)| Frame {
            time_s: index as f64 * 0.1,
            phase: Phase::Transit,
            joint_targets: vec![*target],
            joint_references: vec![*target],
            joint_positions: vec![*target],
            joint_velocities: vec![0.0],
            opening_target_m: 0.08,
            opening_reference_m: 0.08,
            opening_m: 0.08,
            gripper_target: 0.04,
            object_poses: Vec::new(),
        };
        targets.iter().enumerate().map(frame).collect()
    }

    #[test]
    fn idle_frames_at_the_ends_are_left_out_and_pauses_between_stay() {
        let still_at_both_ends = frames(&[0.0, 0.0, 0.0, 0.1, 0.1, 0.1, 0.1, 0.2, 0.2, 0.2, 0.2, 0.2]);
        // From the frame before the first change to two tenths of a second after the last.
        assert_eq!(motion_window(&still_at_both_ends, 10.0), 2..10);
        assert_eq!(motion_window(&frames(&[0.0, 0.1, 0.2]), 10.0), 0..3);
        assert_eq!(motion_window(&frames(&[0.0, 0.0, 0.0]), 10.0), 0..0);
        assert_eq!(motion_window(&frames(&[]), 10.0), 0..0);
    }
}
