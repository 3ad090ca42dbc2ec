//! Goals that affordances and shapes suggest, before they are checked.

use std::collections::BTreeMap;

use catalog::{Affordance, category};
use glam::DVec2;
use rand::seq::SliceRandom;
use runtime::seed::Rng;
use scene::text_account::{GoalPredicate, PredicateKind};

use super::ProposalKind;
use crate::evaluation::evaluate;
use crate::goal::Goal;
use crate::robot_limits::{RobotLimits, narrowest_m};
use crate::task_scene::TaskScene;
use crate::validation::require_movable;

/// Pairs of steps that are made.
const MAX_PAIRS: usize = 200;
/// Minimum difference between the widths of an opening and of an object that goes into it, meters.
const MIN_SLACK_M: f64 = 0.01;

/// Minimum free space beyond its width that an object needs at the edge of the table, meters.
const MIN_ROOM_M: f64 = 0.03;

/// A goal with its kind.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub kind: ProposalKind,
    pub goal: Goal,
}

impl Candidate {
    fn of(
        kind: ProposalKind,
        predicate: PredicateKind,
        scene: &TaskScene,
        a: usize,
        b: Option<usize>,
    ) -> Option<Self> {
        let name = |index: usize| scene.posed()[index].name.clone();
        let predicate =
            GoalPredicate { predicate, object: name(a), target: b.map(name), second_target: None };
        Some(Self { kind, goal: Goal::new([predicate]).ok()? })
    }
}

/// Every goal of one step that is not reached, in the order of the objects.
pub(super) fn candidates(scene: &TaskScene, robot: &RobotLimits) -> Vec<Candidate> {
    use PredicateKind as P;
    use ProposalKind as K;
    let movable: Vec<usize> =
        (0..scene.posed().len()).filter(|object| is_movable(*object, scene, robot)).collect();
    let mut found = Vec::new();
    for &a in &movable {
        found.extend(Candidate::of(K::Lift, P::Lifted, scene, a, None));
        for b in (0..scene.posed().len()).filter(|b| *b != a) {
            if holds(a, b, scene) {
                found.extend(Candidate::of(K::In, P::In, scene, a, Some(b)));
            }
            if affords(b, Affordance::Support, scene) && carries(a, b, scene) {
                let is_stack = scene.described()[a].category == scene.described()[b].category;
                let (kind, predicate) = if is_stack { (K::Stack, P::StackedOn) } else { (K::On, P::On) };
                found.extend(Candidate::of(kind, predicate, scene, a, Some(b)));
            }
            if is_on_table(b, scene) {
                found.extend(Candidate::of(K::NextTo, P::NextTo, scene, a, Some(b)));
                if has_room(a, b, -DVec2::X, scene) {
                    found.extend(Candidate::of(K::LeftOf, P::LeftOf, scene, a, Some(b)));
                }
                if has_room(a, b, DVec2::X, scene) {
                    found.extend(Candidate::of(K::RightOf, P::RightOf, scene, a, Some(b)));
                }
            }
            let both = a < b && movable.contains(&b) && is_on_table(a, scene) && is_on_table(b, scene);
            if both {
                found.extend(Candidate::of(K::Swap, P::Swapped, scene, a, Some(b)));
            }
        }
    }
    let situation = scene.situation();
    found.retain(|candidate| !evaluate(&candidate.goal, &situation).iter().all(|outcome| outcome.holds));
    found
}

