//! States and actions of a robot with a gripper, as a policy gets and gives them.
//!
//! The state is what is measured at a frame: joint positions and velocities, the pose of the tool in the frame of the
//! base, and the opening of the gripper. The action is where the planned motion has joints and gripper one frame later:
//! within the robot's limits of position, velocity, acceleration and jerk, as differences of actions are. The servo
//! command beside it is what the servos are asked for at that time. It leads the motion by what damping and held
//! weights hold back, and the opening that is asked for is less than that of an object by what the force of the grip
//! needs, perhaps less than 0: a controller that moves its targets straight from the last command to this one within
//! the frame repeats the motion.
//!
//! A rotation has two quaternions, q and -q. At the first frame it is the one nearer to the tool's at the robot's home,
//! then the one nearer to that of the frame before; the action's is the one nearer to the state's.

use episodes::EpisodeError;
use episodes::limit_shares::{LimitShares, limit_shares};
use episodes::unit_of_measure::Unit;
use episodes::vector_layout::{MotionLimits, VectorElement, VectorLayout};
use geometry::DQuat;
use manipulation::execution::{Frame, Recording};
use manipulation::frames::to_pose;
use robot::kinematics::tool_pose;
use robot::model::{Joint, JointLimits, Robot};
use schemars::JsonSchema;
use serde::Serialize;

/// Positions that are farther beyond a limit are no errors of rounding, radians and meters.
const ROUNDING: f64 = 1e-6;
/// A component of a unit quaternion that is larger stays so under errors of rounding, and each has one.
const SURE_COMPONENT: f64 = 0.4;

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
    let reach_m = reach_m(robot) as f32;
    let pose = VectorElement::end_effector_pose().map(|element| match element.unit {
        Unit::Meters => element.within(-reach_m, reach_m),
        _ => element,
    });
    let followed = followed(robot).into_iter().map(|element| match element.limits {
        Some(MotionLimits { position: [min, max], .. }) => element.within(min, max),
        None => element,
    });
    let (mut arm, opening): (Vec<_>, Vec<_>) = followed.partition(|element| element.group == "arm");
    arm.extend(pose.into_iter().chain(opening).chain([VectorElement::gripper_fraction()]));
    VectorLayout::new("action", arm)
}

/// The numbers of a servo command.
///
/// # Errors
///
/// As [`state_layout`].
pub fn servo_layout(robot: &Robot) -> Result<VectorLayout, EpisodeError> {
    VectorLayout::new("servo command", followed(robot))
}

/// Joints of the arm and the opening of the gripper, with the limits of the robot.
fn followed(robot: &Robot) -> Vec<VectorElement> {
    let arm = joints(robot).into_iter().zip(robot.limits());
    let arm = arm.map(|(joint, limits)| {
        VectorElement::new("arm", &joint, Unit::Radians).with_limits(motion_limits(limits, 1.0))
    });
    let gripper = robot.gripper();
    let finger = robot.links()[gripper.link].joint.as_ref().and_then(Joint::moving);
    let opening = VectorElement::gripper_opening();
    let opening = match finger {
        Some(finger) => {
            let limits = motion_limits(&finger.limits, gripper.opening_per_position);
            let position = [0.0, gripper.max_opening_m as f32];
            opening.with_limits(MotionLimits { position, ..limits })
        }
        None => opening,
    };
    arm.chain([opening]).collect()
}

/// The limits of a number that is `factor` times the position of a joint.
fn motion_limits(limits: &JointLimits, factor: f64) -> MotionLimits {
    let scaled = |limit: f64| (factor * limit) as f32;
    MotionLimits {
        position: [scaled(limits.min_position), scaled(limits.max_position)],
        velocity: scaled(limits.max_velocity),
        acceleration: scaled(limits.max_acceleration),
        jerk: scaled(limits.max_jerk),
    }
}

/// Shares of the robot's limits that a recorded motion uses.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(
    description = "Shares of the robot's limits that the motion uses, by differences of its numbers at the rate of the trajectory. A share above 1 is beyond a limit."
)]
pub struct SharesOfLimits {
    /// Of the planned motion.
    pub motion: Vec<LimitShares>,
    /// Shares of the servo targets.
    pub servo_command: Vec<LimitShares>,
}

