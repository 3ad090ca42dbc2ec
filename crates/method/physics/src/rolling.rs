//! Rolling and spinning resistance, which the engine lacks, as dry friction after each step.

use rapier3d_f64::prelude::{PhysicsWorld, RigidBodyHandle};

use crate::Body;

/// Standard gravity, m/s^2.
pub const GRAVITY_M_S2: f64 = 9.81;

/// Slows the rotation of what rolls or spins in contact. Of a body that touches something, a torque of its
/// rolling friction times its weight takes what it can of the angular momentum, as dry friction does. So
/// what is too slow or leans too little to overcome it stops and stays, and what falls over is not held.
pub fn resist_rolling(world: &mut PhysicsWorld, bodies: &[&Body], handles: &[RigidBodyHandle]) {
    let step_s = world.integration_parameters.dt;
    for (body, &handle) in bodies.iter().zip(handles).filter(|(body, _)| !body.fixed) {
        let highest = body.rolling_friction_m * body.mass.mass_kg * GRAVITY_M_S2 * step_s;
        let touches = world.bodies[handle].colliders().iter().any(|&collider| {
            let mut pairs = world.narrow_phase.contact_pairs_with(collider);
            pairs.any(|pair| pair.total_impulse_magnitude() > 0.0)
        });
        if !touches || highest <= 0.0 {
            continue;
        }
        let moving = &mut world.bodies[handle];
        let (spin, inertia) = (moving.angvel(), moving.mass_properties().effective_angular_inertia());
        let momentum = (inertia * spin).length();
        // Dry friction stops a rotation and never reverses it.
        let left = if momentum > highest { 1.0 - highest / momentum } else { 0.0 };
        moving.set_angvel(spin * left, false);
    }
}
