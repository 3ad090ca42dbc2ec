//! Checks a model's response to a question without a call: for evaluating models, and for fuzzing the parser of
//! answers.

use super::repair_turn::complaints_of;
use super::{check_top, describe, judge, measure, propose_tasks, recognize, stacking, upright};
use ports::TaskObject;
use scene::appraisal::Criterion;
use scene::instance::SupportRelation;
use scene::{InstanceId, TableSpec};

/// The questions to a chat model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuestionKind {
    Describe,
    Recognize,
    Measure,
    Stacking,
    CheckTop,
    Upright,
    JudgeImage,
    JudgeText,
    ProposeTasks,
}

impl QuestionKind {
    pub const ALL: [Self; 9] = [
        Self::Describe,
        Self::Recognize,
        Self::Measure,
        Self::Stacking,
        Self::CheckTop,
        Self::Upright,
        Self::JudgeImage,
        Self::JudgeText,
        Self::ProposeTasks,
    ];

    /// The violations in a response about the objects `asked`; empty where it is accepted.
    pub fn complaints(self, response: &str, asked: &[InstanceId]) -> Vec<String> {
        match self {
            Self::Describe => {
                let anything = TableSpec::default();
                complaints_of(response, |answer| describe::accepted(answer, "", 1, asked.len(), &anything))
            }
            Self::Recognize => complaints_of(response, |answer| recognize::accepted(answer, &[])),
            Self::Measure => complaints_of(response, |answer| measure::accepted(answer, asked)),
            Self::Stacking => complaints_of(response, |answer| stacking::accepted(&answer, asked)),
            Self::CheckTop => complaints_of(response, check_top::accepted),
            Self::Upright => complaints_of(response, upright::accepted),
            Self::JudgeImage => {
                complaints_of(response, |answer| judge::accepted(answer, &Criterion::OF_IMAGE))
            }
            Self::JudgeText => complaints_of(response, |answer| judge::accepted(answer, &Criterion::OF_TEXT)),
            Self::ProposeTasks => {
                let objects: Vec<TaskObject> = asked.iter().map(small_object).collect();
                complaints_of(response, |answer| propose_tasks::accepted(answer, &objects, asked.len()))
            }
        }
    }
}

/// A graspable object on the table; tasks are checked against its name.
fn small_object(name: &InstanceId) -> TaskObject {
    TaskObject {
        name: name.clone(),
        label: name.to_string(),
        material: None,
        size_m: [0.05; 3],
        mass_kg: 0.1,
        relation: SupportRelation::On,
        carried_by: "table".into(),
    }
}
