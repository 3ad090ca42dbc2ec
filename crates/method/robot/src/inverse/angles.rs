//! Angles modulo a full turn, and the interval of a joint.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::model::JointLimits;

/// Maximum excess over a limit that counts as rounding, radians; such positions are moved to the limit.
const ROUNDING_RAD: f64 = 1e-9;

/// Computes the position within limits that equals `angle_rad` modulo full turns; of several, the one nearest to zero.
pub(super) fn within(limits: &JointLimits, angle_rad: f64) -> Option<f64> {
    let fits = |angle: f64| {
        (limits.min_position - ROUNDING_RAD..=limits.max_position + ROUNDING_RAD).contains(&angle)
    };
    let nearest = angle_rad - TAU * (angle_rad / TAU).round();
    [nearest, nearest - TAU, nearest + TAU]
        .into_iter()
        .find(|angle| fits(*angle))
        .map(|angle| angle.clamp(limits.min_position, limits.max_position))
}

/// Computes how far `angle_rad` is from the limits modulo full turns; 0 where `within` finds a position.
pub(super) fn beyond(limits: &JointLimits, angle_rad: f64) -> f64 {
    if within(limits, angle_rad).is_some() {
        return 0.0;
    }
    let from = |limit: f64| {
        let turn = (angle_rad - limit) / TAU;
        TAU * (turn - turn.round()).abs()
    };
    from(limits.min_position).min(from(limits.max_position))
}

/// The positions within limits, or `None` where one joint has none.
pub(super) fn all_within<const N: usize>(
    limits: &[JointLimits; N],
    angles_rad: [f64; N],
) -> Option<[f64; N]> {
    let mut positions = [0.0; N];
    for (position, (limits, angle)) in positions.iter_mut().zip(limits.iter().zip(angles_rad)) {
        *position = within(limits, angle)?;
    }
    Some(positions)
}

pub(super) fn about_x(angle_rad: f64) -> Matrix3<f64> {
    Rotation3::from_axis_angle(&Vector3::x_axis(), angle_rad).into_inner()
}

pub(super) fn about_y(angle_rad: f64) -> Matrix3<f64> {
    Rotation3::from_axis_angle(&Vector3::y_axis(), angle_rad).into_inner()
}

pub(super) fn about_z(angle_rad: f64) -> Matrix3<f64> {
    Rotation3::from_axis_angle(&Vector3::z_axis(), angle_rad).into_inner()
}

/// Computes the two triples with `Rz(a) Ry(b) Rz(c) = rotation`; where `b` is a multiple of half a turn, one triple
/// with `a = 0` stands for the family.
pub(super) fn zyz(rotation: &Matrix3<f64>) -> impl Iterator<Item = [f64; 3]> {
    /// Below this sine, the first and the last axis are one.
    const ALIGNED: f64 = 1e-9;
    let r = |row: usize, column: usize| rotation[(row, column)];
    let sine = r(0, 2).hypot(r(1, 2));
    let aligned = sine < ALIGNED;
    let triple = |sign: f64| {
        let outer = f64::atan2(sign * r(1, 2), sign * r(0, 2));
        [outer, f64::atan2(sign * sine, r(2, 2)), f64::atan2(sign * r(2, 1), -sign * r(2, 0))]
    };
    let in_line = || {
        let flip = r(2, 2).signum();
        [0.0, f64::atan2(0.0, r(2, 2)), f64::atan2(r(1, 0), flip * r(0, 0))]
    };
    let triples = if aligned { [Some(in_line()), None] } else { [Some(triple(1.0)), Some(triple(-1.0))] };
    triples.into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits(min_position: f64, max_position: f64) -> JointLimits {
        let [max_velocity, max_acceleration, max_jerk, max_effort] = [1.0; 4];
        JointLimits { min_position, max_position, max_velocity, max_acceleration, max_jerk, max_effort }
    }

    #[test]
    fn position_is_found_modulo_full_turns_and_rounding() {
        assert_eq!(within(&limits(3.0, 3.5), 3.2 - TAU), Some(3.2 - TAU + TAU));
        assert_eq!(within(&limits(-1.0, 1.0), 1.0 + 1e-10), Some(1.0));
        assert_eq!(within(&limits(-1.0, 1.0), 1.1), None);
    }

    #[test]
    fn distance_from_limits_is_the_shorter_way_around() {
        let limits = limits(-1.0, 2.0);
        assert_eq!(beyond(&limits, 1.5 + TAU), 0.0);
        assert!((beyond(&limits, 2.25) - 0.25).abs() < 1e-12);
        assert!((beyond(&limits, -1.5 - TAU) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn triples_of_turns_compose_to_the_rotation() {
        for [a, b, c] in
            [[0.3, 0.7, -2.0], [-3.0, -1.2, 1.0], [0.4, 0.0, 0.5], [0.4, std::f64::consts::PI, 0.5]]
        {
            let rotation = about_z(a) * about_y(b) * about_z(c);
            let triples: Vec<_> = zyz(&rotation).collect();
            assert_eq!(triples.len(), if b == 0.0 || b > 3.0 { 1 } else { 2 });
            for [a, b, c] in triples {
                assert!((about_z(a) * about_y(b) * about_z(c) - rotation).norm() < 1e-12);
            }
        }
    }
}
