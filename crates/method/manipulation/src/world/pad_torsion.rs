//! Friction of the pads against turning about the closing line, which the engine lacks.
//!
//! A soft pad touches with a patch, and a patch resists turning where a few points of contact do not: an object that
//! is gripped beside its center of mass, or by a round side, would swing about the line between the pads. The robot's
//! exported models state this friction as a length, the radius at which the sliding friction of the patch acts in
//! effect, so that the greatest torque is this length times the normal force. Of the normal force, sliding and turning
//! take their shares together: the sum of the squares of both shares is at most one.
//!
//! The engine takes forces from outside only once for each step, so a pad turns the object as a stiff damped spring
//! would that slips at the greatest torque. Its torque acts in the next step, and against the finger as well.

use std::collections::BTreeMap;

use geometry::DVec3;
use rapier3d_f64::prelude::{ColliderHandle, PhysicsWorld, RigidBodyHandle};
use robot::export::contact::TORSIONAL_FRICTION_M;

/// Share of the turning that remains after a step and that each pad removes in the next one. Both pads together must
/// take less than all of it, or the object would swing back.
const DAMPED_SHARE: f64 = 0.4;
/// Growth of the holding torque, as a share of the torque that would have stopped the turning in one step. Less than
/// the damping, or the object would swing for long.
const HELD_SHARE: f64 = 0.2;

/// The torques with which pads keep what they press on from turning.
#[derive(Default)]
pub(super) struct PadTorsion {
    /// Of each pad and the body that it presses on: the holding torque about the contact normal, newton meters.
    held_n_m: BTreeMap<(usize, usize), f64>,
}

/// Interaction of a pad and a body.
struct Press {
    /// Unit, from the pad to the body.
    normal: DVec3,
    /// The greatest torque about it, newton meters.
    greatest_n_m: f64,
}

impl PadTorsion {
    /// Sets the torques for the next step, from the contacts of the last one. All other torques from outside are lost.
    pub fn resist(
        &mut self,
        world: &mut PhysicsWorld,
        pads: &[(RigidBodyHandle, ColliderHandle)],
        objects: &[RigidBodyHandle],
    ) {
        let step_s = world.integration_parameters.dt;
        for handle in pads.iter().map(|(finger, _)| finger).chain(objects) {
            world.bodies[*handle].reset_torques(false);
        }
        let mut held_n_m = BTreeMap::new();
        for (pad, &(finger, collider)) in pads.iter().enumerate() {
            for (index, &object) in objects.iter().enumerate() {
                if !world.bodies[object].is_dynamic() {
                    continue;
                }
                let Some(press) = press(world, collider, object, step_s) else { continue };
                let (body, link) = (&world.bodies[object], &world.bodies[finger]);
                let spin_rad_s = (body.angvel() - link.angvel()).dot(press.normal);
                let yielding = body.mass_properties().effective_world_inv_inertia * press.normal;
                // What stops the turning of a body that nothing else holds, in one step.
                let stopping_n_m = -spin_rad_s / (yielding.dot(press.normal) * step_s);
                let bound = |torque_n_m: f64| torque_n_m.clamp(-press.greatest_n_m, press.greatest_n_m);
                let before = self.held_n_m.get(&(pad, index)).copied().unwrap_or(0.0);
                let held = bound(before + HELD_SHARE * stopping_n_m);
                let torque = bound(held + DAMPED_SHARE * stopping_n_m) * press.normal;
                world.bodies[object].add_torque(torque, false);
                world.bodies[finger].add_torque(-torque, false);
                held_n_m.insert((pad, index), held);
            }
        }
        self.held_n_m = held_n_m;
    }
}

/// Pressure of a pad on a body; `None` if they do not press.
fn press(world: &PhysicsWorld, pad: ColliderHandle, object: RigidBodyHandle, step_s: f64) -> Option<Press> {
    let (mut pressing, mut normal_n) = (DVec3::ZERO, 0.0);
    // Impulses of the last iteration; what the points do against turning cancels out in the sum.
    let (mut sliding, mut bearable) = (DVec3::ZERO, 0.0);
    for &other in world.bodies[object].colliders() {
        let Some(pair) = world.narrow_phase.contact_pair(pad, other) else { continue };
        let side = if pair.collider1 == pad { 1.0 } else { -1.0 };
        for manifold in pair.manifolds() {
            for point in manifold.points.iter().map(|point| &point.data).filter(|point| point.impulse > 0.0) {
                let force_n = point.impulse / step_s;
                pressing += side * force_n * manifold.data.normal;
                normal_n += force_n;
                sliding += side * point.warmstart_tangent_world;
                bearable += manifold.data.friction * point.warmstart_impulse;
            }
        }
    }
    let normal = pressing.try_normalize()?;
    let share = if bearable > 0.0 { (sliding.length() / bearable).min(1.0) } else { 1.0 };
    Some(Press { normal, greatest_n_m: TORSIONAL_FRICTION_M * normal_n * (1.0 - share * share).sqrt() })
}
