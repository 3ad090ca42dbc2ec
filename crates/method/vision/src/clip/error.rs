//! Errors of reading weights.

use crate::network_weights::NetworkWeightsError;

/// Reason why a tower is rejected; the caller adds the file names.
#[derive(Debug, thiserror::Error)]
pub enum ClipWeightsError {
    #[error("config.json describes no image tower of CLIP that can be computed: {reason}")]
    Config { reason: String },
    #[error(
        "model.safetensors does not hold the image tower of config.json in the layout of Hugging Face's \
         CLIPVisionModelWithProjection: {0}"
    )]
    Tensors(#[from] NetworkWeightsError),
    #[error("preparing the tensors failed: {0}")]
    Computation(#[from] candle_core::Error),
}
