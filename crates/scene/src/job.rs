//! A job is an operation on a scene; its state says what the machine is doing.
//!
//! State moves in one place: [`JobState::after`], a pure table. The store reads the state, asks the
//! table and writes the answer in one transaction, so no row ever makes a move that is not listed here.
//! Nothing here knows SQL or HTTP.

use std::fmt;

use serde::{Deserialize, Serialize};

pub use crate::SceneRequest;

/// What the machine is doing with a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JobState {
    /// Waits for a worker (or for its `not_before`).
    Queued,
    /// A worker holds its lease.
    Running,
    /// Somebody asked to stop it; its worker has yet to let go.
    Cancelling,
    Succeeded,
    Failed,
    Cancelled,
}

/// What may happen to a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobEvent {
    /// A worker took it: from the queue, or from a worker whose lease ran out.
    Claimed,
    /// A client asked to stop it.
    CancelRequested,
    /// Its worker finished the work.
    Succeeded,
    /// Its worker gave it up for good.
    Failed,
    /// Its worker failed in a way that may pass; it goes back to the queue.
    RetryScheduled,
    /// Its worker is shutting down; it goes back to the queue, uncharged.
    Released,
    /// Its worker stopped because of a cancellation.
    Stopped,
}

/// The event cannot happen to a job in this state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a job that is {state} cannot take the event {event:?}")]
pub struct InvalidTransition {
    pub state: JobState,
    pub event: JobEvent,
}

impl JobState {
    pub const ALL: [Self; 6] =
        [Self::Queued, Self::Running, Self::Cancelling, Self::Succeeded, Self::Failed, Self::Cancelled];

    /// The state after `event`. Once cancelling, the only way out is cancelled; a final state stays.
    pub fn after(self, event: JobEvent) -> Result<Self, InvalidTransition> {
        use JobEvent as E;
        use JobState as S;
        match (self, event) {
            (S::Queued, E::Claimed) => Ok(S::Running),
            (S::Queued, E::CancelRequested) => Ok(S::Cancelled),

            (S::Running, E::Claimed) => Ok(S::Running),
            (S::Running, E::CancelRequested) => Ok(S::Cancelling),
            (S::Running, E::Succeeded) => Ok(S::Succeeded),
            (S::Running, E::Failed) => Ok(S::Failed),
            (S::Running, E::RetryScheduled | E::Released) => Ok(S::Queued),

            (S::Cancelling, E::Claimed | E::CancelRequested) => Ok(S::Cancelling),
            (S::Cancelling, E::Stopped | E::Succeeded | E::Failed | E::RetryScheduled | E::Released) => {
                Ok(S::Cancelled)
            }

            (S::Cancelled, E::CancelRequested) => Ok(S::Cancelled),

            (S::Queued, _) | (S::Running, E::Stopped) | (S::Succeeded | S::Failed | S::Cancelled, _) => {
                Err(InvalidTransition { state: self, event })
            }
        }
    }

    /// Nothing more happens to it.
    pub fn is_final(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Cancelled)
    }

    pub fn as_str(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Cancelling => "cancelling",
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    /// Inverse of [`Self::as_str`].
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.as_str() == text)
    }
}

impl fmt::Display for JobState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// Whether a scene can be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SceneState {
    /// A job is to make it, or is making it.
    Pending,
    /// Its bundle may be used.
    Ready,
    /// No bundle, or one whose certificate says `quarantine` (code `quarantined`).
    Failed,
    Deleted,
}

impl SceneState {
    pub const ALL: [Self; 4] = [Self::Pending, Self::Ready, Self::Failed, Self::Deleted];

    pub fn as_str(self) -> &'static str {
        match self {
            Self::Pending => "pending",
            Self::Ready => "ready",
            Self::Failed => "failed",
            Self::Deleted => "deleted",
        }
    }

    /// Inverse of [`Self::as_str`].
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.as_str() == text)
    }
}

/// Why a job failed, which decides whether and when it is tried again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureClass {
    /// May pass by itself (network, overload): tried again, soon.
    Transient,
    /// A provider asked for patience: tried again when it says; burns no attempt.
    RateLimited,
    /// The same request fails the same way.
    Permanent,
    /// A provider, or we, will not do this request.
    Refused,
    /// The request's budget is spent.
    OverBudget,
    /// The worker died or panicked on it: tried again, but not for ever.
    Crashed,
}

impl FailureClass {
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Transient => "transient",
            Self::RateLimited => "rate_limited",
            Self::Permanent => "permanent",
            Self::Refused => "refused",
            Self::OverBudget => "over_budget",
            Self::Crashed => "crashed",
        }
    }

    /// Trying again can help.
    pub fn is_retryable(self) -> bool {
        matches!(self, Self::Transient | Self::RateLimited | Self::Crashed)
    }
}

/// What a client is told about a failure.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    pub class: FailureClass,
    /// Stable, `[a-z0-9_]+`.
    pub code: String,
    /// A sentence, and what to do.
    pub message: String,
}

#[cfg(test)]
mod tests {
    use super::*;
    use JobEvent as E;
    use JobState as S;

    const EVENTS: [E; 7] =
        [E::Claimed, E::CancelRequested, E::Succeeded, E::Failed, E::RetryScheduled, E::Released, E::Stopped];

    #[test]
    fn the_whole_grid_of_states_and_events() {
        // One row a state, one column an event, in the order of EVENTS; None = refused.
        let grid: [(S, [Option<S>; 7]); 6] = [
            (S::Queued, [Some(S::Running), Some(S::Cancelled), None, None, None, None, None]),
            (
                S::Running,
                [
                    Some(S::Running),
                    Some(S::Cancelling),
                    Some(S::Succeeded),
                    Some(S::Failed),
                    Some(S::Queued),
                    Some(S::Queued),
                    None,
                ],
            ),
            (
                S::Cancelling,
                [
                    Some(S::Cancelling),
                    Some(S::Cancelling),
                    Some(S::Cancelled),
                    Some(S::Cancelled),
                    Some(S::Cancelled),
                    Some(S::Cancelled),
                    Some(S::Cancelled),
                ],
            ),
            (S::Succeeded, [None; 7]),
            (S::Failed, [None; 7]),
            (S::Cancelled, [None, Some(S::Cancelled), None, None, None, None, None]),
        ];
        for (state, row) in grid {
            for (event, expected) in EVENTS.into_iter().zip(row) {
                assert_eq!(state.after(event).ok(), expected, "{state} after {event:?}");
                if state.is_final() {
                    assert!(state.after(event).is_err() || state.after(event) == Ok(state));
                }
            }
        }
    }

    #[test]
    fn names_round_trip() {
        for state in S::ALL {
            assert_eq!(S::parse(state.as_str()), Some(state));
        }
        for state in SceneState::ALL {
            assert_eq!(SceneState::parse(state.as_str()), Some(state));
        }
        assert_eq!(S::parse("Queued"), None);
    }
}
