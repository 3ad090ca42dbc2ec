//! A robot as rigid bodies: links that do not move against each other are one body, and shapes are convex hulls.
//!
//! The simulator and the grasp planner share it, so that they judge the same shapes. [`Mechanism::of_robot`] makes the
//! whole arm; [`Mechanism::of_hand`] makes the gripper alone, on three slides along the axes of the world.

mod hand;
mod hulls;

use geometry::ConvexHull;
use nalgebra::{Isometry3, Unit, Vector3};
use rapier3d_f64::prelude::MassProperties;
use robot::model::{Inertia, JointDrive, JointLimits, JointMotion, Link, MovingKind, PositionSource, Robot};

pub use hulls::hull_of;

/// Bodies that joints connect: the first is the base, every other one comes after its parent.
#[derive(Clone, Debug)]
pub struct Mechanism {
    pub parts: Vec<Part>,
    /// The parts that the joints of the arm carry, in the order of its configuration.
    pub arm_parts: Vec<usize>,
    /// The part that the joint of the gripper carries.
    pub finger_part: usize,
    /// The parts whose joints follow that of the gripper: `multiplier * position + offset`.
    pub following_parts: Vec<(usize, f64, f64)>,
    /// The part that carries the tool, and the tool's pose in it.
    pub tool_part: usize,
    pub part_from_tool: Isometry3<f64>,
    /// The part of each link of the robot; `None` for links that the mechanism leaves out.
    pub part_of_link: Vec<Option<usize>>,
}

/// One body.
#[derive(Clone, Debug)]
pub struct Part {
    pub name: String,
    /// The base has none.
    pub joint: Option<PartJoint>,
    /// In the frame of the part, which is that of the link its joint carries. `None` for a part without mass.
    pub mass: Option<MassProperties>,
    /// Collision geometry, in the frame of the part.
    pub hulls: Vec<ConvexHull>,
    /// The pads of a finger, which collide too.
    pub pads: Vec<ConvexHull>,
}

/// The joint that carries a part.
#[derive(Clone, Debug)]
pub struct PartJoint {
    pub parent: usize,
    /// The frame of the joint at position 0 in the frame of the parent.
    pub parent_from_joint: Isometry3<f64>,
    pub kind: MovingKind,
    pub axis: Unit<Vector3<f64>>,
    pub limits: JointLimits,
    pub drive: JointDrive,
    pub source: PositionSource,
}

impl Mechanism {
    /// The whole robot.
    pub fn of_robot(robot: &Robot) -> Self {
        let mut parts: Vec<Part> = Vec::new();
        // For each link its part and its pose in it.
        let mut placed: Vec<(usize, Isometry3<f64>)> = Vec::with_capacity(robot.links().len());
        for link in robot.links() {
            let joint = link.joint.as_ref();
            let place = match joint.map(|joint| (joint, &joint.motion)) {
                Some((joint, JointMotion::Fixed)) => {
                    let (part, part_from_parent) = placed[joint.parent];
                    (part, part_from_parent * joint.parent_from_joint)
                }
                Some((joint, JointMotion::Moving(moving))) => {
                    let (parent, part_from_parent) = placed[joint.parent];
                    parts.push(Part::empty(
                        &link.name,
                        Some(PartJoint {
                            parent,
                            parent_from_joint: part_from_parent * joint.parent_from_joint,
                            kind: moving.kind,
                            axis: moving.axis,
                            limits: moving.limits,
                            drive: moving.drive,
                            source: moving.source,
                        }),
                    ));
                    (parts.len() - 1, Isometry3::identity())
                }
                None => {
                    parts.push(Part::empty(&link.name, None));
                    (parts.len() - 1, Isometry3::identity())
                }
            };
            parts[place.0].add(link, &place.1);
            placed.push(place);
        }
        let part_of_link = placed.iter().map(|(part, _)| Some(*part)).collect();
        let (tool_part, part_from_link) = placed[robot.tool().link];
        let mut arm_parts = vec![0; robot.dof()];
        let (mut finger_part, mut following_parts) = (0, Vec::new());
        for (index, part) in parts.iter().enumerate() {
            match part.joint.as_ref().map(|joint| joint.source) {
                Some(PositionSource::Arm(joint)) => arm_parts[joint] = index,
                Some(PositionSource::Gripper { .. }) if index == placed[robot.gripper().link].0 => {
                    finger_part = index;
                }
                Some(PositionSource::Gripper { multiplier, offset }) => {
                    following_parts.push((index, multiplier, offset));
                }
                None => {}
            }
        }
        Self {
            parts,
            arm_parts,
            finger_part,
            following_parts,
            tool_part,
            part_from_tool: part_from_link * robot.tool().link_from_tool,
            part_of_link,
        }
    }

