//! Start states of goals: the objects stand apart from their goal.

use super::draft::{Draft, DraftRelation};
use super::grammar::{GoalDraft, GoalKind, ParsedText, category_shows};
use super::supports::at;
use catalog::{Affordance, Category};
use scene::RelationKind;
use scene::description::RequestedPose;
use scene::text_account::PredicateKind;

/// A predicate over draft objects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DraftPredicate {
    pub kind: PredicateKind,
    pub object: usize,
    pub target: Option<usize>,
    pub second: Option<usize>,
    /// Whether it may hold at the start, because a step of the task undoes it.
    pub is_restored: bool,
}

/// Predicates that no start state can violate visibly.
#[derive(Debug, Default)]
pub(super) struct Unviolated {
    /// Predicates that every start state satisfies.
    pub satisfied: Vec<DraftPredicate>,
    /// Predicates whose start state the meshes do not show.
    pub unshown: Vec<DraftPredicate>,
}

/// The predicates of the goal.
#[derive(Default)]
pub(super) struct Predicates {
    pub predicates: Vec<DraftPredicate>,
    /// The first predicate of each goal of the text.
    pub of_goal: Vec<Option<usize>>,
}

/// The predicates of the goal over objects. Several objects have one predicate each; with as many targets, one each.
pub(super) fn predicates(draft: &Draft, parsed: &ParsedText) -> Predicates {
    let mut all = Predicates::default();
    for goal in &parsed.goals {
        let mut first = None;
        let stacked = parsed.mentions[goal.object].stacked;
        for predicate in of_goal(draft, goal, stacked) {
            let known = all.predicates.iter().position(|known| known == &predicate);
            if known.is_none() && predicate.target != Some(predicate.object) {
                all.predicates.push(predicate);
            }
            first = first.or(known).or(all.predicates.len().checked_sub(1));
        }
        all.of_goal.push(first);
    }
    all
}

fn of_goal(draft: &Draft, goal: &GoalDraft, stacked: bool) -> Vec<DraftPredicate> {
    let all = &draft.of_mention[goal.object];
    let take = goal.take.map_or(all.len(), |take| (take as usize).min(all.len()));
    // Those on top are taken from a stack.
    let unstacks = goal.kind == GoalKind::UnstackOfItself && goal.take.is_some();
    let below = usize::from(unstacks);
    let objects = if stacked { &all[all.len().saturating_sub(take + below)..] } else { &all[..take] };
    let targets: &[usize] = goal.target.map_or(&[], |target| &draft.of_mention[target]);
    let chain = |kind: PredicateKind| -> Vec<DraftPredicate> {
        let pairs = objects.windows(2);
        pairs
            .map(|pair| DraftPredicate {
                kind,
                object: pair[1],
                target: Some(pair[0]),
                second: None,
                is_restored: false,
            })
            .collect()
    };
    match &goal.kind {
        GoalKind::StackOfItself => return chain(PredicateKind::StackedOn),
        GoalKind::UnstackOfItself => return chain(PredicateKind::Off),
        GoalKind::Together => return chain(PredicateKind::NextTo),
        GoalKind::InOrder(kind) => {
            let turned = |p: DraftPredicate| DraftPredicate {
                object: p.target.unwrap_or(p.object),
                target: Some(p.object),
                ..p
            };
            return chain(*kind).into_iter().map(turned).collect();
        }
        GoalKind::Predicate(PredicateKind::Swapped) if goal.target == Some(goal.object) => {
            return chain(PredicateKind::Swapped).into_iter().take(1).collect();
        }
        _ => {}
    }
    if goal.target.is_some() && targets.is_empty() {
        return Vec::new();
    }
    let mut predicates = Vec::new();
    // One vessel fills every glass.
    let reaches_all = matches!(
        goal.kind,
        GoalKind::Predicate(PredicateKind::PouredInto | PredicateKind::UsedOn | PredicateKind::AwayFrom)
    );
    let rounds = if reaches_all { objects.len().max(targets.len()) } else { objects.len() };
    for (k, &object) in objects.iter().cycle().take(rounds).enumerate() {
        let target = targets.get(k % targets.len().max(1)).copied();
        let second = goal.second.and_then(|second| {
            draft.of_mention[second].iter().copied().find(|&other| Some(other) != target && other != object)
        });
        let kind = match &goal.kind {
            GoalKind::Predicate(kind) => *kind,
            GoalKind::At => {
                match target.map(|target| reached(draft.category(object), draft.category(target))) {
                    Some(RelationKind::In) => PredicateKind::In,
                    Some(RelationKind::NextTo) => PredicateKind::NextTo,
                    _ => PredicateKind::On,
                }
            }
            GoalKind::AwayFromSupport => {
                match target.map(|target| at(draft.category(object), draft.category(target))) {
                    Some(RelationKind::In) => PredicateKind::OutOf,
                    _ => PredicateKind::Off,
                }
            }
            GoalKind::StackOfItself
            | GoalKind::UnstackOfItself
            | GoalKind::Together
            | GoalKind::InOrder(_) => continue,
        };
        let is_restored = goal.is_restored;
        predicates.push(DraftPredicate { kind, object, target, second, is_restored });
    }
    predicates
}

