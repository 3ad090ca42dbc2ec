//! Record of an execution, frame by frame.

use geometry::Pose;
use scene::name::Names;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Numbers in the order of the joints.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "the schema of fields")]
struct Numbers(#[schemars(inner(range(min = -100_000.0, max = 100_000.0)))] Vec<f64>);

/// The record of an execution at even times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(
    rename = "Trajectory",
    description = "The motion in equal steps of time. Angles in radians, lengths in meters."
)]
pub struct Recording {
    #[schemars(range(min = 1.0, max = 2000.0))]
    pub rate_hz: f64,
    /// The joints of the arm, in the order of the frames' numbers.
    pub joints: Vec<String>,
    /// The joint whose servo moves all fingers.
    pub gripper_joint: String,
    /// The objects, in the order of the frames' poses.
    #[schemars(with = "Names")]
    pub objects: Vec<String>,
    pub frames: Vec<Frame>,
}

/// One time of a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(description = "The commands and the state at a time.")]
pub struct Frame {
    #[schemars(range(min = 0.0, max = 36_000.0))]
    pub time_s: f64,
    pub phase: Phase,
    /// Servo targets from this time on: a position servo with the stiffness and damping of the model that follows these
    /// targets repeats the motion. They lead the motion, because damping and held weights hold it back.
    #[schemars(with = "Numbers")]
    pub joint_targets: Vec<f64>,
    /// Planned positions of the joints at `k / rate_hz`, for frame `k`: within the limits of position, velocity,
    /// acceleration and jerk, as differences of these numbers are, too.
    #[schemars(with = "Numbers")]
    pub joint_references: Vec<f64>,
    #[schemars(with = "Numbers")]
    pub joint_positions: Vec<f64>,
    #[schemars(with = "Numbers")]
    pub joint_velocities: Vec<f64>,
    /// Target and measured distance of the pads from each other at this time, meters. While they hold an object, the
    /// target is lower by the offset that the gripper's servo needs for the force of the grasp: below 0 where the
    /// object is thin.
    #[schemars(range(min = -1.0, max = 1.0))]
    pub opening_target_m: f64,
    /// Target distance as fast as the limits of the fingers allow, and never below 0.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub opening_reference_m: f64,
    #[schemars(range(min = -1.0, max = 1.0))]
    pub opening_m: f64,
    /// Target position of the gripper's joint: the one that belongs to `opening_target_m`.
    #[schemars(range(min = -1000.0, max = 1000.0))]
    pub gripper_target: f64,
    /// `world_from_object`.
    pub object_poses: Vec<Pose>,
}

/// Activity of the robot at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "MotionPhase")]
pub enum Phase {
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
