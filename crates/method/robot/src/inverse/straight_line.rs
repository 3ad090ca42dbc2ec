//! Motion of the tool along a straight line, for lifting and approaching.

use nalgebra::{Isometry3, Translation3};
use thiserror::Error;

use super::damped::{DampedLeastSquares, NotReached};
use crate::kinematics::tool_pose;
use crate::model::Robot;

/// Accuracy with which a line is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineAccuracy {
    /// The longest way of the tool between two configurations.
    pub max_step_m: f64,
    /// The largest turn of the tool between two configurations.
    pub max_step_rad: f64,
    /// The largest change of one joint between two configurations; a larger one is a jump to another branch.
    pub max_joint_step: f64,
    /// Solver that finds each configuration from the one before.
    pub solver: DampedLeastSquares,
}

/// The line cannot be followed to its end.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LineError {
    #[error("the tool cannot follow the line beyond {percent:.0} % of it: {cause}")]
    NotReached { percent: f64, cause: NotReached },
    #[error(
        "a joint would jump by {jump:.3} at {percent:.0} % of the line; choose another start or a shorter line"
    )]
    Jump { percent: f64, jump: f64 },
}

impl LineAccuracy {
    /// Steps of 5 mm, to a micrometer.
    pub const FINE: Self = Self {
        max_step_m: 0.005,
        max_step_rad: 0.05,
        max_joint_step: 0.2,
        solver: DampedLeastSquares {
            max_steps: 50,
            damping: 1e-3,
            position_tolerance_m: 1e-6,
            rotation_tolerance_rad: 1e-6,
            rest_gain: 0.0,
        },
    };
}

/// Computes configurations that move the tool from where `start` has it straight to `base_from_tool`, turning evenly.
///
/// The first one is `start`; in each the tool is on the line within the solver's tolerances.
///
/// # Errors
/// Where a limit or the reach ends the motion, or a joint would jump.
pub fn follow_line(
    robot: &Robot,
    start: &[f64],
    base_from_tool: &Isometry3<f64>,
    accuracy: &LineAccuracy,
) -> Result<Vec<Vec<f64>>, LineError> {
    let from = tool_pose(robot, start);
    let way_m = (base_from_tool.translation.vector - from.translation.vector).norm();
    let turn_rad = from.rotation.angle_to(&base_from_tool.rotation);
    let steps = (way_m / accuracy.max_step_m).max(turn_rad / accuracy.max_step_rad).ceil().max(1.0);
    let turn = (base_from_tool.rotation * from.rotation.inverse()).scaled_axis();
    let mut path = vec![start.to_vec()];
    let mut positions = start.to_vec();
    for k in 1..=steps as usize {
        let share = k as f64 / steps;
        let translation = from.translation.vector.lerp(&base_from_tool.translation.vector, share);
        let rotation = nalgebra::UnitQuaternion::from_scaled_axis(turn * share) * from.rotation;
        let target = Isometry3::from_parts(Translation3::from(translation), rotation);
        let percent = 100.0 * share;
        let next = accuracy
            .solver
            .solve(robot, &target, &positions, start)
            .map_err(|cause| LineError::NotReached { percent, cause })?;
        let jump = next.iter().zip(&positions).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if jump > accuracy.max_joint_step {
            return Err(LineError::Jump { percent, jump });
        }
        positions.clone_from(&next);
        path.push(next);
    }
    Ok(path)
}
