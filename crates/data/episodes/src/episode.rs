//! Facts about an episode besides its frames.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Identity of an episode, and the record from which it can be made again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeHeader {
    /// The number of the attempt. Datasets take episodes in ascending numbers, number them anew without gaps, and
    /// state this number beside the new one.
    pub number: u64,
    pub seed: u64,
    /// The place of its task in the description.
    pub task: usize,
    /// From this the caller can make the episode again. It is written as it is.
    pub record: Value,
}

/// Result of an episode.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "outcome")]
pub enum Outcome {
    Success,
    Failure { reason: String },
}

impl Outcome {
    pub fn is_success(&self) -> bool {
        *self == Self::Success
    }

    /// `success`, or the reason of the failure.
    pub fn label(&self) -> &str {
        match self {
            Self::Success => "success",
            Self::Failure { reason } => reason,
        }
    }
}
