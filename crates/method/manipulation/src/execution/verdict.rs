//! The end of an attempt: rest, predicates, and the reason of a failure.

use geometry::Pose;
use tasks::{
    Contact, ContactBody, Goal, GoalPredicate, PosedObject, PredicateKind, Situation, disturbed_others,
    evaluate, evaluation::evaluate_predicate,
};

use super::attempt::Attempt;
use super::leave::is_away;
use super::obstacles::Surroundings;
use super::record::Phase;
use super::{Execution, Failure};

/// An object that moved farther in the hand has slipped, meters.
const SLIPPED_M: f64 = 0.01;
/// Objects slower than this are at rest, m/s, and are waited for up to this time, seconds.
const REST_M_S: f64 = 0.005;
const MAX_REST_S: f64 = 6.0;

impl Attempt<'_> {
    /// Waits until everything rests, and judges.
    pub fn finish(mut self, failure: Option<Failure>, world_from_base: Pose) -> Execution {
        if !self.has_not_moved() {
            self.rest();
        }
        let now = self.now();
        let contacts = self.contacts();
        let goal = &self.task.goal;
        let (predicates, disturbed) = {
            let situation = self.situation(&now, &contacts);
            let carried = carried(goal, &self.situation(&self.start, &[]));
            let disturbed = disturbed_others(goal, &self.task.limits, &self.start, &now, &carried);
            (evaluate(goal, &situation), disturbed)
        };
        let slipped = self.picks.iter().any(|pick| pick.slip_m > SLIPPED_M);
        let mut reached = predicates.iter().all(|outcome| outcome.holds);
        if reached && !self.has_left() {
            reached = false;
            self.detail = Some("the hand is still near an object".to_owned());
        }
        let (duration_s, max_s) = (self.runner.world.time_s(), self.task.limits.max_duration_s);
        if reached && duration_s > max_s {
            reached = false;
            self.detail = Some(format!("it took {duration_s:.1} s of {max_s:.1} s"));
        }
        let failure = failure.or(match (reached, disturbed.is_empty()) {
            (true, true) => None,
            (true, false) => Some(Failure::DisturbedOthers),
            (false, _) if slipped => Some(Failure::Slipped),
            (false, _) => Some(Failure::GoalNotMet),
        });
        Execution {
            robot: self.motions.robot.name().to_owned(),
            variant: self.motions.robot.variant().map(str::to_owned),
            world_from_base,
            succeeded: failure.is_none(),
            failure,
            detail: self.detail,
            predicates,
            disturbed,
            picks: self.picks,
            duration_s: self.runner.world.time_s(),
            recording: self.runner.recording,
        }
    }

    /// Whether the hand is as far from all objects as the task asks, unless it shall hold one.
    fn has_left(&self) -> bool {
        let (motions, world) = (self.motions, &self.runner.world);
        let scene = motions.scene;
        let around = Surroundings::new(&scene.table, &scene.objects, &self.runner.poses(), &[]);
        let gap_m = self.task.limits.min_gripper_distance_m;
        self.task.goal.ends_in_hand()
            || is_away(motions, &around, &world.tool_pose(), world.opening_m(), gap_m)
    }

    /// Waits until all objects have rested as long as the task asks, or have had time enough.
    fn rest(&mut self) {
        const WINDOW_S: f64 = 0.1;
        let (mut rested_s, mut waited_s) = (0.0, 0.0);
        while rested_s < self.task.limits.min_rest_s && waited_s < MAX_REST_S {
            self.runner.wait(Phase::Rest, WINDOW_S);
            waited_s += WINDOW_S;
            rested_s = if self.runner.fastest_m_s() < REST_M_S { rested_s + WINDOW_S } else { 0.0 };
        }
    }

    /// Contacts between table and objects at the end.
    fn contacts(&self) -> Vec<Contact> {
        let world = &self.runner.world;
        let names = &self.shapes.names;
        let body = |index: usize| match index {
            0 => ContactBody::Table,
            _ => ContactBody::Object(names[index - 1].clone()),
        };
        let mut contacts = Vec::new();
        for a in 0..=names.len() {
            for b in a + 1..=names.len() {
                if world.objects_touch(a, b) {
                    contacts.push(Contact { first: body(a), second: body(b) });
                }
            }
        }
        for touch in world.touches() {
            contacts.push(Contact { first: ContactBody::Gripper, second: body(touch.object) });
        }
        contacts
    }
}

/// Objects that rest on or in objects that a goal moves, and may move along.
fn carried(goal: &Goal, start: &Situation) -> Vec<scene::InstanceId> {
    let moved = goal.moved_objects();
    let rests = |object: &PosedObject, on: &scene::InstanceId| {
        [PredicateKind::On, PredicateKind::In].into_iter().any(|predicate| {
            let predicate = GoalPredicate {
                predicate,
                object: object.name.clone(),
                target: Some(on.clone()),
                second_target: None,
            };
            evaluate_predicate(&predicate, start).holds
        })
    };
    let others = start.now.iter().filter(|object| !moved.contains(&&object.name));
    others
        .filter(|object| moved.iter().any(|on| rests(object, on)))
        .map(|object| object.name.clone())
        .collect()
}
