//! The account of a text in words for people: meanings, reasons, conditions of a goal, and demands that are not met.

use std::fmt;

use serde::Serialize;

use super::{GoalPredicate, PredicateKind, TextMeaning, UnrecognizedReason};
use crate::InstanceId;
use crate::predicates::{Unmet, UnmetDemand};

/// `mug_1 left of plate_1`.
impl fmt::Display for GoalPredicate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let targets: Vec<&InstanceId> = self.target.iter().chain(&self.second_target).collect();
        let predicate = match self.predicate {
            PredicateKind::Swapped => "swapped with".to_owned(),
            predicate => words(predicate),
        };
        f.write_str(&joined(&[self.object.to_string(), predicate, names(&targets, " and ")]))
    }
}

/// `2 × mug: mug_1, mug_2`.
impl fmt::Display for TextMeaning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Object { category, objects } => {
                write!(f, "{} × {}: {}", objects.len(), category_in_words(category), names(objects, ", "))
            }
            Self::Property { property, value, objects } => {
                write!(f, "{} {value}: {}", property.replace('_', " "), names(objects, ", "))
            }
            Self::Relation { relation, objects, targets } => {
                f.write_str(&related(objects, &words(relation), targets))
            }
            Self::Arrangement { objects, .. } => write!(f, "an arrangement: {}", names(objects, ", ")),
            Self::Exclusion { categories } => {
                let categories: Vec<String> = categories.iter().map(|name| category_in_words(name)).collect();
                write!(f, "no {}", categories.join(", "))
            }
            Self::Goal { index } => write!(f, "condition {} of the goal", index + 1),
            Self::Table => f.write_str("the table"),
            Self::Theme { theme } => write!(f, "the theme {}", theme.replace('_', " ")),
            Self::Completion { complete: true } => f.write_str("the theme completes the scene"),
            Self::Completion { complete: false } => f.write_str("nothing beyond the named objects"),
            Self::Correction { corrected } => write!(f, "read as \"{corrected}\""),
        }
    }
}

impl fmt::Display for UnrecognizedReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::UnknownObject => "unknown object",
            Self::UnknownWord => "unknown word",
            Self::NotPlaceable => "nothing that stands on a table",
            Self::OutOfRange => "out of the supported range",
            Self::NotSupported => "the objects cannot have it",
            Self::Contradiction => "contradicts an earlier part",
            Self::NoReferent => "refers to no object of the text",
            Self::NotExpressible => "says more than can be expressed",
            Self::NotInImage => "not found in the image",
            Self::ShownByImage => "the image decides it",
        })
    }
}

/// `mug_1 left of plate_1, at 20 cm`.
impl fmt::Display for Unmet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let objects = names(&self.objects, ", ");
        match &self.demand {
            UnmetDemand::Relation { relation, targets, distance_m } => {
                f.write_str(&related(&self.objects, &words(relation), targets))?;
                distance_m.map_or(Ok(()), |distance_m| write!(f, ", at {} cm", centimeters(distance_m)))
            }
            UnmetDemand::Arrangement { arrangement, .. } => {
                let kind = serde_json::to_value(arrangement).unwrap_or_default();
                write!(f, "{objects} in a {}", kind["arrangement"].as_str().unwrap_or("group"))
            }
            UnmetDemand::Yaw { yaw_rad } => write!(f, "{objects} rotated by {:.0}°", yaw_rad.to_degrees()),
            UnmetDemand::Position { x_m, y_m } => write!(f, "{objects} at x = {x_m} m, y = {y_m} m"),
        }
    }
}

/// Objects, a relation and its targets; without targets, the relation is to the table.
fn related(objects: &[InstanceId], relation: &str, targets: &[InstanceId]) -> String {
    let targets = match targets {
        [] if matches!(relation, "on" | "in") => "the table".to_owned(),
        targets => names(targets, " and "),
    };
    joined(&[names(objects, ", "), relation.to_owned(), targets])
}

/// The parts that are not empty, with spaces between them.
fn joined(parts: &[String]) -> String {
    let parts: Vec<&str> = parts.iter().map(String::as_str).filter(|part| !part.is_empty()).collect();
    parts.join(" ")
}

fn names(ids: &[impl ToString], separator: &str) -> String {
    ids.iter().map(ToString::to_string).collect::<Vec<_>>().join(separator)
}

/// A category by its name; the hidden categories of stand-ins are named after their shape.
fn category_in_words(name: &str) -> String {
    match name.strip_prefix("stand_in_") {
        Some(shape) => format!("stand-in ({})", shape.replace('_', " ")),
        None => name.replace('_', " "),
    }
}

/// The serialized name of an enumeration's value, with spaces.
fn words(value: impl Serialize) -> String {
    let name = serde_json::to_value(value).unwrap_or_default();
    name.as_str().unwrap_or_default().replace('_', " ")
}

