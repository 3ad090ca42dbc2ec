//! The robot in the simulation: a multibody, its servos and its gripper.

use geometry::collision_shape::to_parry;
use geometry::{DQuat, DVec3, Pose};
use nalgebra::Isometry3;
use physics::hull_set::HullSet;
use rapier3d_f64::dynamics::{Multibody, MultibodyLinkId};
use rapier3d_f64::math::Pose as RapierPose;
use rapier3d_f64::prelude::{
    CoefficientCombineRule, ColliderBuilder, ColliderHandle, GenericJoint, Group, InteractionGroups,
    InteractionTestMode, JointAxesMask, JointAxis, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle,
    SharedShape,
};
use robot::model::{MovingKind, PositionSource, Robot};

use super::{NEVER_RECYCLED, WorldError, WorldOptions};
use crate::frames::{to_isometry, to_pose, to_vector};
use crate::mechanism::{Mechanism, Part, PartJoint};

/// The group of everything that is no part of the robot.
pub(super) fn object_groups() -> Group {
    Group::GROUP_32
}

/// The most parts that have a group of their own.
const MAX_PARTS: usize = 31;

/// The robot's bodies and what they shall do.
pub(super) struct RobotBody {
    pub mechanism: Mechanism,
    /// One for each part.
    pub handles: Vec<RigidBodyHandle>,
    /// The colliders of the pads, each with its finger.
    pub pads: Vec<(RigidBodyHandle, ColliderHandle)>,
    /// Position and velocity that each joint of the arm shall have.
    pub arm_targets: Vec<(f64, f64)>,
    pub gripper: GripperServo,
    opening_per_position: f64,
}

/// Stiffness that keeps the fingers where the gripper's mechanism has them against each other, newtons per meter.
const MECHANISM_STIFFNESS: f64 = 1e5;
/// Damping of a finger against the hand, newton seconds per meter.
const FINGER_DAMPING: f64 = 20.0;

/// State of the one servo of the fingers, which moves its target at a bounded speed with a bounded force.
#[derive(Clone, Copy, Debug)]
pub(super) struct GripperServo {
    /// The position of the gripper's joint that is asked for, and the one that the servo pulls to now.
    goal: f64,
    target: f64,
    speed_m_s: f64,
    /// The force that each pad presses with at most.
    force_n: f64,
    position_per_opening: f64,
}

impl GripperServo {
    pub fn command(&mut self, opening_m: f64, finger_speed_m_s: f64, force_n: f64) {
        self.goal = opening_m * self.position_per_opening;
        self.speed_m_s = finger_speed_m_s.max(0.0);
        self.force_n = force_n.max(0.0);
    }

    /// Moves the target toward the goal, but not farther from where the fingers are than the greatest force needs:
    /// fingers that something stops start to move back as soon as they are asked to. Gives the position that the
    /// springs of the fingers rest at.
    fn advance(&mut self, position: f64, step_s: f64) -> f64 {
        let way = self.speed_m_s * step_s;
        self.target += (self.goal - self.target).clamp(-way, way);
        let lead = self.force_n / MECHANISM_STIFFNESS;
        self.target = self.target.clamp(position - 2.0 * lead - 2.0 * way, position + 2.0 * lead + 2.0 * way);
        position + (self.target - position).clamp(-lead, lead)
    }
}

impl RobotBody {
    #[expect(clippy::too_many_arguments, reason = "the robot, where it stands, and how it starts")]
    pub fn insert(
        world: &mut PhysicsWorld,
        robot: &Robot,
        mechanism: Mechanism,
        checked_pairs: &[(usize, usize)],
        world_from_base: &Isometry3<f64>,
        start: &[f64],
        opening_m: f64,
        options: &WorldOptions,
    ) -> Result<Self, WorldError> {
        let gripper_position = robot.gripper_position(opening_m);
        let placed = mechanism.base_from_parts(start, gripper_position);
        if mechanism.parts.len() > MAX_PARTS {
            let part = mechanism.parts[MAX_PARTS].name.clone();
            return Err(WorldError::BadRobot { part });
        }
        let mut handles: Vec<RigidBodyHandle> = Vec::with_capacity(mechanism.parts.len());
        let mut pads = Vec::new();
        for (index, part) in mechanism.parts.iter().enumerate() {
            let pose = to_pose(&(world_from_base * placed[index]));
            let builder = match (&part.joint, &part.mass) {
                (None, _) => RigidBodyBuilder::fixed(),
                (Some(_), Some(mass)) => RigidBodyBuilder::dynamic().additional_mass_properties(*mass),
                (Some(_), None) => return Err(WorldError::BadRobot { part: part.name.clone() }),
            };
            let rigid = builder.pose(to_parry(&pose)).gravity_scale(0.0).can_sleep(false);
            handles.push(world.insert_body(rigid));
            let groups = part_groups(&mechanism, index, checked_pairs);
            let pad = insert_colliders(world, robot, part, handles[index], groups);
            pads.extend(pad.map(|pad| (handles[index], pad)));
        }
        for (index, part) in mechanism.parts.iter().enumerate() {
            let Some(joint) = &part.joint else { continue };
            world.multibody_joints.insert(handles[joint.parent], handles[index], joint_of(joint), true);
        }
        let mut body = Self {
            gripper: GripperServo {
                goal: gripper_position,
                target: gripper_position,
                speed_m_s: 0.1,
                force_n: robot.gripper().grip_force_n,
                position_per_opening: 1.0 / robot.gripper().opening_per_position,
            },
            opening_per_position: robot.gripper().opening_per_position,
            arm_targets: start.iter().map(|&position| (position, 0.0)).collect(),
            handles,
            pads,
            mechanism,
        };
        body.start(world, start, gripper_position)?;
        body.drive(world, 1.0 / options.steps_per_s);
        Ok(body)
    }

