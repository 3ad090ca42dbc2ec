//! Settings of the motion of an execution, and its limits of effort.

use physics::rolling::GRAVITY_M_S2;
use robot::model::{Gripper, Robot};
use serde::{Deserialize, Serialize};
use tasks::RobotLimits;

use crate::grasp::GraspSettings;

/// Section `[execution]`: settings of [`execute`](super::execute).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExecutionSettings {
    /// The hand comes to a grasp and leaves it straight from this far, meters.
    pub approach_m: f64,
    /// Objects are raised by this before they are carried, and lowered by it, meters.
    pub lift_m: f64,
    /// Objects are let go this far above where they will rest, meters.
    pub release_gap_m: f64,
    /// Distance that the arm keeps from obstacles while it carries or moves freely, meters.
    pub padding_m: f64,
    /// Distance that the hand keeps from other objects on its straight motions, meters.
    pub hand_gap_m: f64,
    /// Shares of the joints' limits of velocity and acceleration with a free hand.
    pub free_shares: [f64; 2],
    /// Shares of the limits with an object in the hand.
    pub carrying_shares: [f64; 2],
    /// Shares of the limits on straight motions to and from a grasp.
    pub straight_shares: [f64; 2],
    /// Speed of each finger, m/s.
    pub finger_speed_m_s: f64,
    /// The most grasps of an object that are considered.
    pub max_grasps: usize,
    /// The most places for an object that are considered.
    pub max_places: usize,
    /// The most grasps whose motions are planned before there is no path.
    pub max_options: usize,
    /// Samples of the planner for one motion.
    pub max_samples: usize,
    /// Frames of the record in a second.
    pub record_hz: f64,
    /// Heights of what the base stands on above the top of the table, meters, in the order in which they are tried: a
    /// plate, and stands for arms that cannot point down at what is as high as they are.
    pub mounts_m: Vec<f64>,
    /// A share of the weight that the strongest grip of both pads could hold by friction; heavier objects are refused.
    pub payload_share: f64,
}

impl ExecutionSettings {
    /// Limits of width and weight for objects that a robot can take and lift, from its file.
    pub fn limits_of(&self, robot: &Robot, grasps: &GraspSettings) -> RobotLimits {
        let gripper = robot.gripper();
        let payload_kg = self.max_payload_kg(gripper);
        RobotLimits::new(robot.name(), gripper.max_opening_m, grasps.opening_margin_m, payload_kg)
    }

    /// The heaviest object that a gripper may carry; the rest of its friction is for accelerations.
    pub fn max_payload_kg(&self, gripper: &Gripper) -> f64 {
        let friction_n = 2.0 * gripper.pad_friction * gripper.max_force_n;
        self.payload_share * friction_n / GRAVITY_M_S2
    }
}