    /// The parts of the fingers: the driven one first.
    pub fn fingers(&self) -> impl Iterator<Item = usize> + '_ {
        std::iter::once(self.finger_part).chain(self.following_parts.iter().map(|(part, _, _)| *part))
    }

    /// The poses of all parts in the frame of the base, for the positions of the arm's joints and that of the gripper's
    /// joint. `positions` is as long as the arm has joints.
    pub fn base_from_parts(&self, positions: &[f64], gripper_position: f64) -> Vec<Isometry3<f64>> {
        let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(self.parts.len());
        for part in &self.parts {
            let pose = part.joint.as_ref().map_or_else(Isometry3::identity, |joint| {
                poses[joint.parent]
                    * joint.parent_from_joint
                    * joint.displacement(joint.position(positions, gripper_position))
            });
            poses.push(pose);
        }
        poses
    }
}

impl PartJoint {
    /// The position of the joint in a configuration of the arm and a position of the gripper's joint.
    pub fn position(&self, positions: &[f64], gripper_position: f64) -> f64 {
        match self.source {
            PositionSource::Arm(index) => positions.get(index).copied().unwrap_or(0.0),
            PositionSource::Gripper { multiplier, offset } => multiplier * gripper_position + offset,
        }
    }

    fn displacement(&self, position: f64) -> Isometry3<f64> {
        match self.kind {
            MovingKind::Revolute => Isometry3::rotation(self.axis.into_inner() * position),
            MovingKind::Prismatic => {
                let way = self.axis.into_inner() * position;
                Isometry3::translation(way.x, way.y, way.z)
            }
        }
    }
}

impl Part {
    fn empty(name: &str, joint: Option<PartJoint>) -> Self {
        Self { name: name.to_owned(), joint, mass: None, hulls: Vec::new(), pads: Vec::new() }
    }

    /// Adds the mass and the colliding shapes of a link that is fixed to the part.
    fn add(&mut self, link: &Link, part_from_link: &Isometry3<f64>) {
        for shape in link.shapes.iter().filter(|shape| shape.collides()) {
            let hull = hull_of(shape, part_from_link);
            if shape.is_pad { self.pads.push(hull) } else { self.hulls.push(hull) }
        }
        if let Some(inertia) = &link.inertia {
            let mass = mass_of(inertia, part_from_link);
            self.mass = Some(match self.mass.take() {
                Some(own) => own + mass,
                None => mass,
            });
        }
    }
}

/// Mass properties of a link in the frame of its part.
fn mass_of(inertia: &Inertia, part_from_link: &Isometry3<f64>) -> MassProperties {
    let turn = part_from_link.rotation.to_rotation_matrix();
    let center = part_from_link * nalgebra::Point3::from(inertia.center_m);
    let tensor = turn.matrix() * inertia.tensor_kg_m2 * turn.matrix().transpose();
    let columns: [f64; 9] = std::array::from_fn(|k| tensor[(k % 3, k / 3)]);
    let matrix = geometry::DMat3::from_cols_array(&columns);
    MassProperties::with_inertia_matrix(crate::frames::to_vector(&center.coords), inertia.mass_kg, matrix)
}

#[cfg(test)]
mod tests;
