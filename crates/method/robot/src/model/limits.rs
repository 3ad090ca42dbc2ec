//! Limits of a joint: its range, speed, acceleration, jerk and effort.

/// The limits of one joint: radians and newton meters for one that turns, meters and newtons for one that slides.
///
/// Position lies in `min_position..=max_position`; the other four bound the absolute value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    pub min_position: f64,
    pub max_position: f64,
    /// Per second.
    pub max_velocity: f64,
    /// Per second squared.
    pub max_acceleration: f64,
    /// Per second cubed.
    pub max_jerk: f64,
    /// The torque, or the force.
    pub max_effort: f64,
}

impl JointLimits {
    /// Whether the joint may stand at `position`.
    pub fn admits(&self, position: f64) -> bool {
        (self.min_position..=self.max_position).contains(&position)
    }
}
