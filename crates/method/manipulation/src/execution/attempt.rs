//! One attempt at a task, from the first step to the verdict.

use geometry::{DVec3, Pose};
use rand::Rng;
use tasks::{
    Contact, GoalPredicate, PosedObject, PredicateKind, Situation, Task, evaluation::evaluate_predicate,
};

use super::leave::way_out;
use super::motions::{HeldObject, MotionFailure, Motions, PickOption, PlaceOption};
use super::record::Phase;
use super::release::ReleaseTrials;
use super::runner::Runner;
use super::scene::Shapes;
use super::steps::{Step, steps};
use super::work::places;
use super::{Failure, GraspBook, PickReport};
use crate::frames::to_isometry;
use crate::grasp::{Grasp, Verdict};

/// A finger holds if it presses with at least this share of the gripper's force.
const HOLDING_SHARE: f64 = 0.25;
/// Objects fall into openings by at most this, meters.
const MAX_FALL_M: f64 = 0.125;
/// Times that an object is reached for again when the fingers did not get hold of it.
const RETRIES: usize = 1;
/// After the fingers have closed or opened they rest for this time, seconds.
const SETTLE_S: f64 = 0.15;
/// The hand leaves by this more than the task asks, since servos do not stop exactly where they are asked to, meters.
const LEAVING_GAP_M: f64 = 0.001;
/// Fingers that press gently are slow; they get this much longer than their speed asks for, seconds.
const MAX_CLOSING_S: f64 = 0.8;

/// The state of an attempt.
pub(crate) struct Attempt<'a> {
    pub(super) motions: &'a Motions<'a>,
    pub(super) shapes: &'a Shapes,
    pub(super) task: &'a Task,
    grasps: &'a GraspBook,
    pub(super) runner: Runner<'a>,
    pub(super) start: Vec<PosedObject>,
    /// Predicates that steps have brought about.
    done: Vec<GoalPredicate>,
    pub(super) picks: Vec<PickReport>,
    /// Details of the failure, for people.
    pub(super) detail: Option<String>,
}

impl<'a> Attempt<'a> {
    pub fn new(
        motions: &'a Motions<'a>,
        shapes: &'a Shapes,
        task: &'a Task,
        grasps: &'a GraspBook,
        runner: Runner<'a>,
    ) -> Self {
        let start = shapes.posed(&motions.scene.poses());
        Self {
            motions,
            shapes,
            task,
            grasps,
            runner,
            start,
            done: Vec::new(),
            picks: Vec::new(),
            detail: None,
        }
    }

    /// Whether nothing has happened yet.
    pub fn has_not_moved(&self) -> bool {
        self.runner.world.time_s() == 0.0
    }

    /// Makes all steps of the goal.
    ///
    /// # Errors
    /// Why a step could not be made.
    pub fn run(&mut self, rng: &mut impl Rng) -> Result<(), Failure> {
        for step in steps(&self.task.goal) {
            if self.is_done(&step) {
                continue;
            }
            let object = self.motions.scene.index(step.object().as_str()).ok_or(Failure::GoalNotMet)?;
            let held = self.pick(object, &step, rng)?;
            if !matches!(step, Step::Lift { .. }) {
                self.place(&held, &step, rng)?;
            }
            if let Step::Place { predicates, .. } = step {
                self.done.extend(predicates);
            }
        }
        if !self.task.goal.ends_in_hand() {
            self.leave();
        }
        Ok(())
    }

    /// Moves the hand as far from everything as the task asks, where the last retreat did not and a way is known; says
    /// whether it did.
    fn leave(&mut self) -> bool {
        let gap_m = self.task.limits.min_gripper_distance_m + LEAVING_GAP_M;
        let (poses, opening_m) = (self.runner.poses(), self.runner.world.opening_m());
        let way = way_out(self.motions, &self.runner.commanded, opening_m, &poses, gap_m);
        let trajectory = way.and_then(|path| self.motions.time_straight(&path).ok());
        if let Some(trajectory) = &trajectory {
            self.runner.follow(Phase::Retreat, trajectory);
        }
        trajectory.is_some()
    }

