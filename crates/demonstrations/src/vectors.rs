//! States and actions of a robot with a gripper, as a policy gets and gives them.
//!
//! The state is what is measured at a frame: joint positions and velocities, the pose of the tool in the frame of the
//! base, and the opening of the gripper. The action is what the servos are asked for one frame later: a controller that
//! moves its targets straight from the last action to this one within the frame repeats the motion. Position targets of
//! joints lead the motion by what damping and held weights hold back, and the opening that is asked for is less than
//! that of an object by what the force of the grip needs, perhaps less than 0.

use episodes::EpisodeError;
use episodes::unit_of_measure::Unit;
use episodes::vector_layout::{VectorElement, VectorLayout};
use manipulation::execution::Frame;
use manipulation::frames::to_pose;
use robot::kinematics::tool_pose;
use robot::model::Robot;

/// How far targets may be beyond the limits of a joint, radians.
const LEAD_RAD: f32 = 0.5;

/// The numbers of a state.
///
/// # Errors
///
/// [`EpisodeError::Description`] for a robot whose joints have names that a format could not carry.
pub fn state_layout(robot: &Robot) -> Result<VectorLayout, EpisodeError> {
    let velocity = |name: String| VectorElement::new("arm_velocity", &name, Unit::RadiansPerSecond);
    let arm = joints(robot).into_iter().map(|joint| VectorElement::new("arm", &joint, Unit::Radians));
    let elements = arm
        .chain(joints(robot).into_iter().map(velocity))
        .chain(VectorElement::end_effector_pose())
        .chain([VectorElement::gripper_opening(), VectorElement::gripper_fraction()]);
    VectorLayout::new("state", elements.collect())
}

/// The numbers of an action.
///
/// # Errors
///
/// As [`state_layout`].
pub fn action_layout(robot: &Robot) -> Result<VectorLayout, EpisodeError> {
    let arm = joints(robot).into_iter().zip(robot.limits()).map(|(joint, limits)| {
        let (low, high) = (limits.min_position as f32 - LEAD_RAD, limits.max_position as f32 + LEAD_RAD);
        VectorElement::new("arm", &joint, Unit::Radians).within(low, high)
    });
    let gripper = robot.gripper();
    let widest_m = gripper.max_opening_m;
    // Targets that press thin objects are below 0.
    let lead_m = gripper.opening_per_position * robot.gripper_lead(gripper.max_force_n);
    let (low_m, high_m) = (-widest_m.max(lead_m) as f32, widest_m as f32);
    let reach_m = reach_m(robot) as f32;
    let pose = VectorElement::end_effector_pose().map(|element| match element.unit {
        Unit::Meters => element.within(-reach_m, reach_m),
        _ => element,
    });
    let elements = arm
        .chain(pose)
        .chain([VectorElement::gripper_opening().within(low_m, high_m), VectorElement::gripper_fraction()]);
    VectorLayout::new("action", elements.collect())
}

/// The state at a frame.
pub(crate) fn state(robot: &Robot, frame: &Frame) -> Vec<f32> {
    let arm = frame.joint_positions.iter().chain(&frame.joint_velocities).map(|value| *value as f32);
    arm.chain(tool(robot, &frame.joint_positions)).chain(opening(robot, frame.opening_m)).collect()
}

/// What is asked for at a frame.
pub(crate) fn action(robot: &Robot, frame: &Frame) -> Vec<f32> {
    let arm = frame.joint_targets.iter().map(|value| *value as f32);
    arm.chain(tool(robot, &frame.joint_targets)).chain(opening(robot, frame.opening_target_m)).collect()
}

fn joints(robot: &Robot) -> Vec<String> {
    let joint = |link: &usize| robot.links()[*link].joint.as_ref().map(|joint| joint.name.clone());
    robot.arm_links().iter().filter_map(joint).collect()
}

/// Position and quaternion of the tool, w first and not negative.
fn tool(robot: &Robot, positions: &[f64]) -> [f32; 7] {
    let pose = to_pose(&tool_pose(robot, positions));
    let (p, q) = (pose.translation_m, pose.rotation);
    let q = if q.w < 0.0 { -q } else { q };
    [p.x, p.y, p.z, q.w, q.x, q.y, q.z].map(|value| (value as f32).clamp(-1e3, 1e3))
}

fn opening(robot: &Robot, opening_m: f64) -> [f32; 2] {
    let share = opening_m / robot.gripper().max_opening_m;
    [opening_m as f32, share.clamp(0.0, 1.0) as f32]
}

/// No point of the arm can be farther from the base, meters.
fn reach_m(robot: &Robot) -> f64 {
    let joints = robot.links().iter().filter_map(|link| link.joint.as_ref());
    let lengths = joints.map(|joint| joint.parent_from_joint.translation.vector.norm());
    lengths.sum::<f64>() + robot.tool().link_from_tool.translation.vector.norm()
}
