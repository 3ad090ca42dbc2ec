//! From a goal to the order in which objects are moved.

use scene::InstanceId;
use tasks::{Goal, GoalPredicate, PredicateKind};

/// One object that is moved once.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// To a place where all these predicates hold.
    Place { object: InstanceId, predicates: Vec<GoalPredicate> },
    /// To any free place, away from where it and another object were at the start.
    SetAside { object: InstanceId, other: InstanceId },
    /// To the place of another object at the start.
    TakePlaceOf { object: InstanceId, other: InstanceId },
    /// Up, and it is held there.
    Lift { object: InstanceId },
}

impl Step {
    pub fn object(&self) -> &InstanceId {
        match self {
            Self::Place { object, .. }
            | Self::SetAside { object, .. }
            | Self::TakePlaceOf { object, .. }
            | Self::Lift { object } => object,
        }
    }

    /// Predicates that the step brings about; none for steps that only make room.
    pub fn predicates(&self) -> &[GoalPredicate] {
        match self {
            Self::Place { predicates, .. } => predicates,
            Self::SetAside { .. } | Self::TakePlaceOf { .. } | Self::Lift { .. } => &[],
        }
    }
}

/// The steps of a goal: what others shall rest on or stand beside is moved first, and what is lifted last. Objects that
/// change places need a third place.
pub fn steps(goal: &Goal) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut waiting: Vec<(InstanceId, Vec<GoalPredicate>)> = Vec::new();
    let mut lifted = Vec::new();
    for predicate in goal.predicates() {
        let object = predicate.object.clone();
        match (predicate.predicate, &predicate.target) {
            (PredicateKind::Swapped, Some(target)) => steps.extend([
                Step::SetAside { object: object.clone(), other: target.clone() },
                Step::TakePlaceOf { object: target.clone(), other: object.clone() },
                Step::TakePlaceOf { object, other: target.clone() },
            ]),
            (PredicateKind::Lifted, _) => lifted.push(Step::Lift { object }),
            _ => match waiting.iter_mut().find(|(name, _)| *name == object) {
                Some((_, predicates)) => predicates.push(predicate.clone()),
                None => waiting.push((object, vec![predicate.clone()])),
            },
        }
    }
    while !waiting.is_empty() {
        let waits = |predicates: &[GoalPredicate]| {
            let targets = predicates.iter().flat_map(|p| p.target.iter().chain(&p.second_target));
            targets.into_iter().any(|target| waiting.iter().any(|(name, _)| name == target))
        };
        // Where objects wait for each other the first one goes.
        let next = waiting.iter().position(|(_, predicates)| !waits(predicates)).unwrap_or(0);
        let (object, predicates) = waiting.remove(next);
        // What is lifted at the end is not put down before.
        if !lifted.iter().any(|step: &Step| *step.object() == object) {
            steps.push(Step::Place { object, predicates });
        }
    }
    steps.extend(lifted);
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    fn goal(json: &str) -> Goal {
        serde_json::from_str(json).expect("a goal")
    }

    fn order(json: &str) -> Vec<String> {
        steps(&goal(json)).iter().map(|step| step.object().as_str().to_owned()).collect()
    }

    #[test]
    fn stacks_are_built_from_below() {
        let stack = r#"[{"predicate": "stacked_on", "object": "red_1", "target": "blue_1"},
            {"predicate": "on", "object": "blue_1", "target": "plate_1"}]"#;
        assert_eq!(order(stack), ["blue_1", "red_1"]);
    }

    #[test]
    fn swaps_take_three_steps() {
        let swap = r#"[{"predicate": "swapped", "object": "cup_1", "target": "apple_1"}]"#;
        assert_eq!(order(swap), ["cup_1", "apple_1", "cup_1"]);
        assert!(matches!(steps(&goal(swap))[0], Step::SetAside { .. }));
    }

    #[test]
    fn what_is_lifted_comes_last_and_is_moved_once() {
        let both = r#"[{"predicate": "lifted", "object": "cup_1"}, {"predicate": "upright", "object": "cup_1"},
            {"predicate": "next_to", "object": "box_1", "target": "cup_1"}]"#;
        assert_eq!(order(both), ["box_1", "cup_1"]);
    }
}
