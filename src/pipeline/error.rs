//! How a stage fails: a class that decides about trying again, a stable code, and two messages (a
//! sentence for the client that says what to do; the cause chain for the log).

use std::error::Error;
use std::time::Duration;

use ports::ProviderError;
use runtime::Died;
use runtime::Interrupted;
use store::StoreError;

/// Whether trying again can help.
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
    /// The job was asked to stop; whoever asked knows why.
    Interrupted,
    /// Another worker holds the job now; nothing may be written any more.
    LeaseLost,
}

/// What a stage returns when it cannot do its work.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct StageError {
    pub class: StageErrorClass,
    /// Stable, `[a-z0-9_]+`; clients may match on it.
    pub code: &'static str,
    /// For the client: what failed and what to change.
    pub message: String,
    #[source]
    pub cause: Option<Box<dyn Error + Send + Sync>>,
}

impl StageError {
    fn new(class: StageErrorClass, code: &'static str, message: impl Into<String>) -> Self {
        Self { class, code, message: message.into(), cause: None }
    }

    /// The same inputs would fail again: bad input, or a bug.
    pub fn permanent(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(StageErrorClass::Permanent, code, message)
    }

    /// May pass by itself.
    pub fn transient(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(StageErrorClass::Transient, code, message)
    }

    /// Will not be done, whoever asks.
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
    pub fn interrupted() -> Self {
        Self::new(StageErrorClass::Interrupted, "interrupted", "the job was asked to stop")
    }

    /// Adds what lies underneath, for the log.
    pub fn because(mut self, cause: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        self.cause = Some(cause.into());
        self
    }

    /// Message and cause chain on one line, for the log.
    pub fn chain(&self) -> String {
        let mut text = self.message.clone();
        let mut cause = self.source();
        while let Some(error) = cause {
            text.push_str(": ");
            text.push_str(&error.to_string());
            cause = error.source();
        }
        text
    }
}

impl From<Interrupted> for StageError {
    fn from(_: Interrupted) -> Self {
        Self::interrupted()
    }
}

impl From<Died> for StageError {
    fn from(died: Died) -> Self {
        Self::crashed(died.to_string())
    }
}

impl From<ProviderError> for StageError {
    fn from(error: ProviderError) -> Self {
        let message = error.to_string();
        match error {
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
            ProviderError::Interrupted(_) => Self::interrupted(),
        }
    }
}

impl From<StoreError> for StageError {
    fn from(error: StoreError) -> Self {
        let told = match error {
            StoreError::LeaseLost { .. } => {
                Self::new(StageErrorClass::LeaseLost, "lease_lost", "another worker holds this job now")
            }
            _ => Self::transient("store_unavailable", "results could not be stored or read; trying again"),
        };
        told.because(error)
    }
}
