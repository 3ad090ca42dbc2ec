//! State of a whole batch.

use serde::{Deserialize, Serialize};

/// State of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BatchState {
    /// Requests wait, or are worked on.
    Running,
    /// Cancellation was requested, and some requests have not stopped yet.
    Cancelling,
    /// Every request came to its end.
    Finished,
    /// Every request came to its end, after a cancellation.
    Cancelled,
}

impl BatchState {
    pub const ALL: [Self; 4] = [Self::Running, Self::Cancelling, Self::Finished, Self::Cancelled];

    /// Whether nothing more happens unless the batch is retried.
    pub fn is_final(self) -> bool {
        matches!(self, Self::Finished | Self::Cancelled)
    }

    /// The state when the last request has come to its end.
    pub fn ended(self) -> Self {
        match self {
            Self::Running | Self::Finished => Self::Finished,
            Self::Cancelling | Self::Cancelled => Self::Cancelled,
        }
    }

    /// The word of the JSON form.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Running => "running",
            Self::Cancelling => "cancelling",
            Self::Finished => "finished",
            Self::Cancelled => "cancelled",
        }
    }

    /// Inverse of [`Self::as_str`].
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.as_str() == text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_states_are_those_of_json_and_read_back() {
        for state in BatchState::ALL {
            assert_eq!(serde_json::to_value(state).expect("JSON"), state.as_str());
            assert_eq!(BatchState::parse(state.as_str()), Some(state));
            assert!(state.ended().is_final());
        }
        assert_eq!(BatchState::parse("receiving"), None, "which is no state that a client sees");
    }
}
