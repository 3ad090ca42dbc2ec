//! Errors of reading weights and of feature extraction.

use crate::network_weights::NetworkWeightsError;
use runtime::Cancelled;

/// Reason why a model is rejected; the caller adds the file names.
#[derive(Debug, thiserror::Error)]
pub enum Dinov2WeightsError {
    #[error("config.json describes no DINOv2 that can be computed: {reason}")]
    Config { reason: String },
    #[error(
        "model.safetensors does not hold the Dinov2Model of config.json in the layout of Hugging Face: {0}"
    )]
    Tensors(#[from] NetworkWeightsError),
    #[error("preparing the tensors failed: {0}")]
    Computation(#[from] candle_core::Error),
}

/// Reason why feature extraction failed.
#[derive(Debug, thiserror::Error)]
pub enum Dinov2Error {
    #[error("the class token has no length; these weights give nothing for this image")]
    NotFinite,
    #[error("a tensor operation failed: {0}")]
    Computation(#[from] candle_core::Error),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
