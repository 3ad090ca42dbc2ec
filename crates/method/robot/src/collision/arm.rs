//! An arm as the checks see it: joints in a row, and bodies made of spheres that move with them.

use nalgebra::{Isometry3, Point3};

use super::enclosing::enclosing_sphere;
use crate::model::limits::JointLimits;

/// The most joints that the checks handle: one lane of a stored configuration each.
pub const MAX_JOINTS: usize = 8;
/// The most bodies of an arm, what it carries included.
pub const MAX_BODIES: usize = 16;

/// A sphere in the frame of the body it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    pub center_m: Point3<f64>,
    pub radius_m: f64,
}

/// Motion by which a joint moves the links after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointMotion {
    /// Turns it about z of the joint's frame, in radians.
    Turn,
    /// Slides it along z of the joint's frame, in meters.
    Slide,
}

/// A joint of an arm. Its frame moves with it.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmJoint {
    /// The pose of the joint's frame at position 0 in the frame of the joint before it, or of the base.
    pub parent_from_joint: Isometry3<f64>,
    pub motion: JointMotion,
    pub limits: JointLimits,
}

/// Spheres that move together: a link, or what the gripper holds.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmBody {
    /// The frame that it is fixed to: 0 is the base, `k` the frame of the `k`-th joint, counted from 1.
    pub frame: usize,
    /// In that frame.
    pub spheres: Vec<Sphere>,
}

/// An arm: joints, bodies, and the pairs of bodies that must not touch.
#[derive(Clone, Debug)]
pub struct Arm {
    joints: Vec<ArmJoint>,
    bodies: Vec<ArmBody>,
    bounding: Vec<Sphere>,
    pairs: Vec<(usize, usize)>,
    reach_m: Vec<Vec<f64>>,
}

/// Reason why joints and bodies are not an arm.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ArmError {
    #[error("an arm has 1 to {MAX_JOINTS} joints, not {0}")]
    JointCount(usize),
    #[error("an arm has 1 to {MAX_BODIES} bodies, not {0}")]
    BodyCount(usize),
    #[error("joint {joint} has a frame or a range of positions that is not finite or is empty")]
    Joint { joint: usize },
    #[error("body {body} is fixed to frame {frame}; the arm has frames 0 to {last}")]
    Frame { body: usize, frame: usize, last: usize },
    #[error("body {body} has no spheres, or one without a finite center and a radius above zero")]
    Spheres { body: usize },
    #[error("the pair of bodies ({0}, {1}) names a body that the arm lacks, or one body twice")]
    Pair(usize, usize),
}

impl Arm {
    /// An arm whose bodies touch nothing, but for the `pairs` that are left unchecked by not being listed.
    pub fn new(
        joints: Vec<ArmJoint>,
        bodies: Vec<ArmBody>,
        pairs: Vec<(usize, usize)>,
    ) -> Result<Self, ArmError> {
        if joints.is_empty() || joints.len() > MAX_JOINTS {
            return Err(ArmError::JointCount(joints.len()));
        }
        if bodies.is_empty() || bodies.len() > MAX_BODIES {
            return Err(ArmError::BodyCount(bodies.len()));
        }
        let sound = |joint: &ArmJoint| {
            let (low, high) = (joint.limits.min_position, joint.limits.max_position);
            low.is_finite()
                && high.is_finite()
                && low < high
                && joint.parent_from_joint.to_homogeneous().iter().all(|entry| entry.is_finite())
        };
        if let Some(joint) = joints.iter().position(|joint| !sound(joint)) {
            return Err(ArmError::Joint { joint });
        }
        for (index, body) in bodies.iter().enumerate() {
            if body.frame > joints.len() {
                return Err(ArmError::Frame { body: index, frame: body.frame, last: joints.len() });
            }
            let sound = |s: &Sphere| {
                s.radius_m > 0.0 && s.radius_m.is_finite() && s.center_m.coords.iter().all(|c| c.is_finite())
            };
            if body.spheres.is_empty() || !body.spheres.iter().all(sound) {
                return Err(ArmError::Spheres { body: index });
            }
        }
        if let Some(&(a, b)) = pairs.iter().find(|&&(a, b)| a == b || a.max(b) >= bodies.len()) {
            return Err(ArmError::Pair(a, b));
        }
        let bounding = bodies.iter().map(|body| enclosing_sphere(&body.spheres)).collect();
        let reach_m = bodies.iter().map(|body| reach_m(&joints, body)).collect();
        Ok(Self { joints, bodies, bounding, pairs, reach_m })
    }

    /// The arm with something in its gripper.
    ///
    /// `held` moves with the frame it names. It may touch the bodies of `touching`, such as the fingers, and no other
    /// body that moves against it.
    pub fn holding(&self, held: ArmBody, touching: &[usize]) -> Result<Self, ArmError> {
        let new = self.bodies.len();
        let apart = |&other: &usize| self.bodies[other].frame != held.frame && !touching.contains(&other);
        let pairs =
            self.pairs.iter().copied().chain((0..new).filter(apart).map(|other| (other, new))).collect();
        let bodies = self.bodies.iter().cloned().chain([held.clone()]).collect();
        Self::new(self.joints.clone(), bodies, pairs)
    }

    /// The number of joints, which is the length of a configuration.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    pub fn joints(&self) -> &[ArmJoint] {
        &self.joints
    }

    pub fn bodies(&self) -> &[ArmBody] {
        &self.bodies
    }

    /// One sphere for each body that encloses its spheres, in the frame of the body.
    pub fn bounding_spheres(&self) -> &[Sphere] {
        &self.bounding
    }

    /// The pairs of bodies that must not touch.
    pub fn pairs(&self) -> &[(usize, usize)] {
        &self.pairs
    }

    /// The poses of all frames, `base_from_frame`; the first is that of the base.
    pub fn frames(&self, positions: &[f64]) -> Vec<Isometry3<f64>> {
        let mut frames = vec![Isometry3::identity()];
        for (joint, &position) in self.joints.iter().zip(positions) {
            let moved = match joint.motion {
                JointMotion::Turn => Isometry3::rotation(nalgebra::Vector3::z() * position),
                JointMotion::Slide => Isometry3::translation(0.0, 0.0, position),
            };
            let parent = frames[frames.len() - 1];
            frames.push(parent * joint.parent_from_joint * moved);
        }
        frames
    }

    /// No point of a body moves farther than this when each joint moves from `from` to `to`, each at a constant rate.
    pub fn motion_bound_m(&self, body: usize, from: &[f64], to: &[f64]) -> f64 {
        self.reach_m[body]
            .iter()
            .zip(from.iter().zip(to))
            .map(|(reach_m, (a, b))| reach_m * (b - a).abs())
            .sum()
    }
}

/// Upper bound of the distance that the farthest point of a body moves for one unit of each joint, meters.
fn reach_m(joints: &[ArmJoint], body: &ArmBody) -> Vec<f64> {
    let mut reach_m = vec![0.0; joints.len()];
    let mut beyond_m = body.spheres.iter().map(|s| s.center_m.coords.norm() + s.radius_m).fold(0.0, f64::max);
    for (index, joint) in joints.iter().enumerate().take(body.frame).rev() {
        let stroke_m = joint.limits.min_position.abs().max(joint.limits.max_position.abs());
        reach_m[index] = match joint.motion {
            JointMotion::Turn => beyond_m,
            JointMotion::Slide => 1.0,
        };
        beyond_m += joint.parent_from_joint.translation.vector.norm();
        if joint.motion == JointMotion::Slide {
            beyond_m += stroke_m;
        }
    }
    reach_m
}
