//! Refusals of tasks before anything is simulated.

use scene::InstanceId;
use serde::Serialize;

/// A refusal. [`Refusal::code`] is stable; the message states the correction.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Serialize)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum Refusal {
    #[error("there is no robot {robot:?}: use one of {}", .known.join(", "))]
    UnknownRobot { robot: String, known: Vec<String> },
    #[error("the scene has no {phrase:?}{}", nearest(.candidates))]
    AbsentObject { phrase: String, candidates: Vec<InstanceId> },
    #[error("{phrase:?} may be any of {}: name one of them, or add its color, size or place", list(.candidates))]
    AmbiguousReference { phrase: String, candidates: Vec<InstanceId> },
    #[error("in {phrase:?}, {} is not understood: use the object's name, label, color, size or place", quoted(.words))]
    ReferenceNotUnderstood { phrase: String, words: Vec<String> },
    #[error("{} of the instruction is not understood: reword it", quoted(.parts))]
    InstructionNotUnderstood { parts: Vec<String> },
    #[error("the robot does not perform {verb:?}; it can {performed}")]
    VerbNotPerformed { verb: String, performed: String },
    #[error(
        "the instruction has no goal that objects can reach: say what to put where, such as \"put the apple in the \
        bowl\""
    )]
    NoGoal,
    #[error("the goal is already reached ({}): ask for a change", .predicates.join(", "))]
    GoalAlreadyTrue { predicates: Vec<String> },
    #[error(
        "{predicate} cannot be decided from poses and contacts: use a predicate of places, supports or postures"
    )]
    PredicateNotSupported { predicate: String },
    #[error("{object} has no opening, so that nothing can be in it: use `on`, or a container")]
    NotAContainer { object: InstanceId },
    #[error("{first} and {second} cannot both hold: leave one out")]
    GoalConflict { first: String, second: String },
    #[error("{} do not fit {target} together: ask for fewer objects or a larger target", list(.objects))]
    TargetTooSmall { objects: Vec<InstanceId>, target: InstanceId },
    #[error("there is no free place for {predicate}: {reason}")]
    NoFreePlace { predicate: String, reason: String },
    #[error("{object} cannot be grasped by a parallel gripper: move another object")]
    NotGraspable { object: InstanceId },
    #[error(
        "{object} is {width_m:.3} m wide between its narrowest sides and has no narrower part to grasp; the gripper of \
        {robot} opens to {opening_m:.3} m, of which {margin_m:.3} m stay free, so it takes {:.3} m: use another robot or \
        object",
        .opening_m - .margin_m
    )]
    ObjectTooWide { object: InstanceId, robot: String, width_m: f64, opening_m: f64, margin_m: f64 },
    #[error("no grasp of {object} by {robot} held in simulation: use another robot or object")]
    NoGraspHeld { object: InstanceId, robot: String },
    #[error(
        "{object} weighs {mass_kg:.2} kg with what it carries, {robot} lifts {payload_kg:.2} kg: use another robot or \
        object"
    )]
    ObjectTooHeavy { object: InstanceId, robot: String, mass_kg: f64, payload_kg: f64 },
    #[error("the scene cannot be searched ({reason}): generate it again")]
    BrokenScene { reason: String },
}

impl Refusal {
    /// The stable code.
    pub fn code(&self) -> &'static str {
        match self {
            Self::UnknownRobot { .. } => "unknown_robot",
            Self::AbsentObject { .. } => "absent_object",
            Self::AmbiguousReference { .. } => "ambiguous_reference",
            Self::ReferenceNotUnderstood { .. } => "reference_not_understood",
            Self::InstructionNotUnderstood { .. } => "instruction_not_understood",
            Self::VerbNotPerformed { .. } => "verb_not_performed",
            Self::NoGoal => "no_goal",
            Self::GoalAlreadyTrue { .. } => "goal_already_true",
            Self::PredicateNotSupported { .. } => "predicate_not_supported",
            Self::NotAContainer { .. } => "not_a_container",
            Self::GoalConflict { .. } => "goal_conflict",
            Self::TargetTooSmall { .. } => "target_too_small",
            Self::NoFreePlace { .. } => "no_free_place",
            Self::NotGraspable { .. } => "not_graspable",
            Self::ObjectTooWide { .. } => "object_too_wide",
            Self::NoGraspHeld { .. } => "no_grasp",
            Self::ObjectTooHeavy { .. } => "object_too_heavy",
            Self::BrokenScene { .. } => "broken_scene",
        }
    }
}

fn list(names: &[InstanceId]) -> String {
    names.iter().map(InstanceId::as_str).collect::<Vec<_>>().join(", ")
}

fn nearest(names: &[InstanceId]) -> String {
    if names.is_empty() { String::new() } else { format!(": it has {}", list(names)) }
}

fn quoted(words: &[String]) -> String {
    words.iter().map(|word| format!("{word:?}")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_is_the_tag_of_the_file() {
        let id = InstanceId::new("mug_1").expect("a name");
        for refusal in [
            Refusal::NoGoal,
            Refusal::NotAContainer { object: id.clone() },
            Refusal::AbsentObject { phrase: "the mug".into(), candidates: vec![id] },
        ] {
            let json = serde_json::to_value(&refusal).expect("serializes");
            assert_eq!(json["code"].as_str(), Some(refusal.code()));
        }
    }
}