    /// Puts the joints at their first positions, and gives them armature and damping.
    fn start(&mut self, world: &mut PhysicsWorld, start: &[f64], gripper: f64) -> Result<(), WorldError> {
        let bad = |part: usize| WorldError::BadRobot { part: self.mechanism.parts[part].name.clone() };
        let ids: Vec<Option<MultibodyLinkId>> = self
            .handles
            .iter()
            .map(|handle| world.multibody_joints.rigid_body_link(*handle).copied())
            .collect();
        let id = |part: usize| ids[part].ok_or_else(|| bad(part));
        let index = id(self.mechanism.finger_part)?.multibody;
        let multibody =
            world.multibody_joints.get_multibody_mut(index).ok_or_else(|| bad(self.mechanism.finger_part))?;
        // The root is fixed and has no degrees of freedom after this.
        multibody.forward_kinematics(&world.bodies, true);
        let mut displacements = vec![0.0; multibody.ndofs()];
        for (part, data) in self.mechanism.parts.iter().enumerate() {
            let Some(joint) = &data.joint else { continue };
            let dof = multibody.link(id(part)?.id).ok_or_else(|| bad(part))?.assembly_id();
            displacements[dof] = joint.position(start, gripper);
            multibody.armature_mut()[dof] = joint.drive.armature;
            multibody.damping_mut()[dof] = joint.drive.joint_damping
                + match joint.source {
                    PositionSource::Arm(_) => joint.drive.damping,
                    PositionSource::Gripper { .. } => FINGER_DAMPING,
                };
        }
        multibody.apply_displacements(&displacements);
        multibody.forward_kinematics(&world.bodies, false);
        multibody.update_rigid_bodies(&mut world.bodies, true);
        Ok(())
    }

    /// Sets the targets of all servos for the next step.
    ///
    /// A servo is a spring of the joint with the damping of the joint, both implicit in the engine's equations of
    /// motion: stiff servos then neither oscillate nor leave contacts unsolved, as those do that are constraints. A
    /// velocity moves the rest of the spring ahead by what damping holds back, and the greatest effort bounds how far
    /// the rest is from where the joint is.
    pub fn drive(&mut self, world: &mut PhysicsWorld, step_s: f64) {
        let common = self.gripper_position(world);
        let gripper_rest = self.gripper.advance(common, step_s);
        let mut springs: Vec<(usize, f64, f64)> = Vec::with_capacity(self.mechanism.parts.len());
        for (&part, &(target, velocity)) in self.mechanism.arm_parts.iter().zip(&self.arm_targets) {
            let Some(joint) = &self.mechanism.parts[part].joint else { continue };
            let (stiffness, reach) = (joint.drive.stiffness, joint.limits.max_effort / joint.drive.stiffness);
            // The spring and the damping together pull with the effort of the servo.
            let lag = joint.drive.damping / stiffness;
            let balanced = self.position(world, part) + lag * self.velocity(world, part);
            let rest = target + lag * velocity;
            springs.push((part, stiffness, rest.clamp(balanced - reach, balanced + reach)));
        }
        springs.push((self.mechanism.finger_part, MECHANISM_STIFFNESS, gripper_rest));
        for &(part, multiplier, offset) in &self.mechanism.following_parts {
            springs.push((part, MECHANISM_STIFFNESS, multiplier * gripper_rest + offset));
        }
        for (part, stiffness, rest) in springs {
            let axis = self.axis(part) as usize;
            let Some(link) = world.multibody_joints.rigid_body_link(self.handles[part]).copied() else {
                continue;
            };
            let multibody = world.multibody_joints.get_multibody_mut(link.multibody);
            if let Some(link) = multibody.and_then(|multibody| multibody.link_mut(link.id)) {
                link.joint.set_spring(axis, stiffness, rest);
            }
        }
    }

