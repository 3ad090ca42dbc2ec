//! Configurations that bring the tool somewhere, and straight motions of it.

use nalgebra::Isometry3;
use robot::inverse::{DampedLeastSquares, InverseKinematics};
use robot::kinematics::{jacobian, manipulability, tool_pose};
use robot::model::Robot;
use robot::planning::straight::ToolKinematics;

/// Solves straight motions step by step, from a configuration that is near.
const NEAR: DampedLeastSquares = DampedLeastSquares {
    max_steps: 50,
    damping: 1e-3,
    position_tolerance_m: 1e-6,
    rotation_tolerance_rad: 1e-6,
    rest_gain: 0.0,
};
/// Solves arms without a closed form, from the home configuration.
const FAR: DampedLeastSquares = DampedLeastSquares { max_steps: 300, damping: 1e-2, ..NEAR };
/// Cost of a configuration near a limit, in radians of motion at the limit itself.
const LIMIT_COST: f64 = 0.5;
const LIMIT_REACH_RAD: f64 = 0.15;

/// The kinematics of one arm.
pub(crate) struct Reach<'a> {
    pub robot: &'a Robot,
    closed_form: Option<InverseKinematics>,
}

impl<'a> Reach<'a> {
    pub fn new(robot: &'a Robot) -> Self {
        Self { robot, closed_form: InverseKinematics::new(robot) }
    }

    /// All known configurations that have the tool at a pose.
    pub fn all(&self, base_from_tool: &Isometry3<f64>) -> Vec<Vec<f64>> {
        match &self.closed_form {
            Some(arm) => arm.solve(base_from_tool),
            None => {
                let home = &self.robot.home().positions;
                FAR.solve(self.robot, base_from_tool, home, home).into_iter().collect()
            }
        }
    }

    /// Up to `count` configurations that have the tool at a pose: those to which the arm moves least from `near`, and
    /// that are not near a limit of a joint. They differ from each other.
    pub fn best(&self, base_from_tool: &Isometry3<f64>, near: &[f64], count: usize) -> Vec<Vec<f64>> {
        let mut ranked: Vec<(f64, Vec<f64>)> =
            self.all(base_from_tool).into_iter().map(|q| (self.cost(&q, near), q)).collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut kept: Vec<Vec<f64>> = Vec::new();
        for (_, q) in ranked {
            let differs = |other: &Vec<f64>| q.iter().zip(other).any(|(a, b)| (a - b).abs() > 0.25);
            if kept.len() < count && kept.iter().all(differs) {
                kept.push(q);
            }
        }
        kept
    }

    /// The manipulability of the best configuration at a pose; 0 if none reaches it.
    pub fn manipulability(&self, base_from_tool: &Isometry3<f64>) -> f64 {
        let of = |q: &Vec<f64>| manipulability(&jacobian(self.robot, q));
        self.all(base_from_tool).iter().map(of).fold(0.0, f64::max)
    }

    fn cost(&self, q: &[f64], near: &[f64]) -> f64 {
        let way = q.iter().zip(near).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let limits = self.robot.limits().iter().zip(q).map(|(limit, q)| {
            let margin = (q - limit.min_position).min(limit.max_position - q);
            LIMIT_COST * (1.0 - margin / LIMIT_REACH_RAD).max(0.0)
        });
        way + limits.sum::<f64>()
    }
}

impl ToolKinematics for Reach<'_> {
    fn base_from_tool(&self, positions: &[f64]) -> Isometry3<f64> {
        tool_pose(self.robot, positions)
    }

    fn solve_near(&self, base_from_tool: &Isometry3<f64>, near: &[f64]) -> Option<Vec<f64>> {
        NEAR.solve(self.robot, base_from_tool, near, near).ok()
    }
}