/// Goals of two steps with different objects, of which neither takes away the other's target.
pub(super) fn pairs(single: &BTreeMap<ProposalKind, Vec<Candidate>>, rng: &mut Rng) -> Vec<Candidate> {
    use ProposalKind as K;
    let steps: Vec<&Candidate> =
        [K::In, K::On, K::NextTo, K::LeftOf].iter().filter_map(|kind| single.get(kind)).flatten().collect();
    // Supports and containers first: of the rest there are many more.
    let firsts: Vec<&&Candidate> = steps.iter().filter(|step| matches!(step.kind, K::In | K::On)).collect();
    let mut found = Vec::new();
    'pairs: for first in firsts {
        let mut seconds: Vec<&&Candidate> = steps.iter().filter(|second| are_apart(first, second)).collect();
        seconds.shuffle(rng);
        for second in seconds.into_iter().take(4) {
            let both = first.goal.predicates().iter().chain(second.goal.predicates()).cloned();
            found.extend(Goal::new(both).map(|goal| Candidate { kind: K::TwoSteps, goal }));
            if found.len() >= MAX_PAIRS {
                break 'pairs;
            }
        }
    }
    found.shuffle(rng);
    found
}

/// Whether two steps move different objects, and none the other's target.
fn are_apart(first: &Candidate, second: &Candidate) -> bool {
    let (a, b) = (&first.goal.predicates()[0], &second.goal.predicates()[0]);
    a.object != b.object && a.target.as_ref() != Some(&b.object) && b.target.as_ref() != Some(&a.object)
}

/// Whether the robot can grasp and lift the object, nothing rests on it, and it does not lie deep in a container.
fn is_movable(object: usize, scene: &TaskScene, robot: &RobotLimits) -> bool {
    let supports = scene.supports();
    if supports.branch(object).count() > 1 {
        return false;
    }
    let supporter = scene.described()[object].supporter;
    let is_deep = supporter.parent.filter(|_| supporter.is_container()).is_some_and(|container| {
        let top_m = |index: usize| scene.described()[index].footprint.top_m;
        top_m(object) < top_m(container)
    });
    !is_deep && require_movable(object, scene, robot).is_ok()
}

fn is_on_table(object: usize, scene: &TaskScene) -> bool {
    scene.described()[object].supporter.parent.is_none()
}

/// Whether the object has ample space between the target and the edge of the table; where it has little, the search for
/// a place takes long.
fn has_room(object: usize, target: usize, way: DVec2, scene: &TaskScene) -> bool {
    let (low, high) = scene.table.bounds();
    let edge_m = (0.5 * (low + high)).dot(way) + (0.5 * (high - low)).dot(way.abs());
    let footprint = &scene.described()[target].footprint;
    let target_m = footprint.center().dot(way) + footprint.extent_m(way);
    edge_m - target_m >= narrowest_m(&scene.posed()[object].shape) + MIN_ROOM_M
}

fn affords(object: usize, affordance: Affordance, scene: &TaskScene) -> bool {
    category(&scene.described()[object].category).is_some_and(|category| category.affords(affordance))
}

/// Whether the target is an open container that the object passes into.
fn holds(object: usize, target: usize, scene: &TaskScene) -> bool {
    let known = category(&scene.described()[target].category);
    if known.is_some_and(|known| !known.affords(Affordance::Container)) {
        return false;
    }
    let (shape, container) = (&scene.posed()[object].shape, &scene.posed()[target]);
    let same = scene.described()[object].category == scene.described()[target].category;
    container.shape.opening().is_some_and(|opening| {
        let fits = narrowest_m(shape) + MIN_SLACK_M <= opening.narrowest_m();
        let is_upright = container.tilt_rad() <= crate::evaluation::TILT_RAD;
        fits && !same && is_upright && volume_m3(object, scene) <= opening.volume_m3
    })
}

/// Whether the object is not much larger than the target, seen from above.
fn carries(object: usize, target: usize, scene: &TaskScene) -> bool {
    let size_m = |index: usize| {
        let (low, high) = scene.described()[index].footprint.bounds();
        high - low
    };
    let (above, below) = (size_m(object), size_m(target));
    let is_flat = scene.posed()[target].tilt_rad() <= crate::evaluation::TILT_RAD;
    is_flat
        && above.element_product() <= 1.2 * below.element_product()
        && above.max_element() <= 1.3 * below.max_element()
}

fn volume_m3(object: usize, scene: &TaskScene) -> f64 {
    scene.posed()[object].shape.hulls().iter().map(geometry::ConvexHull::volume_m3).sum()
}
