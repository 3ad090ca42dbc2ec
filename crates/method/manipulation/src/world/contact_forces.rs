//! Contacts between robot and objects, and their forces.

use rapier3d_f64::prelude::{PhysicsWorld, RigidBodyHandle};

use super::robot_body::RobotBody;

/// The sums of the normal forces with which the fingers press on an object, in the order of
/// [`crate::mechanism::Mechanism::fingers`], newtons.
#[derive(Clone, Debug, PartialEq)]
pub struct FingerForces {
    pub normal_n: Vec<f64>,
}

impl FingerForces {
    /// Whether all fingers press with at least `force_n`.
    pub fn hold(&self, force_n: f64) -> bool {
        self.normal_n.iter().all(|force| *force >= force_n)
    }

    /// Whether any finger presses at all.
    pub fn touch(&self) -> bool {
        self.normal_n.iter().any(|force| *force > 0.0)
    }
}

/// A part of the robot presses on an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// The index of the part in the mechanism.
    pub part: usize,
    /// The index of the object.
    pub object: usize,
    pub normal_n: f64,
}

/// The normal force between two bodies, newtons.
fn force_n(world: &PhysicsWorld, a: RigidBodyHandle, b: RigidBodyHandle) -> f64 {
    let (first, second) = (&world.bodies[a], &world.bodies[b]);
    let pairs = first.colliders().iter().flat_map(|&one| {
        second.colliders().iter().filter_map(move |&other| world.narrow_phase.contact_pair(one, other))
    });
    pairs.map(|pair| pair.total_impulse_magnitude()).sum::<f64>() / world.integration_parameters.dt
}

pub(super) fn touch(world: &PhysicsWorld, a: RigidBodyHandle, b: RigidBodyHandle) -> bool {
    force_n(world, a, b) > 0.0
}

pub(super) fn finger_forces(
    world: &PhysicsWorld,
    robot: &RobotBody,
    object: RigidBodyHandle,
) -> FingerForces {
    let fingers = robot.mechanism.fingers();
    FingerForces { normal_n: fingers.map(|part| force_n(world, robot.handles[part], object)).collect() }
}

pub(super) fn touches(world: &PhysicsWorld, robot: &RobotBody, objects: &[RigidBodyHandle]) -> Vec<Touch> {
    let pairs = robot.handles.iter().enumerate().flat_map(|(part, &handle)| {
        objects.iter().enumerate().map(move |(object, &other)| (part, handle, object, other))
    });
    pairs
        .map(|(part, handle, object, other)| Touch { part, object, normal_n: force_n(world, handle, other) })
        .filter(|touch| touch.normal_n > 0.0)
        .collect()
}
