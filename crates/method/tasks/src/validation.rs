//! Checks of a task before anything is simulated.
//!
//! In this order, the cheapest first: the robot and the objects exist; the predicates can be decided; they do not
//! contradict each other; the goal is not reached already; the robot can grasp and lift what it moves; and there is a
//! free place where each object meets its predicates ([`end_state`]). A tenth of a second, and seconds where a
//! crowded table has to be searched to the end.

mod conflicts;
mod end_state;
mod free_spot;

pub use end_state::end_state;
use end_state::end_state_with;
use free_spot::{AMPLE_SPACE_M, NO_SPACE_M};

use scene::InstanceId;
use scene::text_account::{GoalPredicate, PredicateKind};

use crate::evaluation::{Reason, evaluate, is_decidable};
use crate::goal::{Goal, formula, name_of, named};
use crate::posed_object::PosedObject;
use crate::refusal::Refusal;
use crate::robot_limits::{GraspWidth, RobotLimits};
use crate::task::Task;
use crate::task_scene::TaskScene;

/// Checks a task in a scene, for one of these robots.
///
/// # Errors
///
/// The first [`Refusal`], in the order above.
pub fn validate(task: &Task, scene: &TaskScene, robots: &[RobotLimits]) -> Result<(), Refusal> {
    checked(task, scene, robots, NO_SPACE_M)
}

/// As [`validate`], and there is ample space beside each place, so that the search is short.
///
/// # Errors
///
/// As for [`validate`].
pub(crate) fn validate_spacious(task: &Task, scene: &TaskScene, robot: &RobotLimits) -> Result<(), Refusal> {
    checked(task, scene, std::slice::from_ref(robot), AMPLE_SPACE_M)
}

fn checked(task: &Task, scene: &TaskScene, robots: &[RobotLimits], space_m: f64) -> Result<(), Refusal> {
    let Some(robot) = robots.iter().find(|robot| robot.name == task.robot) else {
        let known = robots.iter().map(|robot| robot.name.clone()).collect();
        return Err(Refusal::UnknownRobot { robot: task.robot.clone(), known });
    };
    require_objects(&task.goal, scene)?;
    require_decidable(&task.goal, scene)?;
    conflicts::require_compatible(&task.goal)?;
    require_open(&task.goal, scene)?;
    for name in grasped_objects(&task.goal) {
        if let Some(object) = scene.index_of(name) {
            require_movable(object, scene, robot)?;
        }
    }
    end_state_with(&task.goal, scene, space_m).map(|_| ())
}

/// Whether a goal has places with ample space.
pub(crate) fn is_spacious(goal: &Goal, scene: &TaskScene) -> bool {
    end_state_with(goal, scene, AMPLE_SPACE_M).is_ok()
}

/// Every object of the goal is in the scene.
fn require_objects(goal: &Goal, scene: &TaskScene) -> Result<(), Refusal> {
    match goal.named_objects().into_iter().find(|name| scene.index_of(name).is_none()) {
        None => Ok(()),
        Some(absent) => {
            let stem =
                |name: &InstanceId| name.as_str().trim_end_matches(|c: char| c.is_ascii_digit()).to_owned();
            let names = || scene.posed().iter().map(|object| object.name.clone());
            let alike: Vec<InstanceId> = names().filter(|name| stem(name) == stem(absent)).collect();
            let candidates = if alike.is_empty() { names().collect() } else { alike };
            Err(Refusal::AbsentObject { phrase: absent.to_string(), candidates })
        }
    }
}

/// Poses and contacts decide every predicate of the goal.
fn require_decidable(goal: &Goal, scene: &TaskScene) -> Result<(), Refusal> {
    for (predicate, outcome) in goal.predicates().iter().zip(evaluate(goal, &scene.situation())) {
        match outcome.reason {
            Reason::NoOpening => {
                let target = predicate.target.as_ref().unwrap_or(&predicate.object);
                return Err(Refusal::NotAContainer { object: target.clone() });
            }
            Reason::NotDecidable => {
                return Err(Refusal::PredicateNotSupported { predicate: formula(predicate) });
            }
            _ if !is_decidable(predicate.predicate) => {
                return Err(Refusal::PredicateNotSupported { predicate: formula(predicate) });
            }
            _ => {}
        }
    }
    Ok(())
}

/// The goal is not reached at the start.
fn require_open(goal: &Goal, scene: &TaskScene) -> Result<(), Refusal> {
    let outcomes = evaluate(goal, &scene.situation());
    if outcomes.iter().all(|outcome| outcome.holds) {
        let predicates = goal.predicates().iter().map(formula).collect();
        return Err(Refusal::GoalAlreadyTrue { predicates });
    }
    Ok(())
}

/// The objects that the robot grasps: those that it moves, but not those that it pushes, opens or closes.
pub fn grasped_objects(goal: &Goal) -> Vec<&InstanceId> {
    use PredicateKind::{AwayFrom, Closed, Moved, Opened, Rotated};
    let is_grasped = |predicate: &&GoalPredicate| {
        !matches!(predicate.predicate, AwayFrom | Closed | Moved | Opened | Rotated)
    };
    let grasped: Vec<&InstanceId> = goal.predicates().iter().filter(is_grasped).flat_map(named).collect();
    goal.moved_objects().into_iter().filter(|name| grasped.contains(name)).collect()
}

/// The robot can grasp the object, and lift it with what rests on or in it. Where grasps were tried, they decide.
///
/// # Errors
///
/// [`Refusal::NotGraspable`], [`Refusal::ObjectTooHeavy`], [`Refusal::ObjectTooWide`] or [`Refusal::NoGraspHeld`].
pub fn require_movable(object: usize, scene: &TaskScene, robot: &RobotLimits) -> Result<(), Refusal> {
    let PosedObject { name, shape, .. } = &scene.posed()[object];
    if !shape.is_graspable {
        return Err(Refusal::NotGraspable { object: name.clone() });
    }
    let mass_kg: f64 =
        scene.supports().branch(object).map(|member| scene.posed()[member].shape.mass_kg).sum();
    if mass_kg > robot.max_payload_kg {
        return Err(Refusal::ObjectTooHeavy {
            object: name.clone(),
            robot: robot.name.clone(),
            mass_kg,
            payload_kg: robot.max_payload_kg,
        });
    }
    let held = robot.held.get(name).copied();
    if held == Some(true) {
        return Ok(());
    }
    match shape.grasp_width(robot.max_width_m()) {
        GraspWidth::TooWide(width_m) => Err(Refusal::ObjectTooWide {
            object: name.clone(),
            robot: robot.name.clone(),
            width_m,
            opening_m: robot.max_opening_m,
            margin_m: robot.opening_margin_m,
        }),
        GraspWidth::Fits(_) if held == Some(false) => {
            Err(Refusal::NoGraspHeld { object: name.clone(), robot: robot.name.clone() })
        }
        GraspWidth::Fits(_) => Ok(()),
    }
}

/// The predicate in words, for messages.
fn in_words(predicate: &GoalPredicate) -> String {
    let mut words = format!("{} {}", predicate.object, name_of(predicate.predicate).replace('_', " "));
    for target in [&predicate.target, &predicate.second_target].into_iter().flatten() {
        words.push(' ');
        words.push_str(target.as_str());
    }
    words
}
