//! States of requests, and how many requests are in each.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::request::MAX_REQUESTS;

/// State of a request of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RequestState {
    /// Not begun.
    Pending,
    /// A worker builds its scene.
    Running,
    /// The scene is certified `pass`.
    Succeeded,
    /// There is no scene.
    Failed,
    /// The scene is certified `quarantine`: it may be inspected, and not trained on.
    Quarantined,
    Cancelled,
    /// Another request of the batch asks for the same scene.
    Duplicate,
    /// Line that cannot be read, or a value in it that is out of range.
    Invalid,
}

impl RequestState {
    pub const ALL: [Self; 8] = [
        Self::Pending,
        Self::Running,
        Self::Succeeded,
        Self::Failed,
        Self::Quarantined,
        Self::Cancelled,
        Self::Duplicate,
        Self::Invalid,
    ];

    /// Whether nothing more is done for the request.
    pub fn is_final(self) -> bool {
        !matches!(self, Self::Pending | Self::Running)
    }

    /// Inverse of [`Self::as_str`].
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.as_str() == text)
    }

    /// The word of the JSON form.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Pending => "pending",
            Self::Running => "running",
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Quarantined => "quarantined",
            Self::Cancelled => "cancelled",
            Self::Duplicate => "duplicate",
            Self::Invalid => "invalid",
        }
    }
}

/// Number of requests in each state; `total` is their sum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct RequestCounts {
    #[schemars(range(min = 0, max = MAX_REQUESTS))]
    pub total: u64,
    #[schemars(range(min = 0, max = MAX_REQUESTS))]
    pub pending: u64,
    #[schemars(range(min = 0, max = MAX_REQUESTS))]
    pub running: u64,
    #[schemars(range(min = 0, max = MAX_REQUESTS))]
    pub succeeded: u64,
    #[schemars(range(min = 0, max = MAX_REQUESTS))]
    pub failed: u64,
    #[schemars(range(min = 0, max = MAX_REQUESTS))]
    pub quarantined: u64,
    #[schemars(range(min = 0, max = MAX_REQUESTS))]
    pub cancelled: u64,
    #[schemars(range(min = 0, max = MAX_REQUESTS))]
    pub duplicate: u64,
    #[schemars(range(min = 0, max = MAX_REQUESTS))]
    pub invalid: u64,
}

impl RequestCounts {
    /// Counts a further request.
    pub fn add(&mut self, state: RequestState) {
        self.add_many(state, 1);
    }

    /// Counts so many further requests.
    pub fn add_many(&mut self, state: RequestState, count: u64) {
        self.total += count;
        *self.of(state) += count;
    }

    /// Counts a request that went from one state to another.
    pub fn change(&mut self, from: RequestState, to: RequestState) {
        let before = self.of(from);
        *before = before.saturating_sub(1);
        *self.of(to) += 1;
    }

    /// Requests that are computed or were.
    pub fn computed(&self) -> u64 {
        self.total - self.duplicate - self.invalid
    }

    /// Requests that are still to be computed.
    pub fn remaining(&self) -> u64 {
        self.pending + self.running
    }

    /// Requests that were computed to their end.
    pub fn finished(&self) -> u64 {
        self.computed() - self.remaining()
    }

    /// Whether every request has a scene that passes, its own or that of the request which it duplicates.
    pub fn all_succeeded(&self) -> bool {
        self.succeeded + self.duplicate == self.total
    }

    fn of(&mut self, state: RequestState) -> &mut u64 {
        match state {
            RequestState::Pending => &mut self.pending,
            RequestState::Running => &mut self.running,
            RequestState::Succeeded => &mut self.succeeded,
            RequestState::Failed => &mut self.failed,
            RequestState::Quarantined => &mut self.quarantined,
            RequestState::Cancelled => &mut self.cancelled,
            RequestState::Duplicate => &mut self.duplicate,
            RequestState::Invalid => &mut self.invalid,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use RequestState as S;

    fn sum(counts: &RequestCounts) -> u64 {
        let document = serde_json::to_value(counts).expect("JSON");
        S::ALL.iter().map(|state| document[state.as_str()].as_u64().expect("a count")).sum()
    }

    #[test]
    fn the_total_is_the_sum_of_all_states() {
        let mut counts = RequestCounts::default();
        for (k, state) in S::ALL.into_iter().enumerate() {
            (0..=k).for_each(|_| counts.add(state));
        }
        assert_eq!((counts.total, sum(&counts)), (36, 36));
        for from in S::ALL {
            for to in S::ALL {
                let mut changed = counts;
                changed.change(from, to);
                assert_eq!((changed.total, sum(&changed)), (36, 36), "{from:?} to {to:?}");
            }
        }
        assert_eq!((counts.computed(), counts.remaining(), counts.finished()), (21, 3, 18));
    }

    #[test]
    fn a_batch_succeeds_if_every_request_has_a_scene_that_passes() {
        let counts = |states: &[S]| {
            let mut counts = RequestCounts::default();
            states.iter().for_each(|state| counts.add(*state));
            counts
        };
        assert!(counts(&[S::Succeeded, S::Duplicate]).all_succeeded());
        for state in [S::Pending, S::Running, S::Failed, S::Quarantined, S::Cancelled, S::Invalid] {
            assert!(!counts(&[S::Succeeded, state]).all_succeeded(), "{state:?}");
        }
    }

    #[test]
    fn words_of_states_are_those_of_json() {
        for state in S::ALL {
            assert_eq!(serde_json::to_value(state).expect("JSON"), state.as_str());
            assert_eq!(S::parse(state.as_str()), Some(state));
        }
    }
}
