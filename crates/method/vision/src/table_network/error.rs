//! Errors of reading weights and of inference.

use runtime::Cancelled;

/// Reason why the weights are rejected; the caller adds the file name.
#[derive(Debug, thiserror::Error)]
pub enum NetworkWeightsError {
    #[error("the file is not a safetensors file: {reason}")]
    Format { reason: String },
    #[error("there is no tensor {tensor}; weights as training/train.py writes them are wanted")]
    Missing { tensor: String },
    #[error("tensor {tensor} has shape {found:?}, but {expected} is wanted")]
    Shape { tensor: String, found: Vec<usize>, expected: String },
    #[error("tensor {tensor} holds values that are not finite; the file is damaged")]
    NotFinite { tensor: String },
    #[error("preparing the tensors failed: {0}")]
    Computation(#[from] candle_core::Error),
}

/// Reason why inference failed.
#[derive(Debug, thiserror::Error)]
pub enum NetworkError {
    #[error("the network's answer is not finite; these weights are of no use for this image")]
    NotFinite,
    #[error("a tensor operation failed: {0}")]
    Computation(#[from] candle_core::Error),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
