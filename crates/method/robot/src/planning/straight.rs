//! Straight motions of the tool: approach, lift and retreat.

use nalgebra::{Isometry3, Translation3, Vector3};

use super::failure::{PlanFailure, StraightMotionObstacle};
use super::planner::{Planner, padded};

/// Kinematics of an arm, as a straight motion needs it.
pub trait ToolKinematics {
    /// The pose of the tool in the frame of the base.
    fn base_from_tool(&self, positions: &[f64]) -> Isometry3<f64>;

    /// A configuration near `near` that has the tool at `base_from_tool`; `None` if there is none.
    fn solve_near(&self, base_from_tool: &Isometry3<f64>, near: &[f64]) -> Option<Vec<f64>>;
}

/// Resolution of a straight motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightOptions {
    /// The tool moves and turns by at most this between two configurations.
    pub max_step_m: f64,
    pub max_step_rad: f64,
    /// No joint moves by more than this between two configurations.
    pub max_joint_step: f64,
}

impl Default for StraightOptions {
    fn default() -> Self {
        Self { max_step_m: 0.005, max_step_rad: 0.05, max_joint_step: 0.2 }
    }
}

/// Moves the tool straight from where `start` has it to `base_from_end`, turning it evenly.
///
/// The path begins with `start`. An approach is planned from the grasp backwards, and reversed: so it ends in the very
/// configuration that was chosen for the grasp.
///
/// # Errors
/// How far the motion gets and what stops it, or what is wrong with the start.
pub fn straight(
    planner: &Planner,
    kinematics: &impl ToolKinematics,
    start: &[f64],
    base_from_end: &Isometry3<f64>,
    settings: &StraightOptions,
) -> Result<Vec<Vec<f64>>, PlanFailure> {
    planner.check_start(start)?;
    let base_from_start = kinematics.base_from_tool(start);
    let length_m = (base_from_end.translation.vector - base_from_start.translation.vector).norm();
    let angle_rad = base_from_start.rotation.angle_to(&base_from_end.rotation);
    let count = (length_m / settings.max_step_m).max(angle_rad / settings.max_step_rad).ceil() as usize;
    let mut path = vec![start.to_vec()];
    for step in 1..=count {
        let share = step as f64 / count as f64;
        let blocked = |obstacle| PlanFailure::StraightMotionBlocked {
            reached: (step - 1) as f64 / count as f64,
            obstacle,
        };
        let wanted = between(&base_from_start, base_from_end, share);
        let before = &path[path.len() - 1];
        let next = kinematics
            .solve_near(&wanted, before)
            .ok_or_else(|| blocked(StraightMotionObstacle::OutOfReach))?;
        if before.iter().zip(&next).any(|(a, b)| (b - a).abs() > settings.max_joint_step) {
            return Err(blocked(StraightMotionObstacle::Jump));
        }
        if planner.outside_limits(&next).is_some() {
            return Err(blocked(StraightMotionObstacle::JointLimit));
        }
        if !planner.checker().edge_is_free(
            &padded(before),
            &padded(&next),
            planner.settings().checks_per_unit,
        ) {
            return Err(blocked(StraightMotionObstacle::Collision));
        }
        path.push(next);
    }
    Ok(path)
}

/// Moves the tool straight by `offset_m`, given in the frame of the base, without turning it: a lift or a retreat.
///
/// # Errors
/// As [`straight`].
pub fn straight_by(
    planner: &Planner,
    kinematics: &impl ToolKinematics,
    start: &[f64],
    offset_m: Vector3<f64>,
    settings: &StraightOptions,
) -> Result<Vec<Vec<f64>>, PlanFailure> {
    let base_from_end = Translation3::from(offset_m) * kinematics.base_from_tool(start);
    straight(planner, kinematics, start, &base_from_end, settings)
}

/// Moves the tool straight to where `grasp` has it, from `distance_m` before it along z of the tool.
///
/// # Errors
/// As [`straight`], for the way back from the grasp.
pub fn approach(
    planner: &Planner,
    kinematics: &impl ToolKinematics,
    grasp: &[f64],
    distance_m: f64,
    settings: &StraightOptions,
) -> Result<Vec<Vec<f64>>, PlanFailure> {
    let back = kinematics.base_from_tool(grasp).rotation * (Vector3::z() * -distance_m);
    let mut path = straight_by(planner, kinematics, grasp, back, settings)?;
    path.reverse();
    Ok(path)
}

/// The pose at a share of the way between two poses.
fn between(from: &Isometry3<f64>, to: &Isometry3<f64>, share: f64) -> Isometry3<f64> {
    let rotation = from.rotation.try_slerp(&to.rotation, share, 1e-9).unwrap_or(to.rotation);
    let translation = from.translation.vector.lerp(&to.translation.vector, share);
    Isometry3::from_parts(Translation3::from(translation), rotation)
}
