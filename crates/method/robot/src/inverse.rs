//! Configurations that put the tool at a pose.
//!
//! `InverseKinematics::new` examines the joint axes of an arm and takes a closed form where one applies: six joints
//! with an ortho-parallel base and a spherical wrist (`ortho_parallel`), or seven joints arranged as those of Franka
//! arms (`offset_elbow`). A data file need not say so. `damped` solves any arm from a start, one solution at a time.

mod angles;
mod damped;
mod offset_elbow;
mod ortho_parallel;
mod straight_line;

use nalgebra::Isometry3;

use crate::model::Robot;

pub use damped::{DampedLeastSquares, NotReached};
pub use offset_elbow::OffsetElbow;
pub use ortho_parallel::OrthoParallel;
pub use straight_line::{LineAccuracy, LineError, follow_line};

/// The closed form of an arm.
#[derive(Clone, Debug)]
pub enum InverseKinematics {
    OrthoParallel(OrthoParallel),
    OffsetElbow(OffsetElbow),
}

impl InverseKinematics {
    /// Finds the closed form that applies to `robot`; `None` where `DampedLeastSquares` must do.
    pub fn new(robot: &Robot) -> Option<Self> {
        let ortho_parallel = || OrthoParallel::recognize(robot).map(Self::OrthoParallel);
        ortho_parallel().or_else(|| OffsetElbow::recognize(robot).map(Self::OffsetElbow))
    }

    /// Computes the configurations within limits that put the tool at `base_from_tool`.
    ///
    /// Six joints have at most eight, and all are returned; where two axes of the wrist align, one of the infinitely
    /// many stands for all. Seven joints have a family for each branch: all are returned for each of the sampled
    /// positions of the last joint. None is returned for a pose out of reach.
    pub fn solve(&self, base_from_tool: &Isometry3<f64>) -> Vec<Vec<f64>> {
        match self {
            Self::OrthoParallel(arm) => arm.solve(base_from_tool).into_iter().map(|q| q.to_vec()).collect(),
            Self::OffsetElbow(arm) => arm.solve(base_from_tool).into_iter().map(|q| q.to_vec()).collect(),
        }
    }

    /// Computes the configuration within limits that puts the tool at `base_from_tool` and whose largest difference to
    /// `positions` is smallest.
    pub fn nearest(&self, base_from_tool: &Isometry3<f64>, positions: &[f64]) -> Option<Vec<f64>> {
        let far = |q: &[f64]| q.iter().zip(positions).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        self.solve(base_from_tool).into_iter().min_by(|a, b| far(a).total_cmp(&far(b)))
    }
}

#[cfg(test)]
mod tests;
