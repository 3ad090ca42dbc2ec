//! What would be wrong with a model's words as the answer to a question, without asking anybody: shows
//! whether a model is up to the questions, and how the reading of answers stands what nobody would say.

use super::conversation::complaints_of;
use super::{check_top, describe, judge, measure, propose_tasks, recognize, stacking, upright};
use ports::TaskThing;
use scene::appraisal::Criterion;
use scene::instance::SupportRelation;
use scene::{InstanceId, TableSpec};

/// What a chat model is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuestionKind {
    Describe,
    Recognize,
    Measure,
    Stacking,
    CheckTop,
    Upright,
    JudgePicture,
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
        Self::JudgePicture,
        Self::JudgeText,
        Self::ProposeTasks,
    ];

    /// What a model would be told of these words as the answer about the things `asked`; nothing where they
    /// are taken.
    pub fn complaints(self, words: &str, asked: &[InstanceId]) -> Vec<String> {
        match self {
            Self::Describe => {
                let anything = TableSpec::default();
                complaints_of(words, |answer| describe::accepted(answer, 1, asked.len(), &anything))
            }
            Self::Recognize => complaints_of(words, recognize::accepted),
            Self::Measure => complaints_of(words, |answer| measure::accepted(answer, asked)),
            Self::Stacking => complaints_of(words, |answer| stacking::accepted(&answer, asked)),
            Self::CheckTop => complaints_of(words, check_top::accepted),
            Self::Upright => complaints_of(words, upright::accepted),
            Self::JudgePicture => {
                complaints_of(words, |answer| judge::accepted(answer, &Criterion::OF_A_PICTURE))
            }
            Self::JudgeText => complaints_of(words, |answer| judge::accepted(answer, &Criterion::OF_A_TEXT)),
            Self::ProposeTasks => {
                let things: Vec<TaskThing> = asked.iter().map(small_thing).collect();
                complaints_of(words, |answer| propose_tasks::accepted(answer, &things, asked.len()))
            }
        }
    }
}

/// A thing on the table that can be taken: what tasks are checked against is its name.
fn small_thing(name: &InstanceId) -> TaskThing {
    TaskThing {
        name: name.clone(),
        label: name.to_string(),
        material: None,
        size_m: [0.05; 3],
        mass_kg: 0.1,
        relation: SupportRelation::On,
        carried_by: "table".into(),
    }
}
