//! Test whether an arm can make the motions of a task, without a simulation.

use geometry::Pose;
use nalgebra::Isometry3;
use robot::model::Robot;
use scene::InstanceId;
use tasks::{
    Goal, GoalPredicate, PosedObject, PredicateKind, Situation, Task, evaluation::evaluate_predicate,
};

use super::attempt::{held_as, max_fall_m};
use super::motions::Motions;
use super::release::ReleaseTrials;
use super::scene::{SceneError, Shapes, TaskScene};
use super::settings::ExecutionSettings;
use super::steps::{Step, steps};
use super::work::{bases_for, places};
use super::{GraspBook, base, refusal};
use crate::grasp::{Grasp, Verdict};

/// Rehearses tasks in one scene with one robot: each step with the straight motions of its grasp and its place, as if
/// objects came to rest exactly where they are put. The motions between them are not planned, and nothing is simulated
/// but what becomes of an object that is let go.
pub struct Rehearsal<'a> {
    scene: &'a TaskScene,
    shapes: Shapes,
    robot: &'a Robot,
    settings: &'a ExecutionSettings,
}

impl<'a> Rehearsal<'a> {
    /// # Errors
    /// If an object has a hull that is not convex.
    pub fn new(
        scene: &'a TaskScene,
        robot: &'a Robot,
        settings: &'a ExecutionSettings,
    ) -> Result<Self, SceneError> {
        let shapes = Shapes::new(scene)?;
        Ok(Self { scene, shapes, robot, settings })
    }

    /// Whether the arm can pick an object up where it is, with one of these grasps and from some place of its base: a
    /// stable grasp is free of table and neighbors on the way to the object and up with it, and the arm makes both
    /// motions.
    pub fn can_be_picked(&self, object: &InstanceId, grasps: &[Grasp]) -> bool {
        let lifted = GoalPredicate {
            predicate: PredicateKind::Lifted,
            object: object.clone(),
            target: None,
            second_target: None,
        };
        let book = GraspBook::from([(object.to_string(), grasps.to_vec())]);
        let goal = Goal::new([lifted]);
        goal.is_ok_and(|goal| self.can_be_done(&Task::new("", goal, self.robot.name()), &book))
    }

    /// Whether the arm can make all steps of a task from one place of its base, with grasps of what the task moves.
    pub fn can_be_done(&self, task: &Task, grasps: &GraspBook) -> bool {
        let (scene, robot, settings) = (self.scene, self.robot, self.settings);
        let refused = refusal::check(scene, &self.shapes, robot, &task.goal, grasps, settings).is_err();
        !refused && self.base_for(task, grasps).is_some()
    }

    /// The best place for the base from which the arm can make all steps of a task: `world_from_base`.
    pub fn base_for(&self, task: &Task, grasps: &GraspBook) -> Option<Isometry3<f64>> {
        let (scene, shapes, robot, settings) = (self.scene, &self.shapes, self.robot, self.settings);
        bases_for(scene, shapes, robot, &task.goal, grasps, settings).find(|base| {
            let motions = Motions::new(scene, robot, *base, settings);
            motions.is_ok_and(|motions| {
                base::reaches_table(&motions) && is_rehearsed(&motions, shapes, task, grasps)
            })
        })
    }
}

/// Whether the arm at its place reaches and leaves a grasp and a place for each step of a task.
pub(crate) fn is_rehearsed(motions: &Motions, shapes: &Shapes, task: &Task, grasps: &GraspBook) -> bool {
    let mut poses = motions.scene.poses();
    let mut state = Rehearsed {
        start: shapes.posed(&poses),
        arm: motions.robot.home().positions.clone(),
        done: Vec::new(),
    };
    steps(&task.goal).iter().all(|step| state.make(step, motions, shapes, &mut poses, grasps).is_some())
}

/// State that a rehearsal has reached.
struct Rehearsed {
    start: Vec<PosedObject>,
    /// The positions of the arm's joints.
    arm: Vec<f64>,
    /// Predicates that steps have brought about.
    done: Vec<GoalPredicate>,
}

impl Rehearsed {
    /// Makes a step, as if the object came to rest exactly where it is put. `None` if it has no grasp or no place that
    /// the arm reaches and leaves.
    fn make(
        &mut self,
        step: &Step,
        motions: &Motions,
        shapes: &Shapes,
        poses: &mut [Pose],
        grasps: &GraspBook,
    ) -> Option<()> {
        let scene = motions.scene;
        let now = shapes.posed(poses);
        let situation = Situation { table: &scene.outline, start: &self.start, now: &now, contacts: &[] };
        let holds = |predicate| evaluate_predicate(predicate, &situation).holds;
        if matches!(step, Step::Place { predicates, .. } if predicates.iter().all(holds)) {
            return Some(());
        }
        let name = step.object().as_str();
        let object = scene.index(name)?;
        let stable = grasps.get(name)?.iter().filter(|grasp| grasp.verdict == Verdict::Stable);
        let stable: Vec<Grasp> = stable.copied().collect();
        let picks = motions.picks(object, poses, &stable, &self.arm);
        if matches!(step, Step::Lift { .. }) {
            self.arm.clone_from(picks.first()?.lift.last()?);
            return Some(());
        }
        let (start, done) = (&self.start, &self.done);
        let offered = places(scene, shapes, start, &now, object, step, done, motions.settings);
        let neighbors = motions.neighbors(object, poses);
        let trials = ReleaseTrials::new(scene, shapes, start, poses, object, step.predicates(), done);
        let (place, retreat) = picks.iter().find_map(|pick| {
            let held = held_as(object, &pick.grasp);
            let near = pick.lift.last()?;
            offered.iter().find_map(|place: &Pose| {
                let option = motions.place(&held, place, &neighbors, near, max_fall_m(step))?;
                trials.succeeds(&option.released).then_some((*place, option.retreat))
            })
        })?;
        poses[object] = place;
        self.arm.clone_from(retreat.last()?);
        if let Step::Place { predicates, .. } = step {
            self.done.extend(predicates.iter().cloned());
        }
        Some(())
    }
}
