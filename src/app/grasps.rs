//! Objects in the scene of a bundle that a robot can grasp: one answer for tasks, executions and demonstrations.
//!
//! Grasps that held in simulation decide. A bundle that was made with the robot states them; for other bundles they are
//! tried where shapes alone would refuse an object, and before every execution.

use super::activity::{Watch, staged};
use crate::config::Config;
use crate::pipeline::task_scene::BundleScene;
use crate::problem::{Problem, ProblemType};
use manipulation::execution::{GraspBook, KnownGrasps, TaskScene};
use manipulation::grasp::{GraspSettings, grasps_of_file};
use manipulation::world::WorldError;
use robot::model::Robot;
use scene::InstanceId;
use tasks::validation::require_movable;
use tasks::{Refusal, RobotLimits};

/// The grasps of a scene with those that its bundle states for the robot.
pub fn known_grasps<'a>(
    bundle: &BundleScene,
    scene: &'a TaskScene,
    robot: &'a Robot,
    settings: &'a GraspSettings,
    seed: u64,
) -> KnownGrasps<'a> {
    let stated = bundle.scene.instances.iter().filter_map(|instance| {
        let file = instance.grasps.as_ref().filter(|file| file.robot == robot.name())?;
        Some((instance.name.to_string(), grasps_of_file(file)))
    });
    KnownGrasps::new(scene, robot, settings, seed).with(stated.collect::<GraspBook>())
}

/// Limits of the objects that the robot can take and lift, with the grasps that are known already.
///
/// # Errors
///
/// A [`Problem`] for an object that cannot be simulated.
pub fn limits(
    known: &mut KnownGrasps,
    bundle: &BundleScene,
    config: &Config,
) -> Result<RobotLimits, Problem> {
    let mut limits = config.execution.limits_of(known.robot(), &config.grasps);
    for instance in &bundle.scene.instances {
        if known.is_known(instance.name.as_str()) {
            note(&mut limits, &instance.name, known)?;
        }
    }
    Ok(limits)
}

/// Tries the grasps of an object and notes whether one held.
///
/// # Errors
///
/// A [`Problem`] for an object that cannot be simulated.
pub fn note(limits: &mut RobotLimits, object: &InstanceId, known: &mut KnownGrasps) -> Result<(), Problem> {
    let held = known.one_held(object.as_str()).map_err(broken)?;
    limits.held.insert(object.clone(), held);
    Ok(())
}

/// Tries the grasps of every object that its width alone would rule out, so that it does not. Those that are much too
/// wide have nothing to try and cost some ten milliseconds.
///
/// # Errors
///
/// A [`Problem`] for an object that cannot be simulated.
pub fn note_wide(
    limits: &mut RobotLimits,
    bundle: &BundleScene,
    known: &mut KnownGrasps,
    watch: Watch,
) -> Result<(), Problem> {
    for (index, object) in bundle.tasks.posed().iter().enumerate() {
        let refusal = require_movable(index, &bundle.tasks, limits);
        if matches!(refusal, Err(Refusal::ObjectTooWide { .. })) && !limits.held.contains_key(&object.name) {
            staged(watch, "grasps", Some(object.name.as_str()), || note(limits, &object.name, known))?;
        }
    }
    Ok(())
}

/// The problem of an object that cannot be simulated.
pub fn broken(error: WorldError) -> Problem {
    Problem::new(ProblemType::Conflict, "broken_scene", error.to_string())
}