/// Relation of an object to another one that it has been brought to: in it, on it if it is flat or made to carry, or
/// beside it.
fn reached(item: &Category, host: &Category) -> RelationKind {
    const CARRIES: &[&str] = &["shelf", "cabinet", "display_stand", "stove", "dish_rack", "kitchen_scale"];
    match at(item, host) {
        // "bring the tape measure to the toolbox".
        RelationKind::In if host.name == "toolbox" => RelationKind::NextTo,
        RelationKind::On => {
            let size_m = host.size.typical_m();
            let is_flat = size_m.z <= 0.5 * size_m.x.min(size_m.y);
            let carries =
                is_flat || CARRIES.contains(&host.name.as_str()) || host.affords(Affordance::Container);
            if carries { RelationKind::On } else { RelationKind::NextTo }
        }
        kind => kind,
    }
}

/// Changes the draft so that it does not satisfy the predicates. Returns those for which that fails.
pub(super) fn stand_apart(draft: &mut Draft, predicates: &[DraftPredicate]) -> Unviolated {
    let mut unviolated = Unviolated::default();
    for predicate in predicates {
        if predicate.is_restored {
            restore(draft, predicate);
        } else if !violate(draft, predicate) {
            unviolated.satisfied.push(*predicate);
        } else if !shows_start(draft, predicate) {
            unviolated.unshown.push(*predicate);
        }
    }
    unviolated
}

/// The start state of what is undone on the way and restored.
fn restore(draft: &mut Draft, predicate: &DraftPredicate) {
    let state = match predicate.kind {
        PredicateKind::Closed => "closed",
        PredicateKind::Opened => "open",
        _ => return,
    };
    if category_shows(draft.category(predicate.object), state) {
        draft.objects[predicate.object].state = Some(state.to_owned());
    }
}

/// Whether the mesh shows the start state of "open" and "close".
fn shows_start(draft: &Draft, predicate: &DraftPredicate) -> bool {
    let is_state = matches!(predicate.kind, PredicateKind::Opened | PredicateKind::Closed);
    let state = draft.objects[predicate.object].state.as_deref().filter(|_| is_state);
    state.is_none_or(|state| category_shows(draft.category(predicate.object), state))
}

