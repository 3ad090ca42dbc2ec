//! Errors of the ports: the port, the cause, and the remedy.

use std::fmt;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use runtime::Cancelled;

/// The code of malformed and of inconsistent answers.
pub const BAD_ANSWER: &str = "provider_bad_answer";

/// The five ports, as errors and settings name them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Port {
    Analyst,
    ImageGenerator,
    Segmenter,
    MeshGenerator,
    FeatureExtractor,
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Analyst => "analyst",
            Self::ImageGenerator => "image_generator",
            Self::Segmenter => "segmenter",
            Self::MeshGenerator => "mesh_generator",
            Self::FeatureExtractor => "feature_extractor",
        })
    }
}

/// Failure of a port to answer. Codes are stable, `[a-z0-9_]+`; clients may match on them.
#[derive(Debug, thiserror::Error)]
pub enum ProviderError {
    /// The adapter lacks the capability; another one may have it.
    #[error("the {port} port's adapter {adapter} cannot do this: {reason}")]
    Unsupported { port: Port, adapter: String, reason: String },
    /// The input is at fault: the same question fails the same way.
    #[error("{reason}")]
    Rejected { port: Port, code: &'static str, reason: String },
    /// A temporary failure.
    #[error("the {port} port is not answering: {reason}")]
    Transient { port: Port, code: &'static str, reason: String },
    /// The vendor limits the rate of calls.
    #[error("the {port} port asks to slow down")]
    RateLimited { port: Port, retry_after: Option<Duration> },
    /// The vendor or its model refuses this question.
    #[error("the {port} port refuses: {reason}")]
    Refused { port: Port, code: &'static str, reason: String },
    /// The operator must correct the configuration: a key, an address, or a model name.
    #[error("the {port} port cannot be used as it is configured: {reason}")]
    Misconfigured { port: Port, code: &'static str, reason: String },
    /// The call would exceed the remaining budget of the scene.
    #[error("the {port} port was not asked: {reason}")]
    OverBudget { port: Port, reason: String },
    /// The ledger cannot record the call: another worker holds the job, or the storage fails.
    #[error("a call of the {port} port could not be written down: {reason}")]
    Ledger { port: Port, lease_lost: bool, reason: String },
    /// A computation panicked; a bug.
    #[error("a computation of the {port} port died: {reason}")]
    Died { port: Port, reason: String },
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl ProviderError {
    /// Whether the recorded answers of the failed stage are unusable, so that a retry must ask the models again.
    pub fn discards_recorded_answers(&self) -> bool {
        matches!(self, Self::Rejected { code, .. } | Self::Transient { code, .. } | Self::Refused { code, .. } | Self::Misconfigured { code, .. } if *code == BAD_ANSWER)
    }

    /// Whether the next provider in the order of preference is asked. A refusal and a spent budget are final, and
    /// invalid input is invalid for every provider.
    pub fn another_may_answer(&self) -> bool {
        match self {
            Self::Unsupported { .. }
            | Self::Transient { .. }
            | Self::RateLimited { .. }
            | Self::Misconfigured { .. } => true,
            Self::Rejected { .. }
            | Self::Refused { .. }
            | Self::OverBudget { .. }
            | Self::Ledger { .. }
            | Self::Died { .. }
            | Self::Cancelled(_) => false,
        }
    }
}
