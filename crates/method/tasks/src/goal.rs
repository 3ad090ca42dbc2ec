//! Goals: conjunctions of predicates over the objects of a scene.

use std::collections::BTreeSet;

use scene::InstanceId;
use scene::text_account::{GoalPredicate, PredicateKind};
use serde::{Deserialize, Serialize};

/// Predicates that must all hold at the end of a task. In files, a list with at least one predicate.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Vec<StatedPredicate>", into = "Vec<GoalPredicate>")]
pub struct Goal {
    predicates: Vec<GoalPredicate>,
}

/// Reason why predicates are no goal.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GoalError {
    #[error("a goal needs at least one predicate")]
    Empty,
    #[error("the predicate {predicate} of {object} needs {}", arity_in_words(.predicate))]
    Arity { predicate: Name, object: InstanceId },
    #[error("{object} cannot be related to itself by {predicate}; name another object")]
    Reflexive { predicate: Name, object: InstanceId },
}

/// The name of a predicate in files and messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Name(pub PredicateKind);

impl std::fmt::Display for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(name_of(self.0))
    }
}

/// A predicate of a file, whose unknown fields are errors.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StatedPredicate {
    predicate: PredicateKind,
    object: InstanceId,
    #[serde(default)]
    target: Option<InstanceId>,
    #[serde(default)]
    second_target: Option<InstanceId>,
}

impl TryFrom<Vec<StatedPredicate>> for Goal {
    type Error = GoalError;
    fn try_from(stated: Vec<StatedPredicate>) -> Result<Self, GoalError> {
        Self::new(stated.into_iter().map(|predicate| GoalPredicate {
            predicate: predicate.predicate,
            object: predicate.object,
            target: predicate.target,
            second_target: predicate.second_target,
        }))
    }
}

impl From<Goal> for Vec<GoalPredicate> {
    fn from(goal: Goal) -> Self {
        goal.predicates
    }
}

/// Number of objects that a predicate relates its object to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arity {
    /// No other object.
    Unary,
    /// One object, or the table where none is given.
    OptionalTarget,
    /// One object.
    Target,
    /// Two objects.
    TwoTargets,
}

/// Number of objects that a predicate relates its object to.
pub fn arity(kind: PredicateKind) -> Arity {
    use PredicateKind as P;
    match kind {
        P::On => Arity::OptionalTarget,
        P::Between => Arity::TwoTargets,
        P::In
        | P::OutOf
        | P::Off
        | P::StackedOn
        | P::LeftOf
        | P::RightOf
        | P::InFrontOf
        | P::Behind
        | P::NextTo
        | P::AwayFrom
        | P::Swapped
        | P::PouredInto
        | P::UsedOn => Arity::Target,
        P::AtCenter
        | P::AtBack
        | P::AtFront
        | P::AtLeft
        | P::AtRight
        | P::AtBackLeft
        | P::AtBackRight
        | P::AtFrontLeft
        | P::AtFrontRight
        | P::Lifted
        | P::Opened
        | P::Closed
        | P::Upright
        | P::LyingOnSide
        | P::UpsideDown
        | P::Rotated
        | P::Moved
        | P::Pressed => Arity::Unary,
    }
}

fn arity_in_words(name: &Name) -> &'static str {
    match arity(name.0) {
        Arity::Unary => "no target",
        Arity::OptionalTarget => "at most one target",
        Arity::Target => "one target",
        Arity::TwoTargets => "two targets",
    }
}

/// The name of a predicate in files.
pub fn name_of(kind: PredicateKind) -> &'static str {
    use PredicateKind as P;
    match kind {
        P::In => "in",
        P::OutOf => "out_of",
        P::On => "on",
        P::Off => "off",
        P::StackedOn => "stacked_on",
        P::LeftOf => "left_of",
        P::RightOf => "right_of",
        P::InFrontOf => "in_front_of",
        P::Behind => "behind",
        P::NextTo => "next_to",
        P::Between => "between",
        P::AwayFrom => "away_from",
        P::AtCenter => "at_center",
        P::AtBack => "at_back",
        P::AtFront => "at_front",
        P::AtLeft => "at_left",
        P::AtRight => "at_right",
        P::AtBackLeft => "at_back_left",
        P::AtBackRight => "at_back_right",
        P::AtFrontLeft => "at_front_left",
        P::AtFrontRight => "at_front_right",
        P::Swapped => "swapped",
        P::Lifted => "lifted",
        P::Opened => "opened",
        P::Closed => "closed",
        P::Upright => "upright",
        P::LyingOnSide => "lying_on_side",
        P::UpsideDown => "upside_down",
        P::Rotated => "rotated",
        P::Moved => "moved",
        P::PouredInto => "poured_into",
        P::UsedOn => "used_on",
        P::Pressed => "pressed",
    }
}

