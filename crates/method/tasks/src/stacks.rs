//! Several objects that are to be stacked on one: a pile, not one place for all of them.

use scene::text_account::{GoalPredicate, PredicateKind};

/// "stack the two blocks on the plate": of several objects stacked on the same target, the first is on it and each
/// other one is stacked on the one before.
pub(crate) fn chained(predicates: Vec<GoalPredicate>) -> Vec<GoalPredicate> {
    let shares_target = |predicate: &GoalPredicate| {
        let same = |other: &&GoalPredicate| {
            other.predicate == PredicateKind::StackedOn && other.target == predicate.target
        };
        predicates.iter().filter(same).count() > 1
    };
    let mut chained: Vec<GoalPredicate> = Vec::with_capacity(predicates.len());
    let mut tops: Vec<(Option<scene::InstanceId>, scene::InstanceId)> = Vec::new();
    for predicate in &predicates {
        let mut predicate = predicate.clone();
        if predicate.predicate == PredicateKind::StackedOn && shares_target(&predicate) {
            let base = predicate.target.clone();
            let object = predicate.object.clone();
            match tops.iter_mut().find(|(target, _)| *target == base) {
                Some((_, top)) => predicate.target = Some(std::mem::replace(top, object)),
                None => {
                    predicate.predicate = PredicateKind::On;
                    tops.push((base, object));
                }
            }
        }
        chained.push(predicate);
    }
    chained
}

#[cfg(test)]
mod tests {
    use super::*;

    fn predicates(json: &str) -> Vec<GoalPredicate> {
        serde_json::from_str(json).expect("predicates")
    }

    #[test]
    fn several_on_one_target_become_a_pile() {
        let given = r#"[{"predicate": "stacked_on", "object": "block_1", "target": "plate_1"},
            {"predicate": "stacked_on", "object": "block_2", "target": "plate_1"},
            {"predicate": "stacked_on", "object": "block_3", "target": "plate_1"}]"#;
        let expected = r#"[{"predicate": "on", "object": "block_1", "target": "plate_1"},
            {"predicate": "stacked_on", "object": "block_2", "target": "block_1"},
            {"predicate": "stacked_on", "object": "block_3", "target": "block_2"}]"#;
        assert_eq!(chained(predicates(given)), predicates(expected));
    }

    #[test]
    fn one_on_a_target_and_a_stated_pile_stay() {
        let given = r#"[{"predicate": "stacked_on", "object": "block_1", "target": "plate_1"},
            {"predicate": "stacked_on", "object": "block_2", "target": "block_1"},
            {"predicate": "in", "object": "spoon_1", "target": "mug_1"}]"#;
        assert_eq!(chained(predicates(given)), predicates(given));
    }
}
