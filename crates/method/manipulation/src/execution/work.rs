//! Requirements of the steps of a goal: places for objects, and a place for the base.

use geometry::Pose;
use nalgebra::Isometry3;
use robot::model::Robot;
use tasks::{Goal, GoalPredicate, PosedObject};

use super::GraspBook;
use super::base::{Alternatives, bases, tool_poses};
use super::place::PlaceSearch;
use super::release::ReleaseTrials;
use super::scene::{Shapes, TaskScene};
use super::settings::ExecutionSettings;
use super::steps::{Step, steps};

/// Poses at which the object of a step may be put down.
#[expect(clippy::too_many_arguments, reason = "the state of an attempt, also before there is one")]
pub(crate) fn places(
    scene: &TaskScene,
    shapes: &Shapes,
    start: &[PosedObject],
    now: &[PosedObject],
    object: usize,
    step: &Step,
    done: &[GoalPredicate],
    settings: &ExecutionSettings,
) -> Vec<Pose> {
    let poses: Vec<Pose> = now.iter().map(|object| object.world_from_object).collect();
    let trials = ReleaseTrials::new(scene, shapes, start, &poses, object, step.predicates(), done);
    let search = PlaceSearch {
        outline: &scene.outline,
        shapes,
        table: shapes.posed_table(scene),
        start,
        now,
        object,
        wanted: settings.max_places,
        trials: &trials,
    };
    match step {
        Step::Place { predicates, .. } => search.places(predicates, done),
        Step::SetAside { object: name, other } => {
            let taken = [name, other].into_iter().filter_map(|name| tasks::posed_object::find(start, name));
            search.free_places(&taken.collect::<Vec<_>>())
        }
        Step::TakePlaceOf { other, .. } => {
            tasks::posed_object::find(start, other).map_or_else(Vec::new, |other| search.place_of(other))
        }
        Step::Lift { .. } => Vec::new(),
    }
}

/// Places for the base from which the arm can pick up all that a goal moves, and put it down, as [`bases`] orders them.
pub(crate) fn bases_for<'a>(
    scene: &'a TaskScene,
    shapes: &Shapes,
    robot: &'a Robot,
    goal: &Goal,
    grasps: &GraspBook,
    settings: &'a ExecutionSettings,
) -> impl Iterator<Item = Isometry3<f64>> + 'a {
    bases(scene, robot, work_of(scene, shapes, goal, grasps, settings), settings)
}

/// Tool poses for each step of a goal: at the grasps of its object, and at its places. Each step begins as if the
/// earlier ones had put their objects to the first of their places.
fn work_of(
    scene: &TaskScene,
    shapes: &Shapes,
    goal: &Goal,
    grasps: &GraspBook,
    settings: &ExecutionSettings,
) -> Vec<Alternatives> {
    let start = shapes.posed(&scene.poses());
    let mut now = start.clone();
    let (mut work, mut done) = (Vec::new(), Vec::new());
    for step in steps(goal) {
        let name = step.object().as_str();
        let (Some(object), Some(grasps)) = (scene.index(name), grasps.get(name)) else { continue };
        work.push(tool_poses(&[now[object].world_from_object], grasps));
        let places = places(scene, shapes, &start, &now, object, &step, &done, settings);
        if let Some(place) = places.first() {
            work.push(tool_poses(&places, grasps));
            now[object] = now[object].at(*place);
        }
        if let Step::Place { predicates, .. } = step {
            done.extend(predicates);
        }
    }
    work
}
