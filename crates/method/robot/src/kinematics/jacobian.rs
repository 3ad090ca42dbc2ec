//! The geometric Jacobian of the tool, and how far it is from a singularity.

use nalgebra::{Matrix6xX, Vector3};

use crate::kinematics::link_poses;
use crate::model::{MovingKind, Robot};

/// Computes the Jacobian of the tool: column `k` is the velocity of the tool while joint `k` moves at one unit per
/// second. Rows 0 to 2 are the velocity of the tool's origin, rows 3 to 5 the angular velocity, both along the axes of
/// the base.
///
/// # Panics
/// Where `positions` is not as long as the arm has joints.
pub fn jacobian(robot: &Robot, positions: &[f64]) -> Matrix6xX<f64> {
    let poses = link_poses(robot, positions, 0.0);
    let tool = robot.tool();
    let tip = (poses[tool.link] * tool.link_from_tool).translation.vector;
    let mut jacobian = Matrix6xX::zeros(robot.dof());
    for (column, (link, joint)) in robot.arm_links().iter().zip(robot.arm_joints()).enumerate() {
        let axis = poses[*link].rotation * joint.axis.into_inner();
        let (linear, angular) = match joint.kind {
            MovingKind::Revolute => (axis.cross(&(tip - poses[*link].translation.vector)), axis),
            MovingKind::Prismatic => (axis, Vector3::zeros()),
        };
        jacobian.fixed_view_mut::<3, 1>(0, column).copy_from(&linear);
        jacobian.fixed_view_mut::<3, 1>(3, column).copy_from(&angular);
    }
    jacobian
}

/// Computes Yoshikawa's manipulability: the root of the determinant of `J Jᵀ`, which is 0 in a singularity.
///
/// Meters and radians are mixed as they stand: compare values of one robot only.
pub fn manipulability(jacobian: &Matrix6xX<f64>) -> f64 {
    (jacobian * jacobian.transpose()).determinant().max(0.0).sqrt()
}
