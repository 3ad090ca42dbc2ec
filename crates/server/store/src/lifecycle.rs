//! Jobs and their state machine. A job is an operation that a worker carries out in the background.
//!
//! [`JobState::after`] is the complete transition table. The store reads the state, applies the table and writes the
//! result in one transaction, so every row follows the table.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Operation of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JobKind {
    /// The first job of a scene.
    Generate,
    /// A further job of a scene, after another one ended.
    Retry,
    /// Makes a version of a dataset.
    FreezeDataset,
    /// Compares every byte of a version with its manifest.
    VerifyDataset,
    /// Makes one attempt of a recording.
    RecordAttempt,
    /// Writes the dataset of a recording.
    AssembleRecording,
    /// A simulated robot does a task in a finished scene.
    ExecuteTask,
}

impl JobKind {
    pub const ALL: [Self; 7] = [
        Self::Generate,
        Self::Retry,
        Self::FreezeDataset,
        Self::VerifyDataset,
        Self::RecordAttempt,
        Self::AssembleRecording,
        Self::ExecuteTask,
    ];

    /// Whether the job builds a scene.
    pub fn builds_scene(self) -> bool {
        matches!(self, Self::Generate | Self::Retry)
    }

    pub fn as_str(self) -> &'static str {
        match self {
            Self::Generate => "generate",
            Self::Retry => "retry",
            Self::FreezeDataset => "freeze_dataset",
            Self::VerifyDataset => "verify_dataset",
            Self::RecordAttempt => "record_attempt",
            Self::AssembleRecording => "assemble_recording",
            Self::ExecuteTask => "execute_task",
        }
    }

    /// Inverse of [`Self::as_str`].
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.as_str() == text)
    }
}

/// State of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JobState {
    /// Waits for a worker or for its `not_before` time.
    Queued,
    /// A worker holds its lease.
    Running,
    /// Cancellation requested; the worker has not stopped yet.
    Cancelling,
    Succeeded,
    Failed,
    Cancelled,
}

/// Events of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobEvent {
    /// A worker claimed it from the queue.
    Claimed,
    /// Expiry of the worker's lease; the job returns to the queue.
    Orphaned,
    /// Deadline passed while the job waited.
    DeadlinePassed,
    /// A client requested cancellation.
    CancelRequested,
    /// Work finished by the worker.
    Succeeded,
    /// Permanent failure in the worker.
    Failed,
    /// Retryable error in the worker; the job returns to the queue.
    RetryScheduled,
    /// Shutdown of the worker; the job returns to the queue, and the attempt does not count.
    Released,
    /// Stop of the worker because of a cancellation.
    Stopped,
}

/// The event is invalid in this state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a job that is {state} cannot take the event {event:?}")]
pub struct InvalidTransition {
    pub state: JobState,
    pub event: JobEvent,
}

impl JobState {
    pub const ALL: [Self; 6] =
        [Self::Queued, Self::Running, Self::Cancelling, Self::Succeeded, Self::Failed, Self::Cancelled];

    /// The state after `event`. `Cancelling` can only become `Cancelled`; final states do not change.
    ///
    /// # Errors
    ///
    /// [`InvalidTransition`] if the event is invalid in this state.
    pub fn after(self, event: JobEvent) -> Result<Self, InvalidTransition> {
        use JobEvent as E;
        use JobState as S;
        match (self, event) {
            (S::Queued, E::Claimed) => Ok(S::Running),
            (S::Queued, E::CancelRequested) => Ok(S::Cancelled),
            (S::Queued, E::DeadlinePassed) => Ok(S::Failed),

            (S::Running, E::CancelRequested) => Ok(S::Cancelling),
            (S::Running, E::Succeeded) => Ok(S::Succeeded),
            (S::Running, E::Failed) => Ok(S::Failed),
            (S::Running, E::Orphaned | E::RetryScheduled | E::Released) => Ok(S::Queued),

            (S::Cancelling, E::CancelRequested) => Ok(S::Cancelling),
            (
                S::Cancelling,
                E::Orphaned | E::Stopped | E::Succeeded | E::Failed | E::RetryScheduled | E::Released,
            ) => Ok(S::Cancelled),

            (S::Cancelled, E::CancelRequested) => Ok(S::Cancelled),

            (S::Queued | S::Succeeded | S::Failed | S::Cancelled, _)
            | (S::Running, E::Claimed | E::DeadlinePassed | E::Stopped)
            | (S::Cancelling, E::Claimed | E::DeadlinePassed) => {
                Err(InvalidTransition { state: self, event })
            }
        }
    }

