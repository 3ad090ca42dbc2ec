//! The simulation of one island.

use glam::DVec3;
use rapier3d_f64::prelude::{PhysicsWorld, RigidBodyHandle};

use super::{SettleError, SettleSettings, TRACK_HZ};
use crate::Body;
use crate::rigid_world::{ContactOptions, UnfitBody};
use crate::rolling::resist_rolling;
use geometry::Pose;
use geometry::collision_shape::from_parry;
use runtime::CancelFlag;

/// Contacts of moving bodies are predicted up to this distance, meters.
const LOOK_AHEAD_M: f64 = 0.02;

/// Length of the windows in which drift is watched, seconds.
const WINDOW_S: f64 = 0.25;

/// Bodies at rest are not simulated on when ten times the drift of the last window, kept up to the end,
/// would move no point of them by this much, meters: a three-hundredth of what counts as moving.
const DRIFT_TO_THE_END_M: f64 = 1e-4;

/// Outcome of a simulation.
#[derive(Clone, Debug)]
pub(super) struct Run {
    /// `world_from_object`, in the order of the bodies.
    pub poses: Vec<Pose>,
    /// Farthest that any point of a body got from where it started, at any time, meters.
    pub excursion_m: f64,
    pub at_rest: bool,
    pub simulated_s: f64,
    /// `world_from_object` of each body [`TRACK_HZ`] times a second, from the start on.
    pub track: Vec<Vec<Pose>>,
}

/// Simulates the bodies until all rest, or to the end. Bodies at permanent rest are not simulated further (see
/// [`DRIFT_TO_THE_END_M`]); a creeping pose is.
pub(super) fn run(
    bodies: &[&Body],
    settings: &SettleSettings,
    may_end_early: bool,
    cancel: &CancelFlag,
) -> Result<Run, SettleError> {
    let options = contact_options(settings);
    let mut world = options.empty_world();
    let handles = bodies
        .iter()
        .map(|body| options.insert(&mut world, body, |collider| collider))
        .collect::<Result<Vec<RigidBodyHandle>, UnfitBody>>()?;
    let reach_m: Vec<f64> = bodies.iter().map(|body| reach_m(body)).collect();
    let start: Vec<(DVec3, glam::DQuat)> = handles
        .iter()
        .map(|&h| (world.bodies[h].center_of_mass(), world.bodies[h].position().rotation))
        .collect();

    let steps = (settings.duration_s * settings.steps_per_s).round().max(1.0) as usize;
    let steps_at_rest = (settings.rest_time_s * settings.steps_per_s).round().max(1.0) as usize;
    let window = (WINDOW_S * settings.steps_per_s).round().max(1.0) as usize;
    let mut window_start = start.clone();
    let (mut rested, mut done, mut excursion_m) = (0, 0, 0.0_f64);
    let mut track: Vec<Vec<Pose>> = bodies.iter().map(|body| vec![body.world_from_object]).collect();
    let mut track_frames = 1_usize;
    while done < steps && !(may_end_early && rested >= steps_at_rest) {
        if done % 8 == 0 {
            cancel.check()?;
        }
        world.step();
        done += 1;
        resist_rolling(&mut world, bodies, &handles);
        let mut resting = true;
        for (k, &handle) in handles.iter().enumerate().filter(|&(k, _)| !bodies[k].fixed) {
            let moving = &world.bodies[handle];
            resting &=
                // Upper bound of the speed of the body's points.
                moving.linvel().length() + reach_m[k] * moving.angvel().length() < settings.rest_speed_m_s;
            // A rotation by an angle a moves a point at distance r by at most the chord 2 r sin(a / 2), and |xyz| is
            // sin(a / 2).
            let turned = start[k].1.conjugate() * moving.position().rotation;
            let way_m =
                (moving.center_of_mass() - start[k].0).length() + 2.0 * reach_m[k] * turned.xyz().length();
            excursion_m = excursion_m.max(way_m);
        }
        rested = if resting { rested + 1 } else { 0 };
        // The frame whose time this step is the first to reach.
        if done as f64 * TRACK_HZ >= track_frames as f64 * settings.steps_per_s {
            track_frames += 1;
            for (poses, &handle) in track.iter_mut().zip(&handles) {
                poses.push(from_parry(world.bodies[handle].position()));
            }
        }
        if done % window == 0 {
            let drift_m = drift_m(&world, &handles, &reach_m, &mut window_start);
            let windows_left = (steps - done) as f64 / window as f64;
            if rested >= window && 10.0 * drift_m * windows_left < DRIFT_TO_THE_END_M {
                break;
            }
        }
    }
    let poses = bodies
        .iter()
        .zip(&handles)
        .map(|(body, &handle)| {
            if body.fixed {
                return Ok(body.world_from_object);
            }
            let pose = from_parry(world.bodies[handle].position());
            if pose.translation_m.is_finite() && pose.rotation.is_finite() && excursion_m.is_finite() {
                Ok(pose)
            } else {
                Err(SettleError::Diverged { name: body.name.clone() })
            }
        })
        .collect::<Result<_, _>>()?;
    // A simulation shorter than the rest time ends at rest if it rested throughout.
    let at_rest = rested >= steps_at_rest.min(steps);
    Ok(Run { poses, excursion_m, at_rest, simulated_s: done as f64 / settings.steps_per_s, track })
}

/// Largest distance that a point of a body may have moved since the start of the window, which begins anew.
fn drift_m(
    world: &PhysicsWorld,
    handles: &[RigidBodyHandle],
    reach_m: &[f64],
    window_start: &mut [(DVec3, glam::DQuat)],
) -> f64 {
    let mut drift_m = 0.0_f64;
    for ((&handle, reach_m), start) in handles.iter().zip(reach_m).zip(window_start) {
        let moving = &world.bodies[handle];
        let (center, rotation) = (moving.center_of_mass(), moving.position().rotation);
        let turned = start.1.conjugate() * rotation;
        let way_m = (center - start.0).length() + 2.0 * reach_m * turned.xyz().length();
        // Not a number is not at rest.
        drift_m = if way_m <= drift_m { drift_m } else { way_m };
        *start = (center, rotation);
    }
    drift_m
}

/// Distance of the farthest corner from the center of mass.
pub(super) fn reach_m(body: &Body) -> f64 {
    let center = body.mass.center_of_mass_m;
    body.hulls.iter().flat_map(|h| &h.points).map(|p| (*p - center).length()).fold(0.0, f64::max)
}

fn contact_options(settings: &SettleSettings) -> ContactOptions {
    ContactOptions {
        steps_per_s: settings.steps_per_s,
        solver_iterations: settings.solver_iterations,
        contact_frequency_hz: settings.contact_frequency_hz,
        length_unit_m: settings.length_unit_m,
        damping_per_s: settings.damping_per_s,
        look_ahead_m: LOOK_AHEAD_M,
    }
}
