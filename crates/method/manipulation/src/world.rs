//! An arm with a gripper among rigid bodies, simulated.
//!
//! The robot is one multibody of rapier: the joints of the arm and those of the fingers, each with the servo of its
//! model (stiffness, damping, greatest effort, armature). One servo closes all fingers with a bounded force, and stiff
//! springs keep them moving alike. Gravity does not act on the robot, as if its controller compensated its own weight
//! exactly; what it holds does weigh on it. Dry friction of the gears is left out for the same reason.
//!
//! Objects and the table are the hulls of [`physics::Body`], with the contacts of [`physics::contacts`], which the
//! certificate of a scene uses too. A pad meets everything with the coefficient of the gripper's model, which is what
//! MuJoCo's rule, the greater of both, gives as well; other pairs have the mean of theirs. Pads also resist turning
//! about the closing line, as in the exported models. Links that must not touch each other do collide; pairs that the
//! model leaves unchecked do not.
//!
//! World frame, SI units. Equal inputs give equal bytes: order, steps and iterations are fixed.

mod contact_forces;
mod options;
mod pad_torsion;
mod robot_body;

use geometry::collision_shape::from_parry;
use geometry::{DVec3, Pose};
use nalgebra::Isometry3;
use physics::Body;
use physics::rigid_world::{ContactOptions, UnfitBody};
use physics::rolling::resist_rolling;
use rapier3d_f64::prelude::{
    ActiveHooks, Group, InteractionGroups, InteractionTestMode, PhysicsWorld, RigidBodyHandle,
};
use robot::model::Robot;

pub use contact_forces::{FingerForces, Touch};
pub use options::WorldOptions;

use crate::mechanism::Mechanism;
use pad_torsion::PadTorsion;
use robot_body::{RobotBody, object_groups};

/// Hook that makes the engine compute contacts anew in every step, although there is nothing to filter. Otherwise it
/// would keep the directions of contacts in the world: an object that turns with a hand would turn in it.
const NEVER_RECYCLED: ActiveHooks = ActiveHooks::FILTER_CONTACT_PAIRS;
/// Objects that turn faster than this are among these, radians per second.
const TURNING_RAD_S: f64 = 0.01;
/// Contacts of moving objects are predicted up to this distance, meters.
const LOOK_AHEAD_M: f64 = 0.01;

/// A robot and objects, ready to be simulated step by step.
pub struct ManipulationWorld {
    world: PhysicsWorld,
    robot: RobotBody,
    pad_torsion: PadTorsion,
    objects: Vec<Body>,
    handles: Vec<RigidBodyHandle>,
    options: WorldOptions,
    steps: u64,
}

/// Reason why a scene cannot be simulated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldError {
    #[error(transparent)]
    Unfit(#[from] UnfitBody),
    #[error("the start has {found} joints and the robot {expected}")]
    WrongLength { found: usize, expected: usize },
    #[error("the robot has no mass in {part} or joints that the simulation does not take")]
    BadRobot { part: String },
}

impl ManipulationWorld {
    /// A world with `objects`, which may be fixed as a table is, and the robot at rest in the configuration `start`
    /// with its pads `opening_m` apart.
    ///
    /// # Errors
    /// If an object has a broken hull or no mass, or `start` has the wrong length.
    pub fn new(
        objects: &[Body],
        robot: &Robot,
        world_from_base: &Isometry3<f64>,
        start: &[f64],
        opening_m: f64,
        options: &WorldOptions,
    ) -> Result<Self, WorldError> {
        let pairs = robot::model::checked_pairs(robot);
        Self::of_mechanism(
            objects,
            robot,
            Mechanism::of_robot(robot),
            &pairs,
            world_from_base,
            start,
            opening_m,
            options,
        )
    }

    /// A world with the gripper alone, its tool at `world_from_tool`. Its configuration is how far the hand is from
    /// there along x, y and z; see [`Mechanism::of_hand`].
    ///
    /// # Errors
    /// As [`ManipulationWorld::new`].
    pub fn with_hand(
        objects: &[Body],
        robot: &Robot,
        world_from_tool: &Isometry3<f64>,
        opening_m: f64,
        options: &WorldOptions,
    ) -> Result<Self, WorldError> {
        let hand = Mechanism::of_hand(robot, world_from_tool);
        Self::of_mechanism(objects, robot, hand, &[], &Isometry3::identity(), &[0.0; 3], opening_m, options)
    }

    #[expect(clippy::too_many_arguments, reason = "the two public constructors differ in three of them")]
    fn of_mechanism(
        objects: &[Body],
        robot: &Robot,
        mechanism: Mechanism,
        checked_pairs: &[(usize, usize)],
        world_from_base: &Isometry3<f64>,
        start: &[f64],
        opening_m: f64,
        options: &WorldOptions,
    ) -> Result<Self, WorldError> {
        if start.len() != mechanism.arm_parts.len() {
            return Err(WorldError::WrongLength { found: start.len(), expected: mechanism.arm_parts.len() });
        }
        let contacts = contact_options(options);
        let mut world = contacts.empty_world();
        // Otherwise what the hand holds creeps by tens of micrometers whenever it is accelerated.
        world.integration_parameters.friction_in_bias_pass = true;
        world.integration_parameters.num_internal_stabilization_iterations = options.friction_iterations;
        let groups = InteractionGroups::new(object_groups(), Group::ALL, InteractionTestMode::And);
        let handles = objects
            .iter()
            .map(|object| contacts.insert(&mut world, object, |collider| collider.collision_groups(groups)))
            .collect::<Result<Vec<_>, UnfitBody>>()?;
        let robot = RobotBody::insert(
            &mut world,
            robot,
            mechanism,
            checked_pairs,
            world_from_base,
            start,
            opening_m,
            options,
        )?;
        Ok(Self {
            world,
            robot,
            pad_torsion: PadTorsion::default(),
            objects: objects.to_vec(),
            handles,
            options: options.clone(),
            steps: 0,
        })
    }