    /// Whether the state is final.
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

/// State of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SceneState {
    /// Scene whose job is queued or running.
    Pending,
    /// Scene whose bundle is ready for use.
    Ready,
    /// There is no bundle, or its certificate says `quarantine` (code `quarantined`).
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

/// Class of a failure. It decides whether and when the job is retried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureClass {
    /// Temporary (network, overload): retried soon.
    Transient,
    /// A provider's rate limit: retried at the time it states; the attempt does not count.
    RateLimited,
    /// The same request always fails.
    Permanent,
    /// A provider or this service refuses the request.
    Refused,
    /// The request's budget is spent.
    OverBudget,
    /// The worker died or panicked: retried a limited number of times.
    Crashed,
}

impl FailureClass {
    pub const ALL: [Self; 6] =
        [Self::Transient, Self::RateLimited, Self::Permanent, Self::Refused, Self::OverBudget, Self::Crashed];

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

    /// Inverse of [`Self::as_str`].
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|class| class.as_str() == text)
    }

    /// Whether a retry can succeed.
    pub fn is_retryable(self) -> bool {
        matches!(self, Self::Transient | Self::RateLimited | Self::Crashed)
    }
}

/// A failure as reported to clients.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    pub class: FailureClass,
    /// Stable, `[a-z0-9_]+`.
    pub code: String,
    /// A sentence with advice.
    pub message: String,
}

impl Failure {
    /// The job did not end by its deadline.
    pub fn deadline_passed() -> Self {
        Self {
            class: FailureClass::Permanent,
            code: "deadline_passed".into(),
            message: "the job did not end by its deadline; submit it again with a later one".into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use JobEvent as E;
    use JobState as S;

    const EVENTS: [E; 9] = [
        E::Claimed,
        E::CancelRequested,
        E::Succeeded,
        E::Failed,
        E::RetryScheduled,
        E::Released,
        E::Stopped,
        E::Orphaned,
        E::DeadlinePassed,
    ];

    #[test]
    fn after_matches_the_complete_transition_table() {
        // One row per state, one column per event in the order of EVENTS; None = invalid.
        let cancelled = Some(S::Cancelled);
        let grid: [(S, [Option<S>; 9]); 6] = [
            (S::Queued, [Some(S::Running), cancelled, None, None, None, None, None, None, Some(S::Failed)]),
            (
                S::Running,
                [
                    None,
                    Some(S::Cancelling),
                    Some(S::Succeeded),
                    Some(S::Failed),
                    Some(S::Queued),
                    Some(S::Queued),
                    None,
                    Some(S::Queued),
                    None,
                ],
            ),
            (
                S::Cancelling,
                [
                    None,
                    Some(S::Cancelling),
                    cancelled,
                    cancelled,
                    cancelled,
                    cancelled,
                    cancelled,
                    cancelled,
                    None,
                ],
            ),
            (S::Succeeded, [None; 9]),
            (S::Failed, [None; 9]),
            (S::Cancelled, [None, cancelled, None, None, None, None, None, None, None]),
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
    fn state_names_round_trip() {
        for state in S::ALL {
            assert_eq!(S::parse(state.as_str()), Some(state));
        }
        for state in SceneState::ALL {
            assert_eq!(SceneState::parse(state.as_str()), Some(state));
        }
        for kind in JobKind::ALL {
            assert_eq!(JobKind::parse(kind.as_str()), Some(kind));
        }
        assert_eq!(S::parse("Queued"), None);
    }
}
