//! Start states of goals: the objects stand apart from their goal.

use super::draft::{Draft, DraftRelation};
use super::grammar::{GoalDraft, GoalKind, ParsedText, category_shows};
use super::supports::at;
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
        for predicate in of_goal(draft, goal) {
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

fn of_goal(draft: &Draft, goal: &GoalDraft) -> Vec<DraftPredicate> {
    let all = &draft.of_mention[goal.object];
    let take = goal.take.map_or(all.len(), |take| (take as usize).min(all.len()));
    let objects = &all[..take];
    let targets: &[usize] = goal.target.map_or(&[], |target| &draft.of_mention[target]);
    let chain = |kind: PredicateKind| -> Vec<DraftPredicate> {
        let pairs = objects.windows(2);
        pairs
            .map(|pair| DraftPredicate { kind, object: pair[1], target: Some(pair[0]), second: None })
            .collect()
    };
    match &goal.kind {
        GoalKind::StackOfItself => return chain(PredicateKind::StackedOn),
        GoalKind::Together => return chain(PredicateKind::NextTo),
        GoalKind::Predicate(PredicateKind::Swapped) if goal.target == Some(goal.object) => {
            return chain(PredicateKind::Swapped).into_iter().take(1).collect();
        }
        _ => {}
    }
    if goal.target.is_some() && targets.is_empty() {
        return Vec::new();
    }
    let mut predicates = Vec::new();
    for (k, &object) in objects.iter().enumerate() {
        let target = targets.get(k % targets.len().max(1)).copied();
        let second = goal.second.and_then(|second| {
            draft.of_mention[second].iter().copied().find(|&other| Some(other) != target && other != object)
        });
        let kind = match &goal.kind {
            GoalKind::Predicate(kind) => *kind,
            GoalKind::At => match target.map(|target| at(draft.category(object), draft.category(target))) {
                Some(RelationKind::In) => PredicateKind::In,
                Some(RelationKind::NextTo) => PredicateKind::NextTo,
                _ => PredicateKind::On,
            },
            GoalKind::AwayFromSupport => {
                match target.map(|target| at(draft.category(object), draft.category(target))) {
                    Some(RelationKind::In) => PredicateKind::OutOf,
                    _ => PredicateKind::Off,
                }
            }
            GoalKind::StackOfItself | GoalKind::Together => continue,
        };
        predicates.push(DraftPredicate { kind, object, target, second });
    }
    predicates
}

/// Changes the draft so that it does not satisfy the predicates. Returns the predicates that no start state can
/// violate.
pub(super) fn stand_apart(draft: &mut Draft, predicates: &[DraftPredicate]) -> Vec<DraftPredicate> {
    let mut satisfied = Vec::new();
    for predicate in predicates {
        if !violate(draft, predicate) {
            satisfied.push(*predicate);
        }
    }
    satisfied
}

/// Makes the start state violate a predicate; `false` if it cannot.
fn violate(draft: &mut Draft, predicate: &DraftPredicate) -> bool {
    use PredicateKind as P;
    use RelationKind as R;
    let &DraftPredicate { kind, object, target, second } = predicate;
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
        (P::OutOf, Some(to)) => {
            if draft.supporter(object).is_none() {
                draft.relate(object, R::In, Some(to));
            }
            draft.supporter(object).is_some()
        }
        (P::Off, Some(to)) => {
            if draft.supporter(object).is_none() {
                draft.relate(object, R::On, Some(to));
            }
            draft.supporter(object).is_some()
        }
        (P::Opened, _) => state(draft, object, "open", "closed"),
        (P::Closed, _) => state(draft, object, "closed", "open"),
        (P::Upright, _) => {
            if draft.objects[object].pose.is_upright() {
                draft.objects[object].pose = RequestedPose::LyingOnSide;
            }
            true
        }
        (P::LyingOnSide | P::UpsideDown, _) => {
            draft.objects[object].pose = RequestedPose::Upright;
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

fn state(draft: &mut Draft, object: usize, goal: &str, start: &str) -> bool {
    let category = draft.category(object);
    if draft.objects[object].state.as_deref() == Some(goal) {
        draft.objects[object].state = None;
    }
    if category_shows(category, start) {
        draft.objects[object].state = Some(start.to_owned());
    }
    true
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
