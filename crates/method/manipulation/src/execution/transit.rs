//! Free motions between configurations: planned, and timed.

use rand::Rng;
use robot::collision::Checker;
use robot::model::limits::JointLimits;
use robot::planning::{PlanFailure, PlanOptions, Problem, SampleOrder, plan};
use robot::trajectory::{Trajectory, TrajectoryError, TrajectoryOptions, time_free_path};

use super::settings::ExecutionSettings;

/// A trajectory is checked at so many points for each unit of its length in joint space.
const CHECKS_PER_UNIT: f32 = 32.0;

/// A path that touches nothing, and the distance from obstacles that it was planned with.
#[derive(Clone, Debug, PartialEq)]
pub struct FreePath {
    pub path: Vec<Vec<f64>>,
    pub padding_m: f64,
}

/// Plans a path at the full distance from obstacles, and where there is none so, at no distance: where the hand is
/// between objects the full distance cannot be kept at the ends.
pub(crate) fn plan_free(
    problem: &Problem,
    settings: &ExecutionSettings,
    rng: &mut impl Rng,
) -> Result<FreePath, PlanFailure> {
    let options = |padding_m: f64| PlanOptions {
        padding_m,
        max_samples: settings.max_samples,
        sample_order: SampleOrder::Shifted,
        ..PlanOptions::default()
    };
    match plan(problem, &options(settings.padding_m), rng) {
        Ok(found) => Ok(FreePath { path: found.path, padding_m: settings.padding_m }),
        Err(_) => Ok(FreePath { path: plan(problem, &options(0.0), rng)?.path, padding_m: 0.0 }),
    }
}

/// The motion along a free path, free itself.
pub(crate) fn time_free(
    problem: &Problem,
    found: &FreePath,
    limits: &[JointLimits],
    shares: [f64; 2],
) -> Result<Trajectory, TrajectoryError> {
    let checker = Checker::new(problem.arm, problem.obstacles, 0.5 * found.padding_m);
    time_free_path(&found.path, limits, &timing(shares), &checker, CHECKS_PER_UNIT)
}

/// Settings of a time law that uses shares of the joints' limits of velocity and acceleration.
pub(crate) fn timing([velocity_share, acceleration_share]: [f64; 2]) -> TrajectoryOptions {
    TrajectoryOptions { velocity_share, acceleration_share, ..TrajectoryOptions::default() }
}
