//! Timing of a path within the limits of velocity, acceleration and jerk.
//!
//! A path becomes a smooth [`curve`], the curve gets the fastest [`time_law`] within the limits of velocity and
//! acceleration, and a moving average over a short window bounds the jerk. The average of positions over a window of
//! `T` seconds keeps every bound on the velocity and acceleration, and its jerk is at most `2 a / T` where the
//! acceleration is at most `a`: with `T = 2 a / j` the limit `j` holds. The motion becomes longer by `T`, and leaves
//! the curve by at most `a T² / 24`. Filters like this are described by Biagiotti and Melchiorri, "FIR filters for
//! online trajectory planning with time- and frequency-domain specifications" (2012).

pub mod curve;
pub mod free;
pub mod time_law;
#[cfg(test)]
mod tests;

pub use curve::{Corners, Curve, CurveError};
pub use free::time_free_path;
pub use time_law::TimeLaw;

use crate::model::limits::JointLimits;

/// Peaks are sought at this many points of each interval of the time law.
const POINTS_PER_PIECE: usize = 8;
/// Between these points peaks are higher by less than this share.
const PEAK_SLACK: f64 = 1e-3;

/// A motion from rest to rest along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    curve: Curve,
    law: TimeLaw,
    window_s: f64,
    /// The integral of the position over time, from 0 to each time at which the law changes.
    integrals: Vec<(f64, Vec<f64>)>,
}

/// The motion at one time, for each joint.
#[derive(Clone, Debug, PartialEq)]
pub struct TrajectoryPoint {
    pub time_s: f64,
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
    pub acceleration: Vec<f64>,
}

/// Settings of a trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrajectoryOptions {
    /// Distance between control points, in the Euclidean metric of joint space; corners are off by up to a third of it.
    pub spacing: f64,
    pub corners: Corners,
    /// The share of the joints' limits that is used, above 0 and up to 1.
    pub velocity_share: f64,
    pub acceleration_share: f64,
}

impl Default for TrajectoryOptions {
    fn default() -> Self {
        Self { spacing: 0.1, corners: Corners::Rounded, velocity_share: 1.0, acceleration_share: 0.5 }
    }
}

/// Reason why a path has no trajectory.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrajectoryError {
    #[error(transparent)]
    Curve(#[from] CurveError),
    #[error("the path has {path} joints and there are limits for {limits}")]
    LimitCount { path: usize, limits: usize },
    #[error("joint {joint} has a limit of velocity, acceleration or jerk that is not greater than 0")]
    Limits { joint: usize },
    #[error(
        "the shares of velocity and acceleration are {velocity} and {acceleration}; they must be in 0..=1, not 0"
    )]
    Shares { velocity: f64, acceleration: f64 },
    #[error("the path touches something even where the motion is on it")]
    NotFree,
}

impl Trajectory {
    /// The fastest motion along a path within the limits; it begins and ends at rest.
    ///
    /// # Errors
    /// If the path is malformed, or limits or settings are not greater than 0.
    pub fn along(
        path: &[Vec<f64>],
        limits: &[JointLimits],
        settings: &TrajectoryOptions,
    ) -> Result<Self, TrajectoryError> {
        let in_range = |share: f64| share > 0.0 && share <= 1.0;
        let (velocity, acceleration) = (settings.velocity_share, settings.acceleration_share);
        if !in_range(velocity) || !in_range(acceleration) {
            return Err(TrajectoryError::Shares { velocity, acceleration });
        }
        let curve = Curve::along(path, settings.spacing, settings.corners)?;
        if curve.dof() != limits.len() {
            return Err(TrajectoryError::LimitCount { path: curve.dof(), limits: limits.len() });
        }
        let sound = |l: &JointLimits| {
            [l.max_velocity, l.max_acceleration, l.max_jerk]
                .iter()
                .all(|&limit| limit > 0.0 && limit.is_finite())
        };
        if let Some(joint) = limits.iter().position(|limit| !sound(limit)) {
            return Err(TrajectoryError::Limits { joint });
        }
        let used: Vec<JointLimits> = limits
            .iter()
            .map(|limit| JointLimits {
                max_velocity: velocity * limit.max_velocity,
                max_acceleration: acceleration * limit.max_acceleration,
                ..*limit
            })
            .collect();
        let fastest = TimeLaw::fastest(&curve, &used);
        let excess = peak_share(&curve, &fastest, &used) * (1.0 + PEAK_SLACK);
        let law = if excess > 1.0 { fastest.slower(excess) } else { fastest };
        let window_s = used.iter().map(|l| 2.0 * l.max_acceleration / l.max_jerk).fold(0.0, f64::max);
        Ok(Self::filtered(curve, law, window_s))
    }