    /// Whether the predicates of a step hold already.
    fn is_done(&self, step: &Step) -> bool {
        let Step::Place { predicates, .. } = step else { return false };
        let now = self.now();
        let situation = self.situation(&now, &[]);
        predicates.iter().all(|predicate| evaluate_predicate(predicate, &situation).holds)
    }

    pub(super) fn now(&self) -> Vec<PosedObject> {
        self.shapes.posed(&self.runner.poses())
    }

    pub(super) fn situation<'b>(&'b self, now: &'b [PosedObject], contacts: &'b [Contact]) -> Situation<'b> {
        Situation { table: &self.motions.scene.outline, start: &self.start, now, contacts }
    }

    /// Poses at which the object of a step may be put down.
    fn places(&self, object: usize, step: &Step) -> Vec<Pose> {
        places(
            self.motions.scene,
            self.shapes,
            &self.start,
            &self.now(),
            object,
            step,
            &self.done,
            self.motions.settings,
        )
    }

    /// Tries of what becomes of the object of a step when it is let go.
    fn release_trials<'b>(&'b self, object: usize, step: &'b Step, poses: &'b [Pose]) -> ReleaseTrials<'b> {
        let (scene, shapes) = (self.motions.scene, self.shapes);
        ReleaseTrials::new(scene, shapes, &self.start, poses, object, step.predicates(), &self.done)
    }

    /// Gets hold of an object and raises it.
    fn pick(&mut self, object: usize, step: &Step, rng: &mut impl Rng) -> Result<HeldObject, Failure> {
        let name = self.motions.scene.objects[object].name.as_str();
        let stable = |grasp: &&Grasp| grasp.verdict == Verdict::Stable;
        let grasps: Vec<Grasp> =
            self.grasps.get(name).into_iter().flatten().filter(stable).copied().collect();
        if grasps.is_empty() {
            return Err(Failure::NoGrasp);
        }
        let mut failed: Vec<Pose> = Vec::new();
        for _ in 0..=RETRIES {
            let untried = grasps.iter().filter(|grasp| !failed.contains(&grasp.object_from_tool));
            let untried: Vec<Grasp> = untried.copied().collect();
            let option = self.choose(object, step, &untried, rng)?;
            if let Some(held) = self.take(object, &option)? {
                return Ok(held);
            }
            failed.push(option.grasp.object_from_tool);
            failed.push(option.grasp.mirrored().object_from_tool);
            let mut back = option.approach.clone();
            back.reverse();
            self.open(option.grasp.pregrasp_opening_m);
            self.follow_straight(Phase::Retreat, &back)?;
        }
        Err(Failure::NoGrasp)
    }

    /// Chooses a grasp from which the step can be finished, and moves before it.
    fn choose(
        &mut self,
        object: usize,
        step: &Step,
        grasps: &[Grasp],
        rng: &mut impl Rng,
    ) -> Result<PickOption, Failure> {
        let poses = self.runner.poses();
        let commanded = self.runner.commanded.clone();
        let picks = self.motions.picks(object, &poses, grasps, &commanded);
        if picks.is_empty() {
            self.detail = Some("no grasp has free motions: approach and lift".to_owned());
            return Err(self.why_not(&poses[object], grasps));
        }
        let useful: Vec<PickOption> = if matches!(step, Step::Lift { .. }) {
            picks
        } else {
            let places = self.places(object, step);
            let neighbors = self.motions.neighbors(object, &poses);
            let max_fall_m = max_fall_m(step);
            let trials = self.release_trials(object, step, &poses);
            let can_finish = |pick: &PickOption, is_tried: bool| {
                let held = held_as(object, &pick.grasp);
                let near = pick.lift.last().unwrap_or(&commanded);
                let finish = |place| self.motions.place(&held, place, &neighbors, near, max_fall_m);
                let stays = |option: PlaceOption| !is_tried || trials.succeeds(&option.released);
                places.iter().any(|place| finish(place).is_some_and(stays))
            };
            // Where no trial succeeds, the task is attempted all the same.
            let tried: Vec<PickOption> =
                picks.iter().filter(|pick| can_finish(pick, true)).cloned().collect();
            if tried.is_empty() {
                picks.into_iter().filter(|pick| can_finish(pick, false)).collect()
            } else {
                tried
            }
        };
        let goals: Vec<Vec<f64>> = useful.iter().filter_map(|pick| pick.approach.first().cloned()).collect();
        if goals.is_empty() {
            self.detail = Some("no place can be reached with any of the grasps".to_owned());
            return Err(Failure::NoPath);
        }
        let mut planned = self.motions.move_free(&commanded, &goals, &poses, rng);
        // Retreats pass neighbors more closely than the spheres of the planner do.
        if planned.as_ref().is_err_and(MotionFailure::is_at_start) && self.leave() {
            planned = self.motions.move_free(&self.runner.commanded, &goals, &self.runner.poses(), rng);
        }
        let (path, trajectory) = planned.map_err(|failure| self.no_path(&failure))?;
        let option = reached(&path, &useful, |pick| &pick.approach).ok_or(Failure::NoPath)?;
        let (opening_m, speed_m_s) =
            (option.grasp.pregrasp_opening_m, self.motions.settings.finger_speed_m_s);
        let force_n = self.motions.robot.gripper().grip_force_n;
        self.runner.move_fingers(Phase::Transit, opening_m, speed_m_s, force_n, 0.0);
        self.runner.follow(Phase::Transit, &trajectory);
        Ok(option.clone())
    }

    /// Reason why no grasp can be used: [`Failure::Unreachable`] if the arm reaches none at all, otherwise
    /// [`Failure::NoPath`].
    fn why_not(&self, world_from_object: &Pose, grasps: &[Grasp]) -> Failure {
        let base_from_world = self.motions.world_from_base.inverse();
        let tools =
            grasps.iter().flat_map(|g| [*g, g.mirrored()]).map(|g| *world_from_object * g.object_from_tool);
        let reached =
            |tool: Pose| !self.motions.reach.all(&(base_from_world * to_isometry(&tool))).is_empty();
        if tools.into_iter().any(reached) { Failure::NoPath } else { Failure::Unreachable }
    }

    /// Approaches, closes and lifts; `None` if the fingers did not get hold of the object.
    fn take(&mut self, object: usize, option: &PickOption) -> Result<Option<HeldObject>, Failure> {
        let (force_n, settings) = (option.grasp.force_n, self.motions.settings);
        self.follow_straight(Phase::Approach, &option.approach)?;
        let way_m = 0.5 * (option.grasp.pregrasp_opening_m - option.grasp.opening_m).max(0.0) + 0.01;
        let max_s = way_m / settings.finger_speed_m_s + MAX_CLOSING_S;
        self.runner.move_fingers(Phase::Close, 0.0, settings.finger_speed_m_s, force_n, 0.0);
        self.runner.wait_for_hold(object, HOLDING_SHARE * force_n, max_s);
        self.runner.wait(Phase::Close, SETTLE_S);
        if !self.runner.holds(object, HOLDING_SHARE * force_n) {
            return Ok(None);
        }
        let gripped = self.runner.in_hand(object);
        self.runner.set_load(Some(object));
        self.follow_straight(Phase::Lift, &option.lift)?;
        self.runner.wait(Phase::Lift, SETTLE_S);
        let name = self.motions.scene.objects[object].name.clone();
        self.picks.push(PickReport { object: name, grasp: option.grasp, slip_m: 0.0 });
        self.note_slip(object, &gripped);
        if !self.runner.holds(object, HOLDING_SHARE * force_n) {
            return Err(Failure::Dropped);
        }
        Ok(Some(HeldObject {
            object,
            tool_from_object: self.runner.in_hand(object),
            opening_m: self.runner.world.opening_m(),
            release_opening_m: option.grasp.pregrasp_opening_m,
            force_n,
        }))
    }

    /// Carries an object to its place, lets it go and leaves it.
    fn place(&mut self, held: &HeldObject, step: &Step, rng: &mut impl Rng) -> Result<(), Failure> {
        let poses = self.runner.poses();
        let commanded = self.runner.commanded.clone();
        let places = self.places(held.object, step);
        let neighbors = self.motions.neighbors(held.object, &poses);
        let max_fall_m = max_fall_m(step);
        let trials = self.release_trials(held.object, step, &poses);
        let max_options = self.motions.settings.max_options;
        let in_reach =
            places.iter().filter_map(|at| self.motions.place(held, at, &neighbors, &commanded, max_fall_m));
        let (mut options, mut unstable) = (Vec::new(), Vec::new());
        for option in in_reach {
            if trials.succeeds(&option.released) {
                options.push(option)
            } else {
                unstable.push(option)
            }
            if options.len() == max_options {
                break;
            }
        }
        // Where no trial succeeds, the task is attempted all the same.
        if options.is_empty() {
            options = unstable;
            options.truncate(max_options);
        }
        let goals: Vec<Vec<f64>> =
            options.iter().filter_map(|option| option.lower.first().cloned()).collect();
        if goals.is_empty() {
            self.detail =
                Some(format!("none of {} places can be reached with the held object", places.len()));
            return Err(Failure::NoPath);
        }
        let planned = self.motions.carry(held, &commanded, &goals, &poses, rng);
        let (path, trajectory) = planned.map_err(|failure| self.no_path(&failure))?;
        let option = reached(&path, &options, |option| &option.lower).ok_or(Failure::NoPath)?.clone();
        self.runner.follow(Phase::Carry, &trajectory);
        self.follow_straight(Phase::Lower, &option.lower)?;
        self.runner.wait(Phase::Lower, SETTLE_S);
        self.note_slip(held.object, &held.tool_from_object);
        if !self.runner.holds(held.object, HOLDING_SHARE * held.force_n) {
            return Err(Failure::Dropped);
        }
        self.runner.set_load(None);
        self.open(held.release_opening_m);
        self.follow_straight(Phase::Retreat, &option.retreat)
    }

    /// Opens the fingers where the arm is.
    fn open(&mut self, opening_m: f64) {
        let (speed_m_s, force_n) =
            (self.motions.settings.finger_speed_m_s, self.motions.robot.gripper().grip_force_n);
        let way_m = 0.5 * (opening_m - self.runner.world.opening_m()).max(0.0);
        self.runner.move_fingers(Phase::Open, opening_m, speed_m_s, force_n, way_m / speed_m_s + SETTLE_S);
    }

    fn follow_straight(&mut self, phase: Phase, path: &[Vec<f64>]) -> Result<(), Failure> {
        let trajectory = self.motions.time_straight(path).map_err(|failure| self.no_path(&failure))?;
        self.runner.follow(phase, &trajectory);
        Ok(())
    }

    fn no_path(&mut self, failure: &MotionFailure) -> Failure {
        self.detail = Some(failure.to_string());
        Failure::NoPath
    }

    /// Notes how far the point between the pads moved in the hand.
    fn note_slip(&mut self, object: usize, before: &Pose) {
        let point = before.inverse().transform_point(DVec3::ZERO);
        let slip_m = self.runner.in_hand(object).transform_point(point).length();
        if let Some(pick) = self.picks.last_mut() {
            pick.slip_m += slip_m;
        }
    }
}

/// Maximum fall of an object at the end of a step, meters; above 0 only into an opening, where hands do not always fit.
pub(super) fn max_fall_m(step: &Step) -> f64 {
    match step {
        Step::Place { predicates, .. } if predicates.iter().any(|p| p.predicate == PredicateKind::In) => {
            MAX_FALL_M
        }
        _ => 0.0,
    }
}

/// An object in the hand as a grasp intends it.
pub(super) fn held_as(object: usize, grasp: &Grasp) -> HeldObject {
    HeldObject {
        object,
        tool_from_object: grasp.object_from_tool.inverse(),
        opening_m: grasp.opening_m,
        release_opening_m: grasp.pregrasp_opening_m,
        force_n: grasp.force_n,
    }
}

/// The option whose straight motion begins where a path ends.
fn reached<'b, T>(path: &[Vec<f64>], options: &'b [T], of: impl Fn(&T) -> &Vec<Vec<f64>>) -> Option<&'b T> {
    let end = path.last()?;
    let off = |option: &T| {
        let first = of(option).first();
        first.map_or(f64::INFINITY, |q| q.iter().zip(end).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max))
    };
    options.iter().min_by(|a, b| off(a).total_cmp(&off(b))).filter(|option| off(option) < 1e-5)
}