/// The shares of a recording, by differences of its numbers at its rate.
pub fn shares_of_limits(robot: &Robot, recording: &Recording) -> SharesOfLimits {
    let elements = followed(robot);
    let rows = |of: fn(&Frame) -> (&[f64], f64)| -> Vec<LimitShares> {
        let row = |frame| {
            let (joints, opening_m) = of(frame);
            joints.iter().map(|joint| *joint as f32).chain([opening_m as f32])
        };
        let rows: Vec<f32> = recording.frames.iter().flat_map(row).collect();
        limit_shares(&elements, &rows, recording.rate_hz)
    };
    SharesOfLimits {
        motion: rows(|frame| (&frame.joint_references[..], frame.opening_reference_m)),
        servo_command: rows(|frame| (&frame.joint_targets[..], frame.opening_target_m)),
    }
}

/// The numbers of one frame.
pub(crate) struct FrameVectors {
    pub state: Vec<f32>,
    pub action: Vec<f32>,
    pub servo_command: Vec<f32>,
}

/// The numbers of the frames of a recording but for the last, whose action would be that of the next.
pub(crate) fn frame_vectors(robot: &Robot, frames: &[Frame]) -> Vec<FrameVectors> {
    let mut near = home_rotation(robot);
    let vectors = frames.windows(2).map(|pair| {
        let [now, next] = pair else { return None };
        let (at, of_tool) = tool(robot, &now.joint_positions, near);
        near = of_tool;
        let measured = now.joint_positions.iter().chain(&now.joint_velocities).map(|value| *value as f32);
        let state = measured.chain(pose_numbers(at, of_tool)).chain(opening(robot, now.opening_m)).collect();

        let followed = next.joint_references.iter().zip(robot.limits());
        let joints: Vec<f64> = followed.map(|(value, limits)| without_rounding(*value, limits)).collect();
        let (at, of_tool) = tool(robot, &joints, near);
        let asked = joints.iter().map(|value| *value as f32).chain(pose_numbers(at, of_tool));
        let opening_m = next.opening_reference_m.min(robot.gripper().max_opening_m);
        let action = asked.chain(opening(robot, opening_m)).collect();

        let targets = next.joint_targets.iter().chain([&next.opening_target_m]);
        let servo_command = targets.map(|value| *value as f32).collect();
        Some(FrameVectors { state, action, servo_command })
    });
    vectors.flatten().collect()
}

fn joints(robot: &Robot) -> Vec<String> {
    let joint = |link: &usize| robot.links()[*link].joint.as_ref().map(|joint| joint.name.clone());
    robot.arm_links().iter().filter_map(joint).collect()
}

/// A position that only rounding has put beyond a limit, at the limit.
fn without_rounding(position: f64, limits: &JointLimits) -> f64 {
    let within = position.clamp(limits.min_position, limits.max_position);
    if (position - within).abs() < ROUNDING { within } else { position }
}

/// The quaternion of the tool at the robot's home. All episodes begin near it, so that nearness to it is a choice
/// between q and -q without a border among them.
fn home_rotation(robot: &Robot) -> DQuat {
    let home = to_pose(&tool_pose(robot, &robot.home().positions)).rotation;
    let sure =
        [home.w, home.x, home.y, home.z].into_iter().find(|component| component.abs() > SURE_COMPONENT);
    if sure.is_some_and(|component| component < 0.0) { -home } else { home }
}

/// Position of the tool, and of its two quaternions the one that is nearer to `near`.
fn tool(robot: &Robot, positions: &[f64], near: DQuat) -> ([f64; 3], DQuat) {
    let pose = to_pose(&tool_pose(robot, positions));
    let rotation = if pose.rotation.dot(near) < 0.0 { -pose.rotation } else { pose.rotation };
    (pose.translation_m.to_array(), rotation)
}