    fn filtered(curve: Curve, law: TimeLaw, window_s: f64) -> Self {
        let times_s: Vec<f64> = law.times_s().collect();
        let mut sum = vec![0.0; curve.dof()];
        let mut integrals = vec![(0.0, sum.clone())];
        for ends in times_s.windows(2) {
            add_integral(&curve, &law, ends[0], ends[1], &mut sum);
            integrals.push((ends[1], sum.clone()));
        }
        Self { curve, law, window_s, integrals }
    }

    pub fn duration_s(&self) -> f64 {
        self.law.duration_s() + self.window_s
    }

    /// The curve that the motion follows.
    pub fn curve(&self) -> &Curve {
        &self.curve
    }

    /// The motion at a time; it rests before the begin and after the end.
    pub fn at(&self, time_s: f64) -> TrajectoryPoint {
        let before_s = time_s - self.window_s;
        let rate = |later: &[f64], earlier: &[f64]| -> Vec<f64> {
            later.iter().zip(earlier).map(|(a, b)| (a - b) / self.window_s).collect()
        };
        let (later, earlier) =
            (unfiltered(&self.curve, &self.law, time_s), unfiltered(&self.curve, &self.law, before_s));
        TrajectoryPoint {
            time_s,
            position: rate(&self.integral(time_s), &self.integral(before_s)),
            velocity: rate(&later.position, &earlier.position),
            acceleration: rate(&later.velocity, &earlier.velocity),
        }
    }

    /// The motion at even times, `rate_hz` a second, from 0 to the first one at or after its end.
    pub fn sample(&self, rate_hz: f64) -> Vec<TrajectoryPoint> {
        let last = (self.duration_s() * rate_hz).ceil() as usize;
        (0..=last).map(|k| self.at(k as f64 / rate_hz)).collect()
    }

    /// The integral of the unfiltered position from 0 to a time, which may be outside of the motion.
    fn integral(&self, time_s: f64) -> Vec<f64> {
        let after = self.integrals.partition_point(|(begin_s, _)| *begin_s <= time_s);
        let (begin_s, sum) = &self.integrals[after.saturating_sub(1)];
        let mut sum = sum.clone();
        add_integral(&self.curve, &self.law, *begin_s, time_s, &mut sum);
        sum
    }
}

/// Adds the integral of the position over a time in which the law does not change.
///
/// There the position is a polynomial of degree 6 in time, for which Gauss's rule with four points is exact.
fn add_integral(curve: &Curve, law: &TimeLaw, from_s: f64, to_s: f64, sum: &mut [f64]) {
    const NODES: [(f64, f64); 4] = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    ];
    let half_s = 0.5 * (to_s - from_s);
    for (node, weight) in NODES {
        let (parameter, _, _) = law.at(from_s + half_s * (1.0 + node));
        for (total, position) in sum.iter_mut().zip(curve.at(parameter).position) {
            *total += half_s * weight * position;
        }
    }
}

/// The motion before the jerk is bounded.
fn unfiltered(curve: &Curve, law: &TimeLaw, time_s: f64) -> TrajectoryPoint {
    let (parameter, rate, acceleration) = law.at(time_s);
    let point = curve.at(parameter);
    let joints = || point.first.iter().zip(&point.second);
    TrajectoryPoint {
        time_s,
        velocity: joints().map(|(first, _)| first * rate).collect(),
        acceleration: joints().map(|(first, second)| first * acceleration + second * rate * rate).collect(),
        position: point.position,
    }
}

/// Factor by which a law must be slowed down to obey the limits; below 1 if it could be faster.
fn peak_share(curve: &Curve, law: &TimeLaw, limits: &[JointLimits]) -> f64 {
    let times_s: Vec<f64> = law.times_s().collect();
    let mut peak = 0.0_f64;
    for ends in times_s.windows(2) {
        for k in 0..POINTS_PER_PIECE {
            // The last point is just before the end, since the acceleration jumps there.
            let share = k as f64 / (POINTS_PER_PIECE as f64 - 1.0) * (1.0 - 1e-9);
            let point = unfiltered(curve, law, ends[0] + share * (ends[1] - ends[0]));
            for (joint, limit) in limits.iter().enumerate() {
                let speed = point.velocity[joint].abs() / limit.max_velocity;
                let force = point.acceleration[joint].abs() / limit.max_acceleration;
                peak = peak.max(speed).max(force.sqrt());
            }
        }
    }
    peak
}