/// Centimeters with at most one decimal.
fn centimeters(length_m: f64) -> f64 {
    (1e3 * length_m).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{ArrangementKind, RelationKind};

    fn id(name: &str) -> InstanceId {
        InstanceId::new(name).expect("a name")
    }

    fn ids(names: &[&str]) -> Vec<InstanceId> {
        names.iter().map(|name| id(name)).collect()
    }

    #[test]
    fn conditions_of_a_goal_are_phrases() {
        let condition = |predicate, targets: &[&str]| {
            let targets = ids(targets);
            let (target, second_target) = (targets.first().cloned(), targets.get(1).cloned());
            GoalPredicate { predicate, object: id("mug_1"), target, second_target }.to_string()
        };
        for (found, expected) in [
            (condition(PredicateKind::In, &["bowl_1"]), "mug_1 in bowl_1"),
            (condition(PredicateKind::LeftOf, &["plate_1"]), "mug_1 left of plate_1"),
            (condition(PredicateKind::Between, &["a", "b"]), "mug_1 between a and b"),
            (condition(PredicateKind::Swapped, &["cup_1"]), "mug_1 swapped with cup_1"),
            (condition(PredicateKind::AtBackLeft, &[]), "mug_1 at back left"),
            (condition(PredicateKind::Lifted, &[]), "mug_1 lifted"),
        ] {
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn meanings_are_phrases() {
        let objects = ids(&["mug_1", "mug_2"]);
        let object =
            |category: &str| TextMeaning::Object { category: category.into(), objects: objects.clone() };
        let relation = |relation, targets: &[&str]| TextMeaning::Relation {
            relation,
            objects: ids(&["mug_1"]),
            targets: ids(targets),
        };
        let property =
            TextMeaning::Property { property: "color".into(), value: "red".into(), objects: objects.clone() };
        for (meaning, expected) in [
            (object("coffee_mug"), "2 × coffee mug: mug_1, mug_2"),
            (object("stand_in_flat_box"), "2 × stand-in (flat box): mug_1, mug_2"),
            (property, "color red: mug_1, mug_2"),
            (relation(RelationKind::RightOf, &["bowl_1"]), "mug_1 right of bowl_1"),
            (relation(RelationKind::On, &[]), "mug_1 on the table"),
            (relation(RelationKind::AtCenter, &[]), "mug_1 at center"),
            (TextMeaning::Arrangement { index: 0, objects: objects.clone() }, "an arrangement: mug_1, mug_2"),
            (TextMeaning::Exclusion { categories: vec!["fork".into(), "knife".into()] }, "no fork, knife"),
            (TextMeaning::Goal { index: 1 }, "condition 2 of the goal"),
            (TextMeaning::Table, "the table"),
            (TextMeaning::Theme { theme: "hobby_desk".into() }, "the theme hobby desk"),
            (TextMeaning::Completion { complete: true }, "the theme completes the scene"),
            (TextMeaning::Completion { complete: false }, "nothing beyond the named objects"),
            (TextMeaning::Correction { corrected: "apple".into() }, "read as \"apple\""),
        ] {
            assert_eq!(meaning.to_string(), expected);
        }
    }

    #[test]
    fn unmet_demands_are_phrases() {
        let unmet = |objects: &[&str], demand| Unmet { objects: ids(objects), demand }.to_string();
        let relation = |relation, targets: &[&str], distance_m| UnmetDemand::Relation {
            relation,
            targets: ids(targets),
            distance_m,
        };
        let grid = UnmetDemand::Arrangement { index: 0, arrangement: ArrangementKind::Grid { columns: 2 } };
        let yaw = UnmetDemand::Yaw { yaw_rad: std::f64::consts::FRAC_PI_4 };
        let position = UnmetDemand::Position { x_m: 0.2, y_m: -0.1 };
        for (found, expected) in [
            (
                unmet(&["mug_1"], relation(RelationKind::LeftOf, &["plate_1"], Some(0.2))),
                "mug_1 left of plate_1, at 20 cm",
            ),
            (unmet(&["mug_1"], relation(RelationKind::AtFrontLeft, &[], None)), "mug_1 at front left"),
            (unmet(&["mug_1", "mug_2"], grid), "mug_1, mug_2 in a grid"),
            (unmet(&["mug_1"], yaw), "mug_1 rotated by 45°"),
            (unmet(&["mug_1"], position), "mug_1 at x = 0.2 m, y = -0.1 m"),
        ] {
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn every_reason_has_its_own_words() {
        use UnrecognizedReason as Reason;
        let reasons = [
            Reason::UnknownObject,
            Reason::UnknownWord,
            Reason::NotPlaceable,
            Reason::OutOfRange,
            Reason::NotSupported,
            Reason::Contradiction,
            Reason::NoReferent,
            Reason::NotExpressible,
            Reason::NotInImage,
            Reason::ShownByImage,
        ];
        let words: std::collections::BTreeSet<String> = reasons.iter().map(ToString::to_string).collect();
        assert_eq!(words.len(), reasons.len());
    }
}
