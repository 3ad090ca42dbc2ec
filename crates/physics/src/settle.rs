//! Bodies under gravity until they rest, or for a given time.
//!
//! Rapier (f64, sleeping off): each body is the set of its convex hulls with explicit mass, center of mass
//! and inertia; contacts of our own ([`super::contacts`]); Coulomb friction; implicit time stepping with
//! small steps. Lengths are declared to be those of household things (`length_unit_m`), since the engine's
//! tolerances are made for things of a meter. Rolling and spinning resistance, which the engine lacks, are
//! added as dry friction after each step. Bodies that cannot meet are simulated apart and in parallel
//! ([`mod@islands`]).
//!
//! Guarantees: same input, same bytes, with any number of threads.

mod islands;
mod world;

use serde::{Deserialize, Serialize};

use super::Body;
use geometry::Pose;
use geometry::collision_shape::BrokenHull;
use runtime::{Interrupt, Interrupted};

/// Section `[settle]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct SettleSettings {
    /// Longest simulated time, seconds, 0.1..60.
    pub duration_s: f64,
    /// Steps per simulated second, 120..2000. More: less penetration, more time.
    pub steps_per_s: f64,
    /// Solver iterations per step, 1..50. More: stiffer stacks.
    pub solver_iterations: usize,
    /// Natural frequency of contacts, hertz, 10..500. More: stiffer. At most a
    /// quarter of steps times iterations, or stacks buzz.
    pub contact_frequency_hz: f64,
    /// Typical size of things, meters, 0.01..1: scales the engine's tolerances.
    pub length_unit_m: f64,
    /// Damping of linear and angular velocity of everything, 1/s, 0..1.
    pub damping_per_s: f64,
    /// Speed under which a body counts as resting, m/s (a point at its edge).
    pub rest_speed_m_s: f64,
    /// All must rest this long before the simulation may end early, seconds.
    pub rest_time_s: f64,
}

/// Where everything ended up, in the order of the bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct Settled {
    /// `world_from_object`.
    pub poses: Vec<Pose>,
    /// Distance each origin moved, meters.
    pub displacements_m: Vec<f64>,
    /// Angle each body turned by, radians.
    pub rotations_rad: Vec<f64>,
    /// Whether everything rested at the end.
    pub at_rest: bool,
    /// Simulated time, seconds.
    pub simulated_s: f64,
}

/// Why bodies could not be simulated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettleError {
    #[error("settling {name}: {source}")]
    BrokenHull { name: String, source: BrokenHull },
    #[error("settling {name}: its mass or inertia is not positive; compute its mass properties again")]
    BadMass { name: String },
    #[error("settling {name}: the simulation diverged; it starts too deep inside another object")]
    Diverged { name: String },
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Simulates until everything rests, at most `duration_s`.
pub fn settle(
    bodies: &[Body],
    settings: &SettleSettings,
    interrupt: &Interrupt,
) -> Result<Settled, SettleError> {
    islands::simulate(bodies, settings, true, interrupt)
}

/// Simulates `duration_s` to the end; an island whose drift can no longer matter is taken to stay (it is
/// watched over a quarter of a second, and ten times its drift may not add up to a tenth of a millimeter).
pub fn simulate_to_the_end(
    bodies: &[Body],
    settings: &SettleSettings,
    interrupt: &Interrupt,
) -> Result<Settled, SettleError> {
    islands::simulate(bodies, settings, false, interrupt)
}

/// Angle of the rotation that takes one pose's axes to the other's, radians in 0..pi.
pub fn angle_between_rad(a: &Pose, b: &Pose) -> f64 {
    let q = a.rotation.conjugate() * b.rotation;
    2.0 * q.xyz().length().atan2(q.w.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_bodies::{body, settle_settings as settings, table};
    use geometry::shapes::{block, sphere};
    use glam::DQuat;
    use glam::DVec3;

    fn at(x: f64, y: f64, z: f64) -> Pose {
        Pose::upright(DVec3::new(x, y, z), 0.4)
    }

    #[test]
    fn a_cube_falls_a_centimeter_and_stays() {
        let bodies = [table(), body("cube", block(DVec3::splat(0.05)), at(0.1, 0.0, 0.01))];
        let settled = settle(&bodies, &settings(), &Interrupt::default()).expect("a cube");
        assert!(settled.at_rest && settled.simulated_s < 2.0);
        assert!(settled.poses[1].translation_m.z.abs() < 2e-4, "{:?}", settled.poses[1]);
        assert!((settled.displacements_m[1] - 0.01).abs() < 1e-3 && settled.rotations_rad[1] < 0.01);
        assert_eq!(settled.poses[0], Pose::IDENTITY);
    }

    #[test]
    fn a_stack_of_six_does_not_creep_in_five_seconds() {
        let mut bodies = vec![table()];
        for k in 0..6 {
            bodies.push(body(
                &format!("cube_{k}"),
                block(DVec3::new(0.05, 0.04, 0.03)),
                at(0.0, 0.0, 0.03 * f64::from(k)),
            ));
        }
        let settled = simulate_to_the_end(&bodies, &settings(), &Interrupt::default()).expect("a stack");
        for k in 1..7 {
            assert!(settled.displacements_m[k] < 5e-4, "{k} moved {}", settled.displacements_m[k]);
            assert!(settled.rotations_rad[k] < 2e-3);
        }
        assert!(settled.at_rest);
    }

    #[test]
    fn a_slope_holds_below_the_friction_angle_and_not_above() {
        for (slope_rad, holds) in [(0.3, true), (0.5, false)] {
            let tilt = DQuat::from_rotation_y(slope_rad);
            let mut table = table();
            table.world_from_object = Pose { translation_m: DVec3::ZERO, rotation: tilt };
            let pose = Pose { translation_m: DVec3::ZERO, rotation: tilt };
            let bodies = [table, body("slab", block(DVec3::new(0.08, 0.08, 0.01)), pose)];
            let short = SettleSettings { duration_s: 2.0, ..settings() };
            let settled = simulate_to_the_end(&bodies, &short, &Interrupt::default()).expect("a slab");
            assert_eq!(settled.displacements_m[1] < 0.001, holds, "{}", settled.displacements_m[1]);
        }
    }

    #[test]
    fn a_body_off_the_table_falls_and_is_not_at_rest() {
        let bodies = [table(), body("ball", sphere(0.03, 24), at(1.5, 0.0, 0.0))];
        let settled = settle(&bodies, &settings(), &Interrupt::default()).expect("a ball");
        assert!(!settled.at_rest && settled.displacements_m[1] > 10.0);
    }

    #[test]
    fn the_same_bytes_twice_and_an_interrupt_is_heard() {
        let bodies = [table(), body("ball", sphere(0.03, 24), at(0.0, 0.0, 0.02))];
        let once = settle(&bodies, &settings(), &Interrupt::default()).expect("a ball");
        assert_eq!(once, settle(&bodies, &settings(), &Interrupt::default()).expect("a ball"));
        let interrupt = Interrupt::default();
        interrupt.raise();
        assert!(matches!(settle(&bodies, &settings(), &interrupt), Err(SettleError::Interrupted(_))));
        let mut massless = bodies.clone();
        massless[1].mass.mass_kg = 0.0;
        let refused = settle(&massless, &settings(), &Interrupt::default());
        assert_eq!(refused, Err(SettleError::BadMass { name: "ball".into() }));
    }
}
