//! Links and the joints that carry them.

use nalgebra::{Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};

use crate::model::limits::JointLimits;
use crate::model::shape::Shape;

/// A rigid part of a robot. The base has no joint; every other link has one, and its parent has a lower index.
#[derive(Clone, Debug)]
pub struct Link {
    pub name: String,
    pub joint: Option<Joint>,
    /// `None` for a frame without a body.
    pub inertia: Option<Inertia>,
    pub shapes: Vec<Shape>,
    /// Maximum distance by which the spheres that cover the link may stick out of its shapes, meters.
    pub sphere_tolerance_m: f64,
}

/// Mass, center of mass and inertia tensor about it, along the axes of the link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    pub mass_kg: f64,
    pub center_m: Vector3<f64>,
    pub tensor_kg_m2: Matrix3<f64>,
}

/// Joint between a link and its parent.
#[derive(Clone, Debug)]
pub struct Joint {
    pub name: String,
    /// The index of the link that carries the joint.
    pub parent: usize,
    /// The frame of the joint, which is that of the child link at position zero.
    pub parent_from_joint: Isometry3<f64>,
    pub motion: JointMotion,
}

/// Motion of a joint.
#[derive(Clone, Debug)]
pub enum JointMotion {
    Fixed,
    Moving(MovingJoint),
}

/// A joint that moves, and what moves it.
#[derive(Clone, Debug)]
pub struct MovingJoint {
    pub kind: MovingKind,
    pub axis: Unit<Vector3<f64>>,
    pub limits: JointLimits,
    pub drive: JointDrive,
    pub source: PositionSource,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MovingKind {
    /// Rotation about the axis; positions are radians.
    Revolute,
    /// Translation along the axis; positions are meters.
    Prismatic,
}

/// Source of the position of a moving joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PositionSource {
    /// The entry of the arm's configuration.
    Arm(usize),
    /// `multiplier * position + offset` for the position of the gripper's joint; that joint itself has 1 and 0.
    Gripper { multiplier: f64, offset: f64 },
}

/// The servo of a joint and the losses of its gear; newton meters and radians, or newtons and meters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointDrive {
    pub stiffness: f64,
    pub damping: f64,
    pub joint_damping: f64,
    pub joint_friction: f64,
    pub armature: f64,
}

impl Joint {
    pub fn moving(&self) -> Option<&MovingJoint> {
        match &self.motion {
            JointMotion::Fixed => None,
            JointMotion::Moving(moving) => Some(moving),
        }
    }
}

impl MovingJoint {
    /// Computes the motion from position zero to `position`.
    pub fn displacement(&self, position: f64) -> Isometry3<f64> {
        match self.kind {
            MovingKind::Revolute => Isometry3::from_parts(
                Translation3::identity(),
                UnitQuaternion::from_axis_angle(&self.axis, position),
            ),
            MovingKind::Prismatic => Isometry3::from_parts(
                Translation3::from(self.axis.into_inner() * position),
                UnitQuaternion::identity(),
            ),
        }
    }
}
