//! Grasps of one object with the gripper of a robot, as bundles state them. They were tried in simulation.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use geometry::Pose;
use geometry::json_numbers::{Fraction, Positive};

/// The grasps of one object with one gripper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(description = "The grasps of one object with one gripper: those that held it in simulation.")]
pub struct GraspFile {
    pub robot: String,
    /// The frame that poses place in the object's frame: z away from the arm, fingers close along y.
    pub gripper_frame: String,
    pub gripper_joint: String,
    /// The best first.
    #[schemars(length(max = 10))]
    pub grasps: Vec<GraspRecord>,
}

/// One grasp; lengths in meters, quaternions as x, y, z, w.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GraspRecord {
    /// The tool when the fingers have closed.
    pub object_from_tool: Pose,
    /// Distance of the pads from each other when they hold the object.
    #[schemars(range(min = 0.0))]
    pub opening_m: f64,
    /// Distance of the pads from each other when the hand approaches.
    #[schemars(range(min = 0.0))]
    pub pregrasp_opening_m: f64,
    /// Of each pad, newtons.
    #[schemars(with = "Positive")]
    pub force_n: f64,
    /// 0..=1; above 0.5 only if the grasp was stable.
    #[schemars(with = "Fraction")]
    pub confidence: f64,
    #[schemars(with = "String", extend("const" = "stable"))]
    pub verdict: GraspVerdict,
    /// Distance that the gripped point moved in the hand while it was shaken; 0 if it was not tried.
    #[schemars(range(min = 0.0))]
    pub slip_m: f64,
    /// Angle by which the object turned in the hand since it was gripped, radians; 0 if it was not tried.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub turn_rad: f64,
}

/// Result of the trial of a grasp in simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum GraspVerdict {
    /// The object stayed and slipped less than allowed.
    Stable,
    /// The object stayed, but slipped or turned.
    Slipped,
    /// The fingers did not hold the object when they had closed, or lost it later.
    Dropped,
    /// Enough better candidates were stable.
    Untested,
}