/// Makes the start state violate a predicate; `false` if it cannot.
fn violate(draft: &mut Draft, predicate: &DraftPredicate) -> bool {
    use PredicateKind as P;
    use RelationKind as R;
    let &DraftPredicate { kind, object, target, second, .. } = predicate;
    let remove = |draft: &mut Draft, kinds: &[RelationKind]| {
        draft.objects[object]
            .relations
            .retain(|relation| !(relation.to == target && kinds.contains(&relation.kind)));
    };
    match (kind, target) {
        (P::In | P::On | P::StackedOn, Some(target)) => {
            remove(draft, &[R::In, R::On, R::StackedOn]);
            draft.supporter(target) != Some(object) || {
                draft.objects[target].relations.retain(|relation| relation.to != Some(object));
                true
            }
        }
        (P::On, None) => draft.supporter(object).is_some(),
        (P::LeftOf, Some(to)) => opposite(draft, object, R::LeftOf, R::RightOf, to),
        (P::RightOf, Some(to)) => opposite(draft, object, R::RightOf, R::LeftOf, to),
        (P::InFrontOf, Some(to)) => opposite(draft, object, R::InFrontOf, R::Behind, to),
        (P::Behind, Some(to)) => opposite(draft, object, R::Behind, R::InFrontOf, to),
        (P::NextTo, Some(to)) => {
            remove(draft, &[R::NextTo]);
            place(draft, object, R::AtLeft);
            place(draft, to, R::AtRight);
            true
        }
        (P::Between, Some(to)) => {
            remove(draft, &[R::Between]);
            place(draft, object, R::AtFront);
            place(draft, to, R::AtBackLeft);
            if let Some(second) = second {
                place(draft, second, R::AtBackRight);
            }
            true
        }
        (P::AwayFrom, Some(to)) => {
            draft.relate(object, R::NextTo, Some(to));
            true
        }
        (P::Swapped, Some(to)) => {
            place(draft, object, R::AtLeft);
            place(draft, to, R::AtRight);
            true
        }
        (P::OutOf, Some(to)) => supported(draft, object, R::In, to),
        (P::Off, Some(to)) => supported(draft, object, R::On, to),
        (P::Opened, _) => {
            let category = draft.category(object);
            let closed = category_shows(category, "closed") || category_shows(category, "open");
            draft.objects[object].state = closed.then(|| "closed".to_owned());
            true
        }
        (P::Closed, _) => {
            draft.objects[object].state = Some("open".to_owned());
            true
        }
        (P::Upright, _) => {
            if draft.objects[object].pose.is_upright() {
                draft.objects[object].pose = RequestedPose::LyingOnSide;
            }
            true
        }
        (P::LyingOnSide | P::UpsideDown, _) => {
            let is_goal = match draft.objects[object].pose {
                RequestedPose::LyingOnSide => kind == P::LyingOnSide,
                RequestedPose::UpsideDown => kind == P::UpsideDown,
                _ => false,
            };
            if is_goal {
                draft.objects[object].pose = RequestedPose::Upright;
            }
            true
        }
        _ => match at_place(kind) {
            Some((goal, start)) => {
                draft.objects[object].relations.retain(|relation| relation.kind != goal);
                place(draft, object, start);
                true
            }
            None => true,
        },
    }
}

/// The opposite of the relation of the goal, unless the text says where the objects are.
fn opposite(draft: &mut Draft, object: usize, goal: RelationKind, start: RelationKind, to: usize) -> bool {
    draft.objects[object].relations.retain(|relation| !(relation.kind == goal && relation.to == Some(to)));
    draft.objects[to].relations.retain(|relation| !(relation.kind == start && relation.to == Some(object)));
    let supported = draft.supporter(object).is_some() || draft.supporter(to).is_some();
    if !supported && draft.objects[object].position_m.is_none() {
        draft.relate(object, start, Some(to));
    }
    true
}

/// A place for an object without one.
fn place(draft: &mut Draft, object: usize, kind: RelationKind) {
    let free = draft.objects[object].position_m.is_none()
        && draft.objects[object]
            .relations
            .iter()
            .all(|relation: &DraftRelation| relation.to.is_some() && !relation.kind.is_support());
    if free && draft.objects[object].relations.is_empty() {
        draft.relate(object, kind, None);
    }
}

/// The object that is to leave a support is on it or in it; `false` if another support is stated.
fn supported(draft: &mut Draft, object: usize, kind: RelationKind, to: usize) -> bool {
    if draft.objects[object].has(kind, Some(to))
        || draft.objects[object].has(RelationKind::StackedOn, Some(to))
    {
        return true;
    }
    draft.objects[object].relations.retain(|relation| relation.to != Some(to));
    draft.relate(object, kind, Some(to));
    draft.supporter(object).is_some()
}

/// The place that a predicate requires, and an opposite one.
fn at_place(kind: PredicateKind) -> Option<(RelationKind, RelationKind)> {
    use PredicateKind as P;
    use RelationKind as R;
    Some(match kind {
        P::AtCenter => (R::AtCenter, R::AtLeft),
        P::AtBack => (R::AtBack, R::AtFront),
        P::AtFront => (R::AtFront, R::AtBack),
        P::AtLeft => (R::AtLeft, R::AtRight),
        P::AtRight => (R::AtRight, R::AtLeft),
        P::AtBackLeft => (R::AtBackLeft, R::AtFrontRight),
        P::AtBackRight => (R::AtBackRight, R::AtFrontLeft),
        P::AtFrontLeft => (R::AtFrontLeft, R::AtBackRight),
        P::AtFrontRight => (R::AtFrontRight, R::AtBackLeft),
        _ => return None,
    })
}
