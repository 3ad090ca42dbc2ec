//! Damped least squares: from a start to a pose, for any arm.
//!
//! A step solves `(J Jᵀ + λ² I) y = e` and moves by `Jᵀ y`; damping keeps steps short near singularities. What
//! six joints leave free moves toward a rest configuration. Positions are clamped to the limits after each step, and a
//! step that does not bring the tool nearer raises the damping (Nakamura and Hanafusa 1986; Levenberg and Marquardt).

use nalgebra::{DVector, Isometry3, Matrix6, Vector6};
use thiserror::Error;

use crate::kinematics::{jacobian, tool_pose};
use crate::model::Robot;

/// Settings of the solver: its tolerances and its limit of steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DampedLeastSquares {
    pub max_steps: usize,
    /// The first damping factor, in meters and radians as the Jacobian mixes them.
    pub damping: f64,
    /// Maximum distance of the tool from its target, meters and radians.
    pub position_tolerance_m: f64,
    pub rotation_tolerance_rad: f64,
    /// The share of the way to the rest configuration that the null space moves in one step.
    pub rest_gain: f64,
}

/// The tool did not reach its target from this start.
#[derive(Clone, Debug, Error, PartialEq)]
#[error(
    "the tool stays {position_m:.6} m and {rotation_rad:.6} rad from its target; start elsewhere or take another pose"
)]
pub struct NotReached {
    pub position_m: f64,
    pub rotation_rad: f64,
    /// The nearest configuration found.
    pub positions: Vec<f64>,
}

impl DampedLeastSquares {
    /// Tight tolerances and enough steps for a start that is not far away.
    pub const PRECISE: Self = Self {
        max_steps: 200,
        damping: 1e-2,
        position_tolerance_m: 1e-9,
        rotation_tolerance_rad: 1e-9,
        rest_gain: 0.0,
    };

    /// Computes a configuration within limits that puts the tool at `base_from_tool`, starting at `start`.
    ///
    /// `rest` is where an arm with more than six joints tends to; it has no effect where `rest_gain` is 0.
    ///
    /// # Errors
    /// Where the tool does not come within the tolerances: the target is out of reach, or a limit is in the way.
    pub fn solve(
        &self,
        robot: &Robot,
        base_from_tool: &Isometry3<f64>,
        start: &[f64],
        rest: &[f64],
    ) -> Result<Vec<f64>, NotReached> {
        let mut positions = DVector::from_column_slice(start);
        let rest = DVector::from_column_slice(rest);
        let mut error = tool_error(robot, positions.as_slice(), base_from_tool);
        let mut damping = self.damping;
        for _ in 0..self.max_steps {
            if self.accepts(&error) {
                return Ok(positions.as_slice().to_vec());
            }
            let next = self.step(robot, &positions, &error, &rest, damping);
            let next_error = tool_error(robot, next.as_slice(), base_from_tool);
            if next_error.norm() < error.norm() {
                (positions, error) = (next, next_error);
                damping = (damping / 4.0).max(1e-9);
            } else {
                damping *= 4.0;
                if damping > 1e6 {
                    break;
                }
            }
        }
        if self.accepts(&error) {
            return Ok(positions.as_slice().to_vec());
        }
        let (position_m, rotation_rad) = norms(&error);
        Err(NotReached { position_m, rotation_rad, positions: positions.as_slice().to_vec() })
    }

    fn accepts(&self, error: &Vector6<f64>) -> bool {
        let (position_m, rotation_rad) = norms(error);
        position_m <= self.position_tolerance_m && rotation_rad <= self.rotation_tolerance_rad
    }

    fn step(
        &self,
        robot: &Robot,
        positions: &DVector<f64>,
        error: &Vector6<f64>,
        rest: &DVector<f64>,
        damping: f64,
    ) -> DVector<f64> {
        let jacobian = jacobian(robot, positions.as_slice());
        let damped = &jacobian * jacobian.transpose() + Matrix6::identity() * (damping * damping);
        // A damped matrix is positive definite; without a factorization there is no step, and the damping rises.
        let Some(factors) = damped.cholesky() else { return positions.clone() };
        let tendency = (rest - positions) * self.rest_gain;
        let wanted = error - &jacobian * &tendency;
        let mut next = positions + tendency + jacobian.transpose() * factors.solve(&wanted);
        for (position, limits) in next.iter_mut().zip(robot.limits()) {
            *position = position.clamp(limits.min_position, limits.max_position);
        }
        next
    }
}

/// The way from the tool to its target in the frame of the base: a translation in meters and a turn in radians.
fn tool_error(robot: &Robot, positions: &[f64], target: &Isometry3<f64>) -> Vector6<f64> {
    let tool = tool_pose(robot, positions);
    let linear = target.translation.vector - tool.translation.vector;
    let angular = (target.rotation * tool.rotation.inverse()).scaled_axis();
    Vector6::from_iterator(linear.iter().chain(angular.iter()).copied())
}

fn norms(error: &Vector6<f64>) -> (f64, f64) {
    (error.fixed_rows::<3>(0).norm(), error.fixed_rows::<3>(3).norm())
}
