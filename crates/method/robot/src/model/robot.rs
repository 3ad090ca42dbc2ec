//! A robot: a tree of links, an arm that a planner moves, a gripper with one degree of freedom, and a tool frame.

use nalgebra::Isometry3;

use crate::model::limits::JointLimits;
use crate::model::link::{Joint, Link, MovingJoint, PositionSource};

/// A checked robot. `Robot::parse` makes one from a file, `Robot::built_in` from a file of this repository.
///
/// `positions` everywhere are those of the arm's joints in the order of `arm_links`; the gripper is stated apart.
#[derive(Clone, Debug)]
pub struct Robot {
    pub(super) name: String,
    pub(super) variant: Option<String>,
    pub(super) title: String,
    pub(super) sources: Vec<String>,
    pub(super) materials: Vec<Material>,
    pub(super) links: Vec<Link>,
    pub(super) arm_links: Vec<usize>,
    pub(super) arm_limits: Vec<JointLimits>,
    pub(super) gripper: Gripper,
    pub(super) tool: Tool,
    pub(super) home: Home,
    pub(super) ignored_pairs: Vec<IgnoredPair>,
}

/// A named color.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    pub name: String,
    /// Each channel in 0..=1.
    pub srgb: [f64; 3],
}

/// Two fingers that one joint moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Gripper {
    /// The index of the link that the gripper's joint carries; the other fingers mimic it.
    pub link: usize,
    /// Meters between the pads for one meter of the joint.
    pub opening_per_position: f64,
    pub max_opening_m: f64,
    /// The force that a grip uses.
    pub grip_force_n: f64,
    /// The force that the gripper can hold continuously.
    pub max_force_n: f64,
    /// The coefficient of friction between pads and what they hold.
    pub pad_friction: f64,
}

/// The frame between the finger tips whose z axis points away from the arm; the fingers close along its y axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    pub name: String,
    pub link: usize,
    pub link_from_tool: Isometry3<f64>,
}

/// Waiting position of the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Home {
    pub positions: Vec<f64>,
    pub opening_m: f64,
}

/// Two links that are not checked against each other, lower index first, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct IgnoredPair {
    pub links: (usize, usize),
    pub reason: String,
}

impl Robot {
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The variant that was chosen, such as another zero convention.
    pub fn variant(&self) -> Option<&str> {
        self.variant.as_deref()
    }

    pub fn title(&self) -> &str {
        &self.title
    }

    pub fn sources(&self) -> &[String] {
        &self.sources
    }

    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The links, the base first and each other one after its parent.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// The number of joints of the arm.
    pub fn dof(&self) -> usize {
        self.arm_links.len()
    }

    /// The indices of the links that the joints of the arm carry, from the base to the tool.
    pub fn arm_links(&self) -> &[usize] {
        &self.arm_links
    }

    /// The joints of the arm, from the base to the tool.
    pub fn arm_joints(&self) -> impl Iterator<Item = &MovingJoint> {
        self.arm_links.iter().filter_map(|link| self.links[*link].joint.as_ref()?.moving())
    }

    /// The limits of the arm's joints.
    pub fn limits(&self) -> &[JointLimits] {
        &self.arm_limits
    }

    pub fn gripper(&self) -> &Gripper {
        &self.gripper
    }

    pub fn tool(&self) -> &Tool {
        &self.tool
    }

    pub fn home(&self) -> &Home {
        &self.home
    }

    pub fn ignored_pairs(&self) -> &[IgnoredPair] {
        &self.ignored_pairs
    }

    pub fn link_index(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    /// Whether every joint of the arm is within its limits.
    pub fn admits(&self, positions: &[f64]) -> bool {
        positions.len() == self.dof() && self.arm_limits.iter().zip(positions).all(|(l, p)| l.admits(*p))
    }

    /// The position of the gripper's joint at which the pads are `opening_m` apart.
    pub fn gripper_position(&self, opening_m: f64) -> f64 {
        opening_m / self.gripper.opening_per_position
    }

    /// The links that the gripper's joint and those that mimic it carry.
    pub fn fingers(&self) -> impl Iterator<Item = (&Link, &Joint, &MovingJoint)> {
        self.links.iter().filter_map(|link| {
            let joint = link.joint.as_ref()?;
            let moving = joint.moving()?;
            matches!(moving.source, PositionSource::Gripper { .. }).then_some((link, joint, moving))
        })
    }

    /// Difference between the position of the gripper's joint and the target of its servo, for each pad to press with a
    /// force. One servo pulls all fingers, each with an equal share. A held object stops the joint, so that the servo's
    /// stiffness makes the force of this difference. For objects thinner than it the target is below 0.
    pub fn gripper_lead(&self, force_n: f64) -> f64 {
        let servo = self.links[self.gripper.link].joint.as_ref().and_then(Joint::moving);
        servo.map_or(0.0, |joint| self.fingers().count() as f64 * force_n / joint.drive.stiffness)
    }

    /// The position of a moving joint in a configuration of the arm and an opening of the gripper.
    pub fn joint_position(&self, joint: &MovingJoint, positions: &[f64], opening_m: f64) -> f64 {
        match joint.source {
            PositionSource::Arm(index) => positions[index],
            PositionSource::Gripper { multiplier, offset } => {
                multiplier * self.gripper_position(opening_m) + offset
            }
        }
    }
}