impl Goal {
    /// The conjunction of predicates, without repetitions.
    ///
    /// # Errors
    ///
    /// [`GoalError`] without a predicate, or if one has too few or too many targets, or is its own target.
    pub fn new(predicates: impl IntoIterator<Item = GoalPredicate>) -> Result<Self, GoalError> {
        let mut kept: Vec<GoalPredicate> = Vec::new();
        for predicate in predicates {
            let (object, targets) = (&predicate.object, [&predicate.target, &predicate.second_target]);
            let given = [predicate.target.is_some(), predicate.second_target.is_some()];
            let fits = match arity(predicate.predicate) {
                Arity::Unary => given == [false, false],
                Arity::OptionalTarget => !given[1],
                Arity::Target => given == [true, false],
                Arity::TwoTargets => given == [true, true],
            };
            let (name, object) = (Name(predicate.predicate), object.clone());
            if !fits {
                return Err(GoalError::Arity { predicate: name, object });
            }
            if targets.into_iter().flatten().any(|target| *target == object) {
                return Err(GoalError::Reflexive { predicate: name, object });
            }
            if !kept.contains(&predicate) {
                kept.push(predicate);
            }
        }
        if kept.is_empty() { Err(GoalError::Empty) } else { Ok(Self { predicates: kept }) }
    }

    /// At least one, each once, in the order of the instruction.
    pub fn predicates(&self) -> &[GoalPredicate] {
        &self.predicates
    }

    /// The objects that the robot moves, each once, in the order of the goal.
    pub fn moved_objects(&self) -> Vec<&InstanceId> {
        let mut seen = BTreeSet::new();
        let moved = self.predicates.iter().flat_map(|predicate| {
            let other = (predicate.predicate == PredicateKind::Swapped).then_some(predicate.target.as_ref());
            std::iter::once(&predicate.object).chain(other.flatten())
        });
        moved.filter(|name| seen.insert(*name)).collect()
    }

    /// Every object that the goal names, each once, in the order of the goal.
    pub fn named_objects(&self) -> Vec<&InstanceId> {
        let mut seen = BTreeSet::new();
        self.predicates.iter().flat_map(named).filter(|name| seen.insert(*name)).collect()
    }

    /// Whether the robot holds an object at the end, so that the gripper is not to let go.
    pub fn ends_in_hand(&self) -> bool {
        self.predicates.iter().any(|predicate| predicate.predicate == PredicateKind::Lifted)
    }
}

/// The objects of a predicate.
pub fn named(predicate: &GoalPredicate) -> impl Iterator<Item = &InstanceId> {
    std::iter::once(&predicate.object).chain(&predicate.target).chain(&predicate.second_target)
}

/// A predicate in words of its file names: "in(apple_1, bowl_1)".
pub fn formula(predicate: &GoalPredicate) -> String {
    let names: Vec<&str> = named(predicate).map(InstanceId::as_str).collect();
    format!("{}({})", name_of(predicate.predicate), names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(json: &str) -> Result<Goal, String> {
        serde_json::from_str(json).map_err(|error| error.to_string())
    }

    #[test]
    fn targets_are_checked_when_a_goal_is_read() {
        for (json, part) in [
            (r#"[]"#, "at least one predicate"),
            (r#"[{"predicate": "in", "object": "a"}]"#, "needs one target"),
            (r#"[{"predicate": "lifted", "object": "a", "target": "b"}]"#, "needs no target"),
            (r#"[{"predicate": "between", "object": "a", "target": "b"}]"#, "needs two targets"),
            (r#"[{"predicate": "on", "object": "a", "target": "a"}]"#, "to itself"),
            (r#"[{"predicate": "under", "object": "a", "target": "b"}]"#, "unknown variant"),
        ] {
            let error = read(json).expect_err(json);
            assert!(error.contains(part), "{json}: {error}");
        }
        let goal = read(r#"[{"predicate": "on", "object": "a"}, {"predicate": "on", "object": "a"}]"#);
        assert_eq!(goal.expect("on the table").predicates().len(), 1);
    }

    #[test]
    fn names_are_those_of_files() {
        let goal = read(r#"[{"predicate": "swapped", "object": "a", "target": "b"}]"#).expect("a goal");
        assert_eq!(goal.moved_objects().len(), 2);
        for kind in PredicateKind::ALL {
            let json = serde_json::to_value(kind).expect("serializes");
            assert_eq!(json.as_str(), Some(name_of(kind)));
        }
    }
}
