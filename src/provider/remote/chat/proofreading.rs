//! What would be wrong with a model's words as the answer to a question, without asking anybody: shows whether a model is up to
//! the questions, and how the reading of answers stands what nobody would say.

use super::conversation::complaints_of;
use super::{check_top, describe, measure, recognize, stacking};
use crate::scene::{InstanceId, TableSpec};

/// What a chat model is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuestionKind {
    Describe,
    Recognize,
    Measure,
    Stacking,
    CheckTop,
}

impl QuestionKind {
    pub const ALL: [Self; 5] =
        [Self::Describe, Self::Recognize, Self::Measure, Self::Stacking, Self::CheckTop];

    /// What a model would be told of these words as the answer about the things `asked`; nothing where they are taken.
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
        }
    }
}