    /// The position of the gripper's joint that the fingers have in the mean: its mechanism moves them alike.
    fn gripper_position(&self, world: &PhysicsWorld) -> f64 {
        let followers = self.mechanism.following_parts.iter().filter(|(_, multiplier, _)| *multiplier != 0.0);
        let of_followers =
            followers.map(|&(part, multiplier, offset)| (self.position(world, part) - offset) / multiplier);
        let all: Vec<f64> =
            std::iter::once(self.position(world, self.mechanism.finger_part)).chain(of_followers).collect();
        all.iter().sum::<f64>() / all.len() as f64
    }

    pub fn positions(&self, world: &PhysicsWorld) -> Vec<f64> {
        self.mechanism.arm_parts.iter().map(|&part| self.position(world, part)).collect()
    }

    pub fn velocities(&self, world: &PhysicsWorld) -> Vec<f64> {
        self.mechanism.arm_parts.iter().map(|&part| self.velocity(world, part)).collect()
    }

    fn velocity(&self, world: &PhysicsWorld, part: usize) -> f64 {
        let rate = || {
            let (multibody, link) = self.link(world, part)?;
            Some(multibody.joint_velocity(multibody.link(link.id)?)[0])
        };
        rate().unwrap_or(0.0)
    }

    pub fn opening_m(&self, world: &PhysicsWorld) -> f64 {
        self.gripper_position(world) * self.opening_per_position
    }

    pub fn tool_pose(&self, world: &PhysicsWorld) -> Pose {
        let part = geometry::collision_shape::from_parry(
            world.bodies[self.handles[self.mechanism.tool_part]].position(),
        );
        to_pose(&(to_isometry(&part) * self.mechanism.part_from_tool))
    }

    fn link<'a>(&self, world: &'a PhysicsWorld, part: usize) -> Option<(&'a Multibody, MultibodyLinkId)> {
        let link = *world.multibody_joints.rigid_body_link(self.handles[part])?;
        Some((world.multibody_joints.get_multibody(link.multibody)?, link))
    }

    fn position(&self, world: &PhysicsWorld, part: usize) -> f64 {
        let coordinate = || {
            let (multibody, link) = self.link(world, part)?;
            Some(multibody.link(link.id)?.joint().coords()[self.axis(part) as usize])
        };
        coordinate().unwrap_or(0.0)
    }

    fn axis(&self, part: usize) -> JointAxis {
        match self.mechanism.parts[part].joint.as_ref().map(|joint| joint.kind) {
            Some(MovingKind::Prismatic) => JointAxis::LinX,
            _ => JointAxis::AngX,
        }
    }
}

/// Inserts the shapes of a part, and gives the collider of its pad, if it has one.
fn insert_colliders(
    world: &mut PhysicsWorld,
    robot: &Robot,
    part: &Part,
    handle: RigidBodyHandle,
    groups: InteractionGroups,
) -> Option<ColliderHandle> {
    let housing = (&part.hulls, 0.5, CoefficientCombineRule::Average);
    let pad = (&part.pads, robot.gripper().pad_friction, CoefficientCombineRule::Max);
    let [_, pad] = [housing, pad].map(|(hulls, friction, rule)| {
        (!hulls.is_empty()).then(|| {
            let collider = ColliderBuilder::new(SharedShape::new(HullSet::new(hulls)))
                .density(0.0)
                .friction(friction)
                .friction_combine_rule(rule)
                .restitution(0.0)
                .active_hooks(NEVER_RECYCLED)
                .collision_groups(groups);
            world.insert_collider(collider, Some(handle))
        })
    });
    pad
}

/// The engine's joint: its x axis is that of the joint.
fn joint_of(joint: &PartJoint) -> GenericJoint {
    let along = DQuat::from_rotation_arc(DVec3::X, to_vector(&joint.axis));
    let (locked, axis) = match joint.kind {
        MovingKind::Revolute => (JointAxesMask::LOCKED_REVOLUTE_AXES, JointAxis::AngX),
        MovingKind::Prismatic => (JointAxesMask::LOCKED_PRISMATIC_AXES, JointAxis::LinX),
    };
    let mut data = GenericJoint::new(locked);
    let frame = to_pose(&joint.parent_from_joint);
    data.set_local_frame1(RapierPose::from_parts(frame.translation_m, frame.rotation * along));
    data.set_local_frame2(RapierPose::from_parts(DVec3::ZERO, along));
    data.set_limits(axis, [joint.limits.min_position, joint.limits.max_position]);
    data.set_contacts_enabled(false);
    data
}

/// A part is in a group of its own and meets objects and the parts that it must not touch.
fn part_groups(mechanism: &Mechanism, part: usize, checked_pairs: &[(usize, usize)]) -> InteractionGroups {
    let own = Group::from_bits_retain(1 << part);
    let mut filter = object_groups();
    for &(a, b) in checked_pairs {
        if let (Some(a), Some(b)) = (mechanism.part_of_link[a], mechanism.part_of_link[b]) {
            if a == part && b != part {
                filter |= Group::from_bits_retain(1 << b);
            }
            if b == part && a != part {
                filter |= Group::from_bits_retain(1 << a);
            }
        }
    }
    InteractionGroups::new(own, filter, InteractionTestMode::And)
}