    /// Sets where the servos of the arm pull to, and how fast the joints shall move there; both as long as the arm
    /// has joints. They hold until they are set again.
    pub fn set_joint_targets(&mut self, positions: &[f64], velocities: &[f64]) {
        self.robot.arm_targets = positions.iter().copied().zip(velocities.iter().copied()).collect();
    }

    /// Moves the pads until they are `opening_m` apart, each at up to `finger_speed_m_s`; each presses with at most
    /// `force_n` on what is between them.
    pub fn set_gripper(&mut self, opening_m: f64, finger_speed_m_s: f64, force_n: f64) {
        self.robot.gripper.command(opening_m, finger_speed_m_s, force_n);
    }

    /// Simulates one step.
    pub fn step(&mut self) {
        self.robot.drive(&mut self.world, 1.0 / self.options.steps_per_s);
        self.world.step();
        let bodies: Vec<&Body> = self.objects.iter().collect();
        resist_rolling(&mut self.world, &bodies, &self.handles);
        self.pad_torsion.resist(&mut self.world, &self.robot.pads, &self.handles);
        self.renew_turning();
        self.steps += 1;
    }

    /// Has the contacts of objects that turn computed anew in the next step.
    fn renew_turning(&mut self) {
        for &handle in &self.handles {
            let body = &self.world.bodies[handle];
            let hooks =
                if body.angvel().length() > TURNING_RAD_S { NEVER_RECYCLED } else { ActiveHooks::empty() };
            for &collider in body.colliders() {
                if self.world.colliders[collider].active_hooks() != hooks {
                    self.world.colliders[collider].set_active_hooks(hooks);
                }
            }
        }
    }

    /// Simulates `duration_s`, rounded to whole steps.
    pub fn simulate(&mut self, duration_s: f64) {
        for _ in 0..(duration_s * self.options.steps_per_s).round() as usize {
            self.step();
        }
    }

    /// The simulated time.
    pub fn time_s(&self) -> f64 {
        self.steps as f64 / self.options.steps_per_s
    }

    pub fn options(&self) -> &WorldOptions {
        &self.options
    }

    /// The positions of the arm's joints.
    pub fn joint_positions(&self) -> Vec<f64> {
        self.robot.positions(&self.world)
    }

    /// The velocities of the arm's joints.
    pub fn joint_velocities(&self) -> Vec<f64> {
        self.robot.velocities(&self.world)
    }

    /// Distance of the pads from each other, meters.
    pub fn opening_m(&self) -> f64 {
        self.robot.opening_m(&self.world)
    }

    /// `world_from_tool`.
    pub fn tool_pose(&self) -> Pose {
        self.robot.tool_pose(&self.world)
    }

    /// The objects as they were given.
    pub fn objects(&self) -> &[Body] {
        &self.objects
    }

    /// `world_from_object` of an object by its index.
    pub fn object_pose(&self, object: usize) -> Pose {
        from_parry(self.world.bodies[self.handles[object]].position())
    }

    /// `world_from_object` of all objects.
    pub fn object_poses(&self) -> Vec<Pose> {
        (0..self.handles.len()).map(|object| self.object_pose(object)).collect()
    }

    /// The velocity of an object's center of mass, m/s, and its angular velocity, rad/s.
    pub fn object_velocity(&self, object: usize) -> (DVec3, DVec3) {
        let body = &self.world.bodies[self.handles[object]];
        (body.linvel(), body.angvel())
    }

    /// The forces with which the fingers press on an object.
    pub fn finger_forces(&self, object: usize) -> FingerForces {
        contact_forces::finger_forces(&self.world, &self.robot, self.handles[object])
    }

    /// Contacts of the robot, object by object and part by part, with the normal forces.
    pub fn touches(&self) -> Vec<Touch> {
        contact_forces::touches(&self.world, &self.robot, &self.handles)
    }

    /// Whether two objects touch with a force, by their indices.
    pub fn objects_touch(&self, a: usize, b: usize) -> bool {
        contact_forces::touch(&self.world, self.handles[a], self.handles[b])
    }
}

fn contact_options(options: &WorldOptions) -> ContactOptions {
    ContactOptions {
        steps_per_s: options.steps_per_s,
        solver_iterations: options.solver_iterations,
        contact_frequency_hz: options.contact_frequency_hz,
        length_unit_m: options.length_unit_m,
        damping_per_s: options.damping_per_s,
        look_ahead_m: LOOK_AHEAD_M,
    }
}

#[cfg(test)]
mod tests;
