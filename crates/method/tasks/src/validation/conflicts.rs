//! Predicates that cannot hold together, whatever the shapes are.

use scene::InstanceId;
use scene::text_account::{GoalPredicate, PredicateKind};

use crate::goal::{Goal, formula};
use crate::refusal::Refusal;

/// No two predicates of the goal contradict each other, and supports form no cycle.
pub(super) fn require_compatible(goal: &Goal) -> Result<(), Refusal> {
    let predicates = goal.predicates();
    for (index, first) in predicates.iter().enumerate() {
        for second in &predicates[index + 1..] {
            if contradict(first, second) || contradict(second, first) {
                return Err(conflict(first, second));
            }
        }
        if let Some(last) = cycle(predicates, first) {
            return Err(conflict(first, last));
        }
    }
    Ok(())
}

fn conflict(first: &GoalPredicate, second: &GoalPredicate) -> Refusal {
    Refusal::GoalConflict { first: formula(first), second: formula(second) }
}

fn is_support(kind: PredicateKind) -> bool {
    matches!(kind, PredicateKind::In | PredicateKind::On | PredicateKind::StackedOn)
}

/// Two predicates in this order.
fn contradict(a: &GoalPredicate, b: &GoalPredicate) -> bool {
    use PredicateKind as P;
    let (same_object, same_target) = (a.object == b.object, a.target == b.target);
    let mirrored = a.target.as_ref() == Some(&b.object) && b.target.as_ref() == Some(&a.object);
    match (a.predicate, b.predicate) {
        // One place each; a stack on a plate may also be "on" it.
        (first, second) if is_support(first) && is_support(second) && same_object => !same_target,
        // One hand.
        (P::Lifted, P::Lifted) => !same_object,
        (P::Lifted, second) if is_support(second) => same_object,
        (P::In, P::OutOf) | (P::On | P::StackedOn, P::Off) | (P::In | P::NextTo, P::AwayFrom) => {
            same_object && same_target
        }
        (P::LeftOf, P::RightOf) | (P::InFrontOf, P::Behind) => same_object && same_target,
        (P::LeftOf, P::LeftOf)
        | (P::RightOf, P::RightOf)
        | (P::InFrontOf, P::InFrontOf)
        | (P::Behind, P::Behind) => mirrored,
        (P::Opened, P::Closed) => same_object,
        (P::Upright, P::LyingOnSide | P::UpsideDown) | (P::LyingOnSide, P::UpsideDown) => same_object,
        (first, second) if regions(first).is_some() && regions(second).is_some() && same_object => {
            let apart = |a: i8, b: i8| a * b < 0;
            let ([ax, ay], [bx, by]) =
                (regions(first).unwrap_or_default(), regions(second).unwrap_or_default());
            apart(ax, bx) || apart(ay, by)
        }
        _ => false,
    }
}

/// Sides of the table: left -1, right 1; front -1, back 1.
fn regions(kind: PredicateKind) -> Option<[i8; 2]> {
    use PredicateKind as P;
    Some(match kind {
        P::AtCenter => [0, 0],
        P::AtBack => [0, 1],
        P::AtFront => [0, -1],
        P::AtLeft => [-1, 0],
        P::AtRight => [1, 0],
        P::AtBackLeft => [-1, 1],
        P::AtBackRight => [1, 1],
        P::AtFrontLeft => [-1, -1],
        P::AtFrontRight => [1, -1],
        _ => return None,
    })
}

/// The support that closes a cycle which begins with this one.
fn cycle<'a>(predicates: &'a [GoalPredicate], first: &GoalPredicate) -> Option<&'a GoalPredicate> {
    if !is_support(first.predicate) {
        return None;
    }
    let support_of = |name: &InstanceId| {
        predicates.iter().find(|other| is_support(other.predicate) && &other.object == name)
    };
    let mut at = first.target.as_ref()?;
    // As many steps as there are predicates reach every support.
    for _ in 0..predicates.len() {
        let next = support_of(at)?;
        at = next.target.as_ref()?;
        if *at == first.object {
            return Some(next);
        }
    }
    None
}
