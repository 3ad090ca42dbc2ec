//! A robot as a `SphereModel`: eight configurations at a time, in `f32`.

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use wide::f32x8;

use crate::model::cover::{bounding_sphere, cover_link};
use crate::model::limits::JointLimits;
use crate::model::link::{Joint, MovingKind, PositionSource};
use crate::model::robot::Robot;
use crate::model::self_collision::checked_pairs;
use crate::model::sphere_model::{LinkPose8, LinkPoses8, LinkSphere, SphereModel};

/// An arm with a fixed opening of the gripper, and whatever is attached to its links.
#[derive(Clone, Debug)]
pub struct ArmSpheres {
    limits: Vec<JointLimits>,
    /// One for each link but the base.
    steps: Vec<Step>,
    spheres: Vec<LinkSphere>,
    bounding_spheres: Vec<LinkSphere>,
    pairs: Vec<(usize, usize)>,
}

/// Relation of the pose of a link to that of its parent.
#[derive(Clone, Debug)]
struct Step {
    parent: usize,
    before: Constant,
    motion: Motion,
}

#[derive(Clone, Debug)]
enum Motion {
    None,
    /// A turn about z, and back to the axes of the link where the joint's axis is another.
    Turn {
        index: usize,
        after: Option<Constant>,
    },
    Slide {
        index: usize,
        axis: [f32; 3],
    },
}

/// A transform that does not change.
#[derive(Clone, Copy, Debug)]
struct Constant {
    rotation: [[f32; 3]; 3],
    translation_m: [f32; 3],
}

impl ArmSpheres {
    /// Computes the spheres of all links of `robot` with the pads `opening_m` apart.
    pub fn new(robot: &Robot, opening_m: f64) -> Self {
        let joints = robot.links().iter().filter_map(|link| link.joint.as_ref());
        let steps = joints.map(|joint| step(robot, joint, opening_m)).collect();
        let links = robot.links().iter().enumerate();
        let spheres = links.flat_map(|(index, link)| cover_link(link, index)).collect();
        let mut arm = Self {
            limits: robot.limits().to_vec(),
            steps,
            spheres,
            bounding_spheres: Vec::new(),
            pairs: checked_pairs(robot),
        };
        arm.bound();
        arm
    }

    /// Adds spheres to links, such as those of an object that the gripper holds.
    pub fn with_attached(mut self, spheres: &[LinkSphere]) -> Self {
        self.spheres.extend_from_slice(spheres);
        self.spheres.sort_by_key(|sphere| sphere.link);
        self.bound();
        self
    }

    fn bound(&mut self) {
        let by_link = self.spheres.chunk_by(|a, b| a.link == b.link);
        self.bounding_spheres = by_link.filter_map(bounding_sphere).collect();
    }
}

fn step(robot: &Robot, joint: &Joint, opening_m: f64) -> Step {
    let fixed = |transform: Isometry3<f64>| (Constant::from(transform), Motion::None);
    let (before, motion) = match joint.moving() {
        None => fixed(joint.parent_from_joint),
        Some(moving) => match (moving.source, moving.kind) {
            (PositionSource::Gripper { .. }, _) => {
                let position = robot.joint_position(moving, &[], opening_m);
                fixed(joint.parent_from_joint * moving.displacement(position))
            }
            (PositionSource::Arm(index), MovingKind::Prismatic) => {
                let axis = moving.axis.map(|coordinate| coordinate as f32).into();
                (Constant::from(joint.parent_from_joint), Motion::Slide { index, axis })
            }
            (PositionSource::Arm(index), MovingKind::Revolute) => {
                let half_turn = || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
                let link_from_turned =
                    UnitQuaternion::rotation_between(&Vector3::z(), &moving.axis).unwrap_or_else(half_turn);
                let turned_from_link =
                    Isometry3::from_parts(Translation3::identity(), link_from_turned.inverse());
                let after = (moving.axis != Vector3::z_axis()).then(|| Constant::from(turned_from_link));
                (Constant::from(joint.parent_from_joint * link_from_turned), Motion::Turn { index, after })
            }
        },
    };
    Step { parent: joint.parent, before, motion }
}

