//! How a port fails: what was asked of whom, why it failed, and what to do.

use std::fmt;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use runtime::Interrupted;

/// The code of answers that are none, and of those that do not hold what was asked for.
pub const BAD_ANSWER: &str = "provider_bad_answer";

/// The five ports, as errors and settings name them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Port {
    Analyst,
    Painter,
    Segmenter,
    MeshGenerator,
    FeatureExtractor,
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Analyst => "analyst",
            Self::Painter => "painter",
            Self::Segmenter => "segmenter",
            Self::MeshGenerator => "mesh_generator",
            Self::FeatureExtractor => "feature_extractor",
        })
    }
}

/// Why a port gave no answer. Codes are stable, `[a-z0-9_]+`; clients may match on them.
#[derive(Debug, thiserror::Error)]
pub enum ProviderError {
    /// This adapter cannot do it; another one might.
    #[error("the {port} port's adapter {adapter} cannot do this: {reason}")]
    Unsupported { port: Port, adapter: String, reason: String },
    /// The input is at fault: the same question fails the same way.
    #[error("{reason}")]
    Rejected { port: Port, code: &'static str, reason: String },
    /// May pass by itself.
    #[error("the {port} port is not answering: {reason}")]
    Transient { port: Port, code: &'static str, reason: String },
    /// The vendor asked for patience.
    #[error("the {port} port asks to slow down")]
    RateLimited { port: Port, retry_after: Option<Duration> },
    /// The vendor or its model will not answer this question.
    #[error("the {port} port refuses: {reason}")]
    Refused { port: Port, code: &'static str, reason: String },
    /// The operator has to do something: a key, an address, a model's name.
    #[error("the {port} port cannot be used as it is configured: {reason}")]
    Misconfigured { port: Port, code: &'static str, reason: String },
    /// The call would cost more than is left of the scene's budget.
    #[error("the {port} port was not asked: {reason}")]
    OverBudget { port: Port, reason: String },
    /// The call can no longer be written down: another worker holds the job, or storage takes no writes.
    #[error("a call of the {port} port could not be written down: {reason}")]
    Ledger { port: Port, lease_lost: bool, reason: String },
    /// A computation of an embedded adapter died; a bug.
    #[error("a computation of the {port} port died: {reason}")]
    Died { port: Port, reason: String },
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl ProviderError {
    /// Whether the next provider in the order of preference is to be asked. A refusal and a spent budget are final,
    /// and a question that is at fault is so for everybody.
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
            | Self::Interrupted(_) => false,
        }
    }
}
