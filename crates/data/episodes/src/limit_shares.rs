//! Shares of a robot's limits that a motion uses.
//!
//! A motion is a list of rows at an even rate. Velocity, acceleration and jerk are the first, second and third
//! differences of its numbers, over as many powers of the time between rows: means over that time of what the motion
//! does, so that no share of a motion within the limits is above 1.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::vector_layout::VectorElement;

/// The largest shares of the limits of one number. A share above 1 is beyond the limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(
    description = "The largest shares of the limits of one joint of the arm, or of the gripper's opening."
)]
pub struct LimitShares {
    /// The name of the number with its unit.
    pub name: String,
    /// Distance from the center of the range, over half of the range; 1 is at the end.
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    pub position: f64,
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    pub velocity: f64,
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    pub acceleration: f64,
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    pub jerk: f64,
}

/// The shares of each number that has limits. `rows` has one row of the layout after the
/// other, `rate_hz` in a second.
pub fn limit_shares(elements: &[VectorElement], rows: &[f32], rate_hz: f64) -> Vec<LimitShares> {
    let numbers = elements.iter().enumerate();
    let share = |(index, element): (usize, &VectorElement)| {
        let limits = element.limits?;
        let [min, max] = limits.position.map(f64::from);
        let column = rows.iter().skip(index).step_by(elements.len());
        let mut values: Vec<f64> = column.copied().map(f64::from).collect();
        let position = values.iter().map(|value| (value - 0.5 * (min + max)).abs() / (0.5 * (max - min)));
        let position = position.fold(0.0, f64::max);
        let [velocity, acceleration, jerk] =
            [limits.velocity, limits.acceleration, limits.jerk].map(|limit| {
                values = values.windows(2).map(|pair| (pair[1] - pair[0]) * rate_hz).collect();
                values.iter().map(|rate| rate.abs() / f64::from(limit)).fold(0.0, f64::max)
            });
        Some(LimitShares { name: element.full_name(), position, velocity, acceleration, jerk })
    };
    numbers.filter_map(share).collect()
}

/// Takes the larger of each two shares; both lists are of the same layout.
pub(crate) fn enlarge(all: &mut Vec<LimitShares>, more: Vec<LimitShares>) {
    if all.is_empty() {
        *all = more;
        return;
    }
    for (share, more) in all.iter_mut().zip(more) {
        share.position = share.position.max(more.position);
        share.velocity = share.velocity.max(more.velocity);
        share.acceleration = share.acceleration.max(more.acceleration);
        share.jerk = share.jerk.max(more.jerk);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit_of_measure::Unit;
    use crate::vector_layout::MotionLimits;

    #[test]
    fn shares_are_differences_over_limits() {
        let limits = MotionLimits { position: [-1.0, 3.0], velocity: 2.0, acceleration: 10.0, jerk: 100.0 };
        let joint = VectorElement::new("arm", "joint", Unit::Radians);
        let without = VectorElement::new("arm", "free", Unit::Radians);
        let elements = [without, joint.with_limits(limits)];
        // At 4 Hz: differences 0.5, 0.25, 0.25; -0.25, 0; 0.25.
        let rows = [9.0, 0.0, -9.0, 0.5, 9.0, 0.75, -9.0, 1.0];
        let expected = LimitShares {
            name: "joint_rad".to_owned(),
            position: 0.5,
            velocity: 4.0 * 0.5 / 2.0,
            acceleration: 16.0 * 0.25 / 10.0,
            jerk: 64.0 * 0.25 / 100.0,
        };
        assert_eq!(limit_shares(&elements, &rows, 4.0), std::slice::from_ref(&expected));
        let mut all = Vec::new();
        enlarge(&mut all, vec![LimitShares { position: 0.75, jerk: 0.0, ..expected.clone() }]);
        enlarge(&mut all, vec![expected.clone()]);
        assert_eq!(all, [LimitShares { position: 0.75, ..expected }]);
        let still = limit_shares(&elements, &rows[..2], 4.0);
        assert_eq!((still[0].velocity, still[0].jerk), (0.0, 0.0), "one row does not move");
    }
}