impl SphereModel for ArmSpheres {
    fn limits(&self) -> &[JointLimits] {
        &self.limits
    }

    fn link_count(&self) -> usize {
        self.steps.len() + 1
    }

    fn spheres(&self) -> &[LinkSphere] {
        &self.spheres
    }

    fn bounding_spheres(&self) -> &[LinkSphere] {
        &self.bounding_spheres
    }

    fn self_collision_pairs(&self) -> &[(usize, usize)] {
        &self.pairs
    }

    fn place_links8(&self, positions: &[f32x8], out: &mut LinkPoses8) {
        out.links.clear();
        out.links.push(LinkPose8::IDENTITY);
        for step in &self.steps {
            let mut pose = step.before.after(&out.links[step.parent]);
            match &step.motion {
                Motion::None => {}
                Motion::Turn { index, after } => {
                    pose.turn_about_z(positions[*index]);
                    if let Some(after) = after {
                        pose = after.after(&pose);
                    }
                }
                Motion::Slide { index, axis } => pose.slide(*axis, positions[*index]),
            }
            out.links.push(pose);
        }
    }
}

impl From<Isometry3<f64>> for Constant {
    fn from(transform: Isometry3<f64>) -> Self {
        // Quarter turns have zeros, which cost nothing below.
        let clean = |value: f64| if value.abs() < 1e-12 { 0.0 } else { value as f32 };
        let matrix: Matrix3<f64> = transform.rotation.to_rotation_matrix().into_inner();
        Self {
            rotation: std::array::from_fn(|row| std::array::from_fn(|column| clean(matrix[(row, column)]))),
            translation_m: std::array::from_fn(|row| clean(transform.translation.vector[row])),
        }
    }
}

impl Constant {
    /// Computes the pose of a frame that is fixed in the frame at `pose`.
    #[inline]
    fn after(&self, pose: &LinkPose8) -> LinkPose8 {
        let mut result = LinkPose8 { rotation: [[f32x8::ZERO; 3]; 3], translation_m: pose.translation_m };
        for k in 0..3 {
            for column in 0..3 {
                let factor = self.rotation[k][column];
                if factor != 0.0 {
                    for row in 0..3 {
                        let sum = result.rotation[row][column];
                        result.rotation[row][column] =
                            pose.rotation[row][k].mul_add(f32x8::splat(factor), sum);
                    }
                }
            }
            let factor = self.translation_m[k];
            if factor != 0.0 {
                for row in 0..3 {
                    let sum = result.translation_m[row];
                    result.translation_m[row] = pose.rotation[row][k].mul_add(f32x8::splat(factor), sum);
                }
            }
        }
        result
    }
}

impl LinkPose8 {
    const IDENTITY: Self = Self {
        rotation: [
            [f32x8::ONE, f32x8::ZERO, f32x8::ZERO],
            [f32x8::ZERO, f32x8::ONE, f32x8::ZERO],
            [f32x8::ZERO, f32x8::ZERO, f32x8::ONE],
        ],
        translation_m: [f32x8::ZERO; 3],
    };

    #[inline]
    fn turn_about_z(&mut self, angle_rad: f32x8) {
        let (sin, cos) = angle_rad.sin_cos();
        for [x, y, _] in &mut self.rotation {
            (*x, *y) = (cos * *x + sin * *y, cos * *y - sin * *x);
        }
    }

    #[inline]
    fn slide(&mut self, axis: [f32; 3], distance_m: f32x8) {
        for (row, translation) in self.rotation.iter().zip(&mut self.translation_m) {
            for (direction, along) in row.iter().zip(axis) {
                *translation = direction.mul_add(f32x8::splat(along) * distance_m, *translation);
            }
        }
    }
}

#[cfg(test)]
mod tests;
