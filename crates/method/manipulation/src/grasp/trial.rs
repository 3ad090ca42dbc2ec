//! A grasp in simulation: close, lift, shake, hold.

use geometry::{DVec3, Friction, MassProperties, Pose};
use nalgebra::Isometry3;
use physics::Body;
use robot::model::Robot;

use super::settings::TrialSettings;
use super::{Grasp, Verdict};
use crate::frames::to_isometry;
use crate::world::{ManipulationWorld, WorldError, WorldOptions};

/// A finger holds an object if it presses with at least this share of the gripper's force.
const HOLDING_SHARE: f64 = 0.3;
/// The share of the usual force that is tried where that squeezes an object out of the hand.
const GENTLE_SHARE: f64 = 0.1;
/// The share that is tried where an object is held and yet moves: soft contacts creep less under it.
const EASY_SHARE: f64 = 0.3;
/// The grip is given this time after the fingers have closed, seconds.
const SETTLE_S: f64 = 0.15;
/// Fingers that press gently are slow; they get this much longer than their speed asks for, seconds.
const MAX_CLOSING_S: f64 = 0.8;

/// Result of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrialResult {
    pub verdict: Verdict,
    pub slip_m: f64,
    pub turn_rad: f64,
    /// Distance of the pads from each other when they had closed on the object; `None` if they did not hold it.
    pub opening_m: Option<f64>,
    /// The force of each pad.
    pub force_n: f64,
}

/// Tries a grasp with the usual force of the gripper; where that does not hold the object still, with the greatest; and
/// where the fingers did not even get hold of it, gently. See [`try_grasp_with`]. The result names the force.
///
/// # Errors
/// If the object cannot be simulated.
pub fn try_grasp(
    object: &Body,
    robot: &Robot,
    grasp: &Grasp,
    settings: &TrialSettings,
    options: &WorldOptions,
) -> Result<TrialResult, WorldError> {
    let gripper = robot.gripper();
    let usual = try_grasp_with(object, robot, grasp, gripper.grip_force_n, settings, options)?;
    if usual.verdict == Verdict::Stable {
        return Ok(usual);
    }
    let other_n = match usual.opening_m {
        Some(_) => gripper.max_force_n,
        None => GENTLE_SHARE * gripper.grip_force_n,
    };
    let other = try_grasp_with(object, robot, grasp, other_n, settings, options)?;
    Ok(if other.verdict == Verdict::Stable { other } else { usual })
}

/// Tries a grasp with less than the usual force of the gripper. See [`try_grasp_with`].
///
/// # Errors
/// If the object cannot be simulated.
pub fn try_grasp_gently(
    object: &Body,
    robot: &Robot,
    grasp: &Grasp,
    settings: &TrialSettings,
    options: &WorldOptions,
) -> Result<TrialResult, WorldError> {
    try_grasp_with(object, robot, grasp, EASY_SHARE * robot.gripper().grip_force_n, settings, options)
}

/// Tries a grasp with the gripper of `robot` and no arm, each pad pressing with `force_n`. The object stands on a
/// table as its pose says; the hand starts at the grasp, opened.
///
/// # Errors
/// If the object cannot be simulated.
pub fn try_grasp_with(
    object: &Body,
    robot: &Robot,
    grasp: &Grasp,
    force_n: f64,
    settings: &TrialSettings,
    options: &WorldOptions,
) -> Result<TrialResult, WorldError> {
    let world_from_tool = object.world_from_object * grasp.object_from_tool;
    let place: Isometry3<f64> = to_isometry(&world_from_tool);
    let objects = [table_below(object), object.clone()];
    let mut world = ManipulationWorld::with_hand(&objects, robot, &place, grasp.pregrasp_opening_m, options)?;
    world.set_gripper(0.0, settings.closing_speed_m_s, force_n);
    let way_m = 0.5 * (grasp.pregrasp_opening_m - grasp.opening_m).max(0.0) + 0.005;
    let holds = |world: &ManipulationWorld| world.finger_forces(1).hold(HOLDING_SHARE * force_n);
    let end_s = way_m / settings.closing_speed_m_s + MAX_CLOSING_S;
    while world.time_s() < end_s && !holds(&world) {
        world.step();
    }
    world.simulate(SETTLE_S);
    if !holds(&world) {
        return Ok(TrialResult {
            verdict: Verdict::Dropped,
            slip_m: 0.0,
            turn_rad: 0.0,
            opening_m: None,
            force_n,
        });
    }
    let opening_m = Some(world.opening_m());
    let gripped = in_hand(&world);
    // The point of the object that is at the origin of the tool.
    let point = gripped.inverse().transform_point(DVec3::ZERO);
    lift(&mut world, settings);
    let lifted = in_hand(&world).transform_point(point);
    let mut slip_m = 0.0_f64;
    let mut turn_rad = 0.0_f64;
    let end_s = settings.shake_s + settings.hold_s;
    let begin_s = world.time_s();
    while world.time_s() - begin_s < end_s {
        let time_s = world.time_s() - begin_s + 1.0 / options.steps_per_s;
        let (shift, rate) = shaken(settings, time_s);
        let base = DVec3::new(0.0, 0.0, settings.lift_m);
        world.set_joint_targets(&(base + shift).to_array(), &rate.to_array());
        world.step();
        let now = in_hand(&world);
        slip_m = slip_m.max(now.transform_point(point).distance(lifted));
        turn_rad = turn_rad.max(now.rotation.angle_between(gripped.rotation));
        if slip_m > 0.05 {
            break;
        }
    }
    let verdict = if !holds(&world) || slip_m > 0.05 {
        Verdict::Dropped
    } else if slip_m <= settings.max_slip_m && turn_rad <= settings.max_turn_rad {
        Verdict::Stable
    } else {
        Verdict::Slipped
    };
    Ok(TrialResult { verdict, slip_m, turn_rad, opening_m, force_n })
}

