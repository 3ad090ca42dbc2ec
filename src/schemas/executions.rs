//! A task done by a simulated robot: documents of the crate `manipulation`.

use schemars::JsonSchema;

use super::tasks::Task;
use super::texts::GoalPredicate;
use super::values::{MAX_INTEGER, Names};

/// A task, what became of it, and the motion.
#[derive(JsonSchema)]
pub struct ExecutedTask {
    pub task: Task,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub seed: u64,
    pub execution: Execution,
    pub trajectory: Trajectory,
}

/// Result of a task.
#[derive(JsonSchema)]
pub struct Execution {
    pub robot: String,
    /// The variant of the robot's model.
    pub variant: Option<String>,
    pub world_from_base: Pose,
    pub succeeded: bool,
    /// Reason of the failure.
    pub failure: Option<ExecutionFailure>,
    /// Details of the failure, in words.
    pub detail: Option<String>,
    /// The verdicts about the goal's predicates at the end, with what was measured.
    pub predicates: Vec<PredicateOutcome>,
    /// Objects beside the goal that were moved too far.
    pub disturbed: Vec<Disturbance>,
    /// Objects that were picked up.
    pub picks: Vec<Pick>,
    #[schemars(range(min = 0.0, max = 36000.0))]
    pub duration_s: f64,
    pub limit_shares: SharesOfLimits,
}

/// Reason why a task failed.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum ExecutionFailure {
    Unreachable,
    NoGrasp,
    NoPath,
    Slipped,
    Dropped,
    GoalNotMet,
    DisturbedOthers,
}

/// Shares of the robot's limits that the motion uses, by differences of its numbers at the rate of the trajectory. A
/// share above 1 is beyond a limit.
#[derive(JsonSchema)]
pub struct SharesOfLimits {
    /// Of `joint_references` and `opening_reference_m`, which are within the limits.
    pub motion: Vec<LimitShares>,
    /// Of `joint_targets` and `opening_target_m`, which lead the motion.
    pub servo_command: Vec<LimitShares>,
}

/// The largest shares of the limits of one joint of the arm, or of the gripper's opening.
#[derive(JsonSchema)]
pub struct LimitShares {
    /// With its unit: `panda_joint1_rad`, `gripper_opening_m`.
    pub name: String,
    /// Distance from the center of the range, over half of the range.
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    pub position: f64,
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    pub velocity: f64,
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    pub acceleration: f64,
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    pub jerk: f64,
}

/// Whether a predicate holds, and the value that decides.
#[derive(JsonSchema)]
pub struct PredicateOutcome {
    pub predicate: GoalPredicate,
    pub holds: bool,
    /// Meters or radians.
    #[schemars(range(min = -1_000_000.0, max = 1_000_000.0))]
    pub measured: f64,
    #[schemars(range(min = -1_000_000.0, max = 1_000_000.0))]
    pub limit: f64,
    /// On which side of the limit the value must be: `at_least` or `at_most`.
    pub bound: String,
    /// `meters` or `radians`.
    pub unit: String,
    /// Meaning of the measured value, or the reason why the predicate does not hold.
    pub reason: String,
}

/// An object that the goal does not move, and how far it was moved.
#[derive(JsonSchema)]
pub struct Disturbance {
    pub object: String,
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub displacement_m: f64,
    #[schemars(range(min = 0.0, max = 3.2))]
    pub rotation_rad: f64,
}

/// An object that was picked up, its grasp, and how far it moved in the hand.
#[derive(JsonSchema)]
pub struct Pick {
    pub object: String,
    pub grasp: ExecutedGrasp,
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub slip_m: f64,
}

/// A grasp of a parallel gripper; the tool closes along its y axis and comes along its z axis.
#[derive(JsonSchema)]
pub struct ExecutedGrasp {
    pub object_from_tool: Pose,
    #[schemars(range(min = 0.0, max = 1.0))]
    pub opening_m: f64,
    #[schemars(range(min = 0.0, max = 1.0))]
    pub pregrasp_opening_m: f64,
    #[schemars(range(min = 0.0, max = 10000.0))]
    pub force_n: f64,
    #[schemars(range(min = 0.0, max = 1.0))]
    pub confidence: f64,
    pub verdict: GraspVerdict,
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub slip_m: f64,
    #[schemars(range(min = 0.0, max = 3.2))]
    pub turn_rad: f64,
}

/// Result of a grasp in simulation, while the hand was raised and shaken.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum GraspVerdict {
    Stable,
    Slipped,
    Dropped,
    Untested,
}

/// The motion in equal steps of time. Angles in radians, lengths in meters.
#[derive(JsonSchema)]
pub struct Trajectory {
    #[schemars(range(min = 1.0, max = 2000.0))]
    pub rate_hz: f64,
    pub joints: Names,
    pub gripper_joint: String,
    pub objects: Names,
    pub frames: Vec<Frame>,
}

/// The commands and the state at a time.
#[derive(JsonSchema)]
pub struct Frame {
    #[schemars(range(min = 0.0, max = 36000.0))]
    pub time_s: f64,
    pub phase: MotionPhase,
    /// Targets of position servos for the motion.
    pub joint_targets: Numbers,
    /// The planned motion, within the limits.
    pub joint_references: Numbers,
    pub joint_positions: Numbers,
    pub joint_velocities: Numbers,
    /// Below 0 where a thin object is pressed; see `gripper_target`.
    #[schemars(range(min = -1.0, max = 1.0))]
    pub opening_target_m: f64,
    /// As `opening_target_m`, but within the limits of the fingers.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub opening_reference_m: f64,
    #[schemars(range(min = -1.0, max = 1.0))]
    pub opening_m: f64,
    /// Target of the servo of the gripper's joint. It is as far below the joint's position as the servo's stiffness
    /// needs for the force of the grasp, so below 0 where a thin object is pressed.
    #[schemars(range(min = -1000.0, max = 1000.0))]
    pub gripper_target: f64,
    /// In the order of `objects`.
    pub object_poses: Vec<Pose>,
}

/// Phase of the motion.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum MotionPhase {
    Transit,
    Approach,
    Close,
    Lift,
    Carry,
    Lower,
    Open,
    Retreat,
    Rest,
}

/// A position and an orientation; meters, and a unit quaternion with the real part last.
#[derive(JsonSchema)]
pub struct Pose {
    #[schemars(inner(range(min = -1000.0, max = 1000.0)), length(equal = 3))]
    pub translation_m: Vec<f64>,
    #[schemars(inner(range(min = -1.0, max = 1.0)), length(equal = 4))]
    pub rotation_xyzw: Vec<f64>,
}

/// Numbers in the order of the joints.
#[derive(JsonSchema)]
pub struct Numbers(#[schemars(inner(range(min = -100000.0, max = 100000.0)))] pub Vec<f64>);
