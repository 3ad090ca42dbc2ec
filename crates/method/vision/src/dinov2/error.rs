//! Errors of reading weights and of feature extraction.

use runtime::Cancelled;

/// Reason why a model is rejected; the caller adds the file names.
#[derive(Debug, thiserror::Error)]
pub enum Dinov2WeightsError {
    #[error("config.json describes no DINOv2 that can be computed: {reason}")]
    Config { reason: String },
    #[error("model.safetensors is not a safetensors file: {reason}")]
    Format { reason: String },
    #[error("model.safetensors has no tensor {tensor}; the layout of Hugging Face's Dinov2Model is wanted")]
    Missing { tensor: String },
    #[error("tensor {tensor} has shape {found:?}, but by config.json it is {expected:?}")]
    Shape { tensor: String, found: Vec<usize>, expected: Vec<usize> },
    #[error("tensor {tensor} holds {dtype} numbers; F32, F16, BF16 or F64 are wanted")]
    NumberType { tensor: String, dtype: String },
    #[error("tensor {tensor} holds values that are not finite; the file is damaged")]
    NotFinite { tensor: String },
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
