//! How a port fails: what was asked of whom, why it failed, and what to do.

use std::fmt;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::geometry::Interrupted;

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

/// Why a port gave no answer.
#[derive(Debug, thiserror::Error)]
pub enum ProviderError {
    /// This adapter cannot do it; another one might.
    #[error("the {port} port's adapter {adapter} cannot do this: {reason}")]
    Unsupported { port: Port, adapter: String, reason: String },
    /// The input is at fault: the same question fails the same way. `code` is stable, `[a-z0-9_]+`.
    #[error("{reason}")]
    Rejected { port: Port, code: &'static str, reason: String },
    /// May pass by itself.
    #[error("the {port} port is not answering: {reason}")]
    Transient { port: Port, reason: String },
    /// The vendor asked for patience.
    #[error("the {port} port asks to slow down")]
    RateLimited { port: Port, retry_after: Option<Duration> },
    /// A computation of an embedded adapter died; a bug.
    #[error("a computation of the {port} port died: {reason}")]
    Died { port: Port, reason: String },
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}
