//! A task as a sequence of picks and places, planned and simulated.
//!
//! The base stands where the arm reaches all grasps and places best, or at a given pose. Each step starts from the
//! present poses of the objects. It chooses a grasp and a place whose straight motions the arm can make (approach,
//! lift, lower, retreat), plans the motions between them, and makes them in [`ManipulationWorld`]: servos with bounded
//! effort, and grips that hold by friction alone. After the lift the place is planned anew for the measured pose in the
//! hand. In the end the predicates of the goal decide from poses and contacts.
//!
//! World frame, SI units. Equal scenes, grasps, settings and random numbers give equal bytes.

mod attempt;
mod base;
mod fingers;
mod known_grasps;
mod leave;
mod motion_problems;
mod motions;
mod obstacles;
mod place;
mod reach;
mod record;
mod refusal;
mod rehearsal;
mod release;
mod runner;
mod scene;
mod settings;
mod steps;
mod transit;
mod verdict;
mod work;

use std::collections::BTreeMap;
use std::iter;

use geometry::Pose;
use nalgebra::Isometry3;
use rand::Rng;
use robot::model::Robot;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tasks::{Disturbance, PredicateOutcome, Task};

pub use base::check_base;
pub use known_grasps::KnownGrasps;
pub use motion_problems::{MotionProblem, NoProblem, PickAndPlace, PickAndPlaces};
pub use record::{Frame, Phase, Recording};
pub use refusal::Refusal;
pub use rehearsal::Rehearsal;
pub use scene::{SceneError, TaskScene};
pub use settings::ExecutionSettings;
pub use steps::{Step, steps};
pub use transit::FreePath;

use crate::frames::to_pose;
use crate::grasp::Grasp;
use crate::world::{ManipulationWorld, WorldOptions};
use attempt::Attempt;
use motions::Motions;
use runner::Runner;
use scene::Shapes;

/// Places for the base on each mount that are tried before a task has no path.
const BASES: usize = 6;
/// A task is attempted from so many of them before there is no path.
const ATTEMPTS: usize = 3;

/// The grasps of objects by their names, best first.
pub type GraspBook = BTreeMap<String, Vec<Grasp>>;

/// Initial state of the robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RobotStart {
    /// Pose of its base; chosen if absent.
    pub world_from_base: Option<Isometry3<f64>>,
    /// The joints of its arm; the home configuration if absent.
    pub joint_positions: Option<Vec<f64>>,
}

/// Result of an executed task.
#[derive(Clone, Debug, Serialize)]
pub struct Execution {
    pub robot: String,
    /// The variant of the robot's model.
    pub variant: Option<String>,
    pub world_from_base: Pose,
    pub succeeded: bool,
    /// Reason of the failure; null if the task succeeded.
    pub failure: Option<Failure>,
    /// Details of the failure, for people.
    pub detail: Option<String>,
    /// The verdicts about the goal's predicates at the end.
    pub predicates: Vec<PredicateOutcome>,
    /// Objects beside the goal that were moved too far.
    pub disturbed: Vec<Disturbance>,
    pub picks: Vec<PickReport>,
    pub duration_s: f64,
    pub recording: Recording,
}

/// Reason why a task failed. The names are stable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "ExecutionFailure", description = "Reason why a task failed.")]
pub enum Failure {
    /// No configuration of the arm reaches a grasp or a place.
    Unreachable,
    /// No grasp of an object is known to hold it, or the fingers did not get hold of it.
    NoGrasp,
    /// No free motion was found, or there is no free place.
    NoPath,
    /// The object moved in the hand, and the goal is not reached.
    Slipped,
    /// The hand lost the object.
    Dropped,
    /// All motions were made, and a predicate does not hold.
    GoalNotMet,
    /// The goal is reached, but other objects were moved.
    DisturbedOthers,
}

impl Failure {
    /// A short name for statistics and clients: that of files.
    pub fn code(self) -> &'static str {
        match self {
            Self::Unreachable => "unreachable",
            Self::NoGrasp => "no_grasp",
            Self::NoPath => "no_path",
            Self::Slipped => "slipped",
            Self::Dropped => "dropped",
            Self::GoalNotMet => "goal_not_met",
            Self::DisturbedOthers => "disturbed_others",
        }
    }
}

/// One object that was picked up.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(
    rename = "Pick",
    description = "An object that was picked up, its grasp, and how far it moved in the hand."
)]
pub struct PickReport {
    pub object: String,
    pub grasp: Grasp,
    /// Distance that the gripped point moved in the hand until it was let go, meters.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub slip_m: f64,
}

/// Executes a task. A task that fails is an [`Execution`] with its reason.
///
/// The base stands where it is given, or at the best place for it. Where a motion is not found from there, the places
/// that follow are rehearsed, and the task is attempted from those where the rehearsal finds its motions: nothing real
/// has moved before a place is chosen.
///
/// # Errors
/// If the task is not attempted; see [`Refusal`].
pub fn execute(
    scene: &TaskScene,
    robot: &Robot,
    task: &Task,
    grasps: &GraspBook,
    start: &RobotStart,
    settings: &ExecutionSettings,
    rng: &mut impl Rng,
) -> Result<Execution, Refusal> {
    let shapes = Shapes::new(scene)?;
    refusal::check(scene, &shapes, robot, &task.goal, grasps, settings)?;
    let bases: Box<dyn Iterator<Item = Isometry3<f64>>> = match start.world_from_base {
        Some(base) => Box::new(iter::once(base)),
        None => Box::new(work::bases_for(scene, &shapes, robot, &task.goal, grasps, settings)),
    };
    let mut first_failure: Option<Execution> = None;
    let mut attempts = 0;
    for base in bases {
        let motions = Motions::new(scene, robot, base, settings)?;
        let is_promising =
            || first_failure.is_none() || rehearsal::is_rehearsed(&motions, &shapes, task, grasps);
        if !base::reaches_table(&motions) || !is_promising() {
            continue;
        }
        let execution = attempt_from(&motions, &shapes, task, grasps, start, rng)?;
        attempts += 1;
        if !matches!(execution.failure, Some(Failure::Unreachable | Failure::NoPath)) {
            return Ok(execution);
        }
        first_failure.get_or_insert(execution);
        if attempts == ATTEMPTS {
            break;
        }
    }
    first_failure.ok_or(Refusal::TableOutOfReach)
}

/// Attempts a task once, with the base of the robot where `motions` have it.
fn attempt_from(
    motions: &Motions,
    shapes: &Shapes,
    task: &Task,
    grasps: &GraspBook,
    start: &RobotStart,
    rng: &mut impl Rng,
) -> Result<Execution, Refusal> {
    let (scene, robot) = (motions.scene, motions.robot);
    let positions = start.joint_positions.as_ref().unwrap_or(&robot.home().positions);
    let (bodies, opening_m, base) = (scene.bodies(), robot.home().opening_m, motions.world_from_base);
    let world =
        ManipulationWorld::new(&bodies, robot, &base, positions, opening_m, &WorldOptions::default())?;
    let runner = Runner::new(world, motions, motions.settings.record_hz);
    let mut attempt = Attempt::new(motions, shapes, task, grasps, runner);
    let failure = attempt.run(rng).err();
    Ok(attempt.finish(failure, to_pose(&base)))
}

#[cfg(test)]
mod tests;
