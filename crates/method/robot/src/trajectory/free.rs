//! Trajectories that touch nothing where they round a corner of their path.

use super::{Corners, Trajectory, TrajectoryError, TrajectoryOptions};
use crate::collision::Checker;
use crate::collision::arm::MAX_JOINTS;
use crate::collision::lane_arm::Configuration;
use crate::model::limits::JointLimits;

/// Maximum number of halvings of the spacing of control points, before the motion stops at corners instead.
const HALVINGS: usize = 2;

/// Times a free path, with corners so tight that the motion is free too; if need be, it stops at each of them.
///
/// It is checked at `checks_per_unit` points for each unit of its length, as the edges of the path were.
///
/// # Errors
/// As [`Trajectory::along`], and if the motion touches something even where it is on the path.
pub fn time_free_path(
    path: &[Vec<f64>],
    limits: &[JointLimits],
    settings: &TrajectoryOptions,
    checker: &Checker,
    checks_per_unit: f32,
) -> Result<Trajectory, TrajectoryError> {
    let halved =
        |times: usize| TrajectoryOptions { spacing: settings.spacing / (1 << times) as f64, ..*settings };
    let stopped = TrajectoryOptions { corners: Corners::Stopped, ..*settings };
    for attempt in (0..=HALVINGS).map(halved).chain([stopped]) {
        let trajectory = Trajectory::along(path, limits, &attempt)?;
        if is_free(&trajectory, checker, checks_per_unit) {
            return Ok(trajectory);
        }
    }
    Err(TrajectoryError::NotFree)
}

/// Whether the motion is free. It is checked as a chain of edges, each as short as a few of its control points.
fn is_free(trajectory: &Trajectory, checker: &Checker, checks_per_unit: f32) -> bool {
    let pieces = 4 * trajectory.curve().span_count();
    let point = |k: usize| -> Configuration {
        let position = trajectory.at(trajectory.duration_s() * k as f64 / pieces as f64).position;
        let mut lanes = [0.0; MAX_JOINTS];
        lanes.iter_mut().zip(position).for_each(|(lane, position)| *lane = position as f32);
        lanes
    };
    let mut from = point(0);
    (1..=pieces).all(|k| {
        let to = point(k);
        let free = checker.edge_is_free(&from, &to, checks_per_unit);
        from = to;
        free
    })
}