/// `tool_from_object`.
fn in_hand(world: &ManipulationWorld) -> Pose {
    world.tool_pose().inverse() * world.object_pose(1)
}

/// Raises the hand smoothly.
fn lift(world: &mut ManipulationWorld, settings: &TrialSettings) {
    let steps = (settings.lift_s * world.options().steps_per_s).round().max(1.0) as usize;
    for step in 1..=steps {
        let share = step as f64 / steps as f64;
        let (at, rate) = (share * share * (3.0 - 2.0 * share), 6.0 * share * (1.0 - share));
        let rate_m_s = settings.lift_m * rate / settings.lift_s;
        world.set_joint_targets(&[0.0, 0.0, settings.lift_m * at], &[0.0, 0.0, rate_m_s]);
        world.step();
    }
}

/// The place and velocity of the hand: each axis at another phase, begun and ended softly.
fn shaken(settings: &TrialSettings, time_s: f64) -> (DVec3, DVec3) {
    let pace = std::f64::consts::TAU * settings.shake_hz;
    let place = |time_s: f64| {
        let ramp =
            (4.0 * time_s / settings.shake_s).min(4.0 - 4.0 * time_s / settings.shake_s).clamp(0.0, 1.0);
        let soft = ramp * ramp * (3.0 - 2.0 * ramp);
        let phase = pace * time_s;
        settings.shake_m
            * soft
            * DVec3::new(
                phase.sin(),
                (phase + 1.0).sin() - 1.0_f64.sin(),
                (phase + 2.0).sin() - 2.0_f64.sin(),
            )
    };
    let step_s = 1e-4;
    (place(time_s), (place(time_s + step_s) - place(time_s - step_s)) / (2.0 * step_s))
}

/// A table under the lowest point of an object.
fn table_below(object: &Body) -> Body {
    let lowest_m = object
        .hulls
        .iter()
        .flat_map(|hull| &hull.points)
        .map(|p| object.world_from_object.transform_point(*p).z)
        .fold(f64::INFINITY, f64::min);
    let corners = geometry::shapes::block(DVec3::new(2.0, 2.0, 0.05));
    let hull = geometry::ConvexHull { points: corners.positions, triangles: corners.triangles };
    let below = DVec3::new(
        object.world_from_object.translation_m.x,
        object.world_from_object.translation_m.y,
        lowest_m - 0.05,
    );
    Body {
        name: "table".to_owned(),
        hulls: vec![hull],
        world_from_object: Pose::upright(below, 0.0),
        mass: MassProperties {
            mass_kg: 1.0,
            center_of_mass_m: DVec3::ZERO,
            inertia_diagonal_kg_m2: DVec3::ONE,
            principal_axes_xyzw: geometry::DQuat::IDENTITY,
        },
        friction: Friction { static_coefficient: 0.5, dynamic_coefficient: 0.5 },
        restitution: 0.0,
        rolling_friction_m: 0.0,
        fixed: true,
    }
}