/// Position, quaternion with w first, and the first two columns of the rotation's matrix.
fn pose_numbers(at: [f64; 3], rotation: DQuat) -> impl Iterator<Item = f32> {
    let DQuat { x, y, z, w } = rotation;
    let [first, second] = [geometry::DVec3::X, geometry::DVec3::Y].map(|axis| (rotation * axis).to_array());
    let at = at.map(|value| value.clamp(-1e3, 1e3));
    let turned = [w, x, y, z].into_iter().chain(first).chain(second).map(|value| value.clamp(-1.0, 1.0));
    at.into_iter().chain(turned).map(|value| value as f32)
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

#[cfg(test)]
mod tests {
    use super::*;
    use manipulation::execution::Phase;

    fn frame(joints: Vec<f64>) -> Frame {
        Frame {
            time_s: 0.0,
            phase: Phase::Transit,
            joint_targets: joints.iter().map(|joint| joint + 0.3).collect(),
            joint_references: joints.clone(),
            joint_velocities: vec![0.0; joints.len()],
            joint_positions: joints,
            opening_target_m: -0.01,
            opening_reference_m: 0.0,
            opening_m: 0.002,
            gripper_target: -0.005,
            object_poses: Vec::new(),
        }
    }

    /// The hand points down and turns about the vertical by two turns of a joint.
    #[test]
    fn quaternions_of_a_downward_hand_do_not_flip() {
        for name in ["panda", "piper"] {
            let robot = Robot::built_in(name, None).expect("built in");
            let last = robot.dof() - 1;
            let limits = &robot.limits()[last];
            let at = |share: f64| {
                let mut joints = robot.home().positions.clone();
                joints[last] = limits.min_position + share * (limits.max_position - limits.min_position);
                frame(joints)
            };
            let frames: Vec<Frame> = (0..=200).map(|k| at(f64::from(k) / 200.0)).collect();
            let vectors = frame_vectors(&robot, &frames);
            let (states, actions) = (2 * robot.dof() + 3, robot.dof() + 3);
            let of_state = |k: usize| &vectors[k].state[states..states + 4];
            let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>();
            for (k, vector) in vectors.iter().enumerate() {
                assert!(dot(of_state(k), &vector.action[actions..actions + 4]) > 0.99, "{name} {k}");
                assert!(k == 0 || dot(of_state(k - 1), of_state(k)) > 0.99, "{name} {k}");
            }
            // The columns have no second form: they are those of the quaternion, at every frame.
            for row in &vectors {
                let [w, x, y, z] = [0, 1, 2, 3].map(|k| f64::from(row.state[states + k]));
                let matrix = geometry::DMat3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize());
                let columns = [matrix.x_axis.to_array(), matrix.y_axis.to_array()].concat();
                let found = &row.state[states + 4..states + 10];
                assert!(columns.iter().zip(found).all(|(a, b)| (a - f64::from(*b)).abs() < 1e-5), "{name}");
            }
        }
    }

    /// Starts of episodes differ by the randomization: none of them may have the other sign.
    #[test]
    fn first_quaternions_of_all_episodes_are_in_one_hemisphere() {
        for name in ["panda", "piper"] {
            let robot = Robot::built_in(name, None).expect("built in");
            let home = home_rotation(&robot);
            for corner in 0..1 << robot.dof() {
                let offset = |k: usize| if corner >> k & 1 == 0 { -0.3 } else { 0.3 };
                let joints = robot.home().positions.iter().enumerate().map(|(k, q)| q + offset(k));
                let (_, rotation) = tool(&robot, &joints.collect::<Vec<_>>(), home);
                assert!(rotation.dot(home) > 0.3, "{name}: {corner:b} is near the border");
            }
        }
    }

    #[test]
    fn actions_end_at_the_limits_and_servo_commands_do_not() {
        let robot = Robot::built_in("panda", None).expect("built in");
        let mut joints = robot.home().positions.clone();
        joints[0] = robot.limits()[0].max_position + 1e-9;
        let frames = [frame(joints.clone()), frame(joints)];
        let [row] = &frame_vectors(&robot, &frames)[..] else { panic!("one row of two frames") };
        let layout = action_layout(&robot).expect("a layout");
        assert_eq!(layout.elements()[0].range, Some([-2.8973, 2.8973]));
        assert_eq!(row.action[0], 2.8973);
        assert!((row.servo_command[0] - 3.1973).abs() < 1e-6);
        let (opening, arm) = (row.action.len() - 2, robot.dof());
        assert_eq!((row.action[opening], row.servo_command[arm]), (0.0, -0.01));
        assert_eq!(layout.full_names()[opening], "gripper_opening_m");
        let names = servo_layout(&robot).expect("a layout").full_names();
        assert_eq!((names.len(), &names[arm][..]), (8, "gripper_opening_m"));
    }
}
