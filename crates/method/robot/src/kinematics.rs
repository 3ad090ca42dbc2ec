//! Poses and velocities of links and tool in a configuration: all in the frame of the base, in `f64`.
//!
//! `positions` has one entry for each joint of the arm.

mod jacobian;

use nalgebra::Isometry3;

use crate::model::Robot;

pub use jacobian::{jacobian, manipulability};

/// Computes `base_from_link` of every link, in the order of `Robot::links`, with the pads `opening_m` apart.
///
/// # Panics
/// Where `positions` is not as long as the arm has joints.
pub fn link_poses(robot: &Robot, positions: &[f64], opening_m: f64) -> Vec<Isometry3<f64>> {
    assert_eq!(positions.len(), robot.dof(), "one position for each joint of {}", robot.name());
    let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(robot.links().len());
    for link in robot.links() {
        let pose = link.joint.as_ref().map_or_else(Isometry3::identity, |joint| {
            let at_zero = poses[joint.parent] * joint.parent_from_joint;
            match joint.moving() {
                None => at_zero,
                Some(moving) => {
                    at_zero * moving.displacement(robot.joint_position(moving, positions, opening_m))
                }
            }
        });
        poses.push(pose);
    }
    poses
}

/// Computes `base_from_tool`.
///
/// # Panics
/// Where `positions` is not as long as the arm has joints.
pub fn tool_pose(robot: &Robot, positions: &[f64]) -> Isometry3<f64> {
    let tool = robot.tool();
    link_poses(robot, positions, 0.0)[tool.link] * tool.link_from_tool
}

#[cfg(test)]
mod tests;
