//! Failure of a stage: a class that decides about trying again, a stable code, and two messages (a sentence for the
//! client that says what to do; the cause chain for the log).

use std::error::Error;
use std::time::Duration;

use ports::ProviderError;
use runtime::Cancelled;
use runtime::ComputationFailed;
use store::StoreError;

/// Class of a failure, which decides whether the stage is tried again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StageErrorClass {
    /// May pass by itself.
    Transient,
    /// A provider asked for patience, perhaps saying for how long.
    RateLimited { retry_after: Option<Duration> },
    /// The same inputs fail the same way.
    Permanent,
    /// A provider, or a rule of ours, will not do this request.
    Refused,
    /// The request's budget is spent.
    OverBudget,
    /// A panic inside a stage.
    Crashed,
    /// The job was stopped; the caller that stopped it knows the reason.
    Cancelled,
    /// Another worker holds the job now; nothing may be written any more.
    LeaseLost,
}

/// Error of a stage that cannot do its work.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct StageError {
    pub class: StageErrorClass,
    /// Stable, `[a-z0-9_]+`; clients may match on it.
    pub code: &'static str,
    /// For the client: what failed and what to change.
    pub message: String,
    /// The recorded answers of the stage's model calls are unusable: the next attempt must ask again.
    pub discards_recorded_answers: bool,
    #[source]
    pub cause: Option<Box<dyn Error + Send + Sync>>,
}

impl StageError {
    fn new(class: StageErrorClass, code: &'static str, message: impl Into<String>) -> Self {
        Self { class, code, message: message.into(), discards_recorded_answers: false, cause: None }
    }

    /// The same inputs would fail again: bad input, or a bug.
    pub fn permanent(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(StageErrorClass::Permanent, code, message)
    }

    /// May pass by itself.
    pub fn transient(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(StageErrorClass::Transient, code, message)
    }

    /// The request is refused for every caller.
    pub fn refused(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(StageErrorClass::Refused, code, message)
    }

    /// A provider asked for patience.
    pub fn rate_limited(
        code: &'static str,
        message: impl Into<String>,
        retry_after: Option<Duration>,
    ) -> Self {
        Self::new(StageErrorClass::RateLimited { retry_after }, code, message)
    }

    /// The budget is spent.
    pub fn over_budget(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(StageErrorClass::OverBudget, code, message)
    }

    /// A panic, caught.
    pub fn crashed(message: impl Into<String>) -> Self {
        Self::new(StageErrorClass::Crashed, "stage_panicked", message)
    }

    /// The job was asked to stop.
    pub fn cancelled() -> Self {
        Self::new(StageErrorClass::Cancelled, "interrupted", "the job was asked to stop")
    }

    /// Adds what lies underneath, for the log.
    pub fn because(mut self, cause: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        self.cause = Some(cause.into());
        self
    }

    /// Both results, or the failure of one. Any other failure tells more than an interruption.
    ///
    /// # Errors
    ///
    /// The failure, or the more telling of two.
    pub fn both<A, B>(results: (Result<A, Self>, Result<B, Self>)) -> Result<(A, B), Self> {
        match results {
            (Ok(a), Ok(b)) => Ok((a, b)),
            (Err(error), Ok(_)) | (Ok(_), Err(error)) => Err(error),
            (Err(a), Err(b)) => Err(if a.class == StageErrorClass::Cancelled { b } else { a }),
        }
    }

    /// Message and cause chain on one line, for the log.
    pub fn chain(&self) -> String {
        runtime::error_chain(self)
    }
}

impl From<Cancelled> for StageError {
    fn from(_: Cancelled) -> Self {
        Self::cancelled()
    }
}

impl From<ComputationFailed> for StageError {
    fn from(died: ComputationFailed) -> Self {
        Self::crashed(died.to_string())
    }
}

impl From<ProviderError> for StageError {
    fn from(error: ProviderError) -> Self {
        let message = error.to_string();
        let discards_recorded_answers = error.discards_recorded_answers();
        let stage_error = match error {
            ProviderError::Unsupported { .. } => Self::refused("unsupported", message),
            ProviderError::Rejected { code, .. } => Self::permanent(code, message),
            ProviderError::Transient { code, .. } => Self::transient(code, message),
            ProviderError::RateLimited { retry_after, .. } => {
                Self::rate_limited("provider_busy", message, retry_after)
            }
            ProviderError::Refused { code, .. } => Self::refused(code, message),
            ProviderError::Misconfigured { code, .. } => Self::permanent(code, message),
            ProviderError::OverBudget { .. } => Self::over_budget("over_budget", message),
            ProviderError::Ledger { lease_lost: true, .. } => {
                Self::new(StageErrorClass::LeaseLost, "lease_lost", message)
            }
            ProviderError::Ledger { .. } => Self::transient("store_unavailable", message),
            ProviderError::Died { .. } => Self::crashed(message),
            ProviderError::Cancelled(_) => Self::cancelled(),
        };
        Self { discards_recorded_answers, ..stage_error }
    }
}

impl From<StoreError> for StageError {
    fn from(error: StoreError) -> Self {
        let message = match error {
            StoreError::LeaseLost { .. } => {
                Self::new(StageErrorClass::LeaseLost, "lease_lost", "another worker holds this job now")
            }
            _ => Self::transient("store_unavailable", "results could not be stored or read; trying again"),
        };
        message.because(error)
    }
}
