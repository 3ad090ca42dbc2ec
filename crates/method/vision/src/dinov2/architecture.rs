//! Architecture of a DINOv2 model: the part of `config.json` that determines shapes and arithmetic.

use serde::{Deserialize, Serialize};

use super::SIDE_PX;
use super::error::Dinov2WeightsError;
use crate::config_json::{unfit_epsilon, unfit_sizes};

/// Keys of `config.json`, under their names there; other keys do not change the computation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dinov2Architecture {
    pub model_type: String,
    /// Values a token.
    pub hidden_size: usize,
    pub num_hidden_layers: usize,
    pub num_attention_heads: usize,
    /// Ratio of the feed-forward width to that of a token.
    pub mlp_ratio: f64,
    pub hidden_act: String,
    pub layer_norm_eps: f64,
    /// Image side of the stored position embeddings, pixels.
    pub image_size: usize,
    /// Side of a patch, pixels.
    pub patch_size: usize,
    pub num_channels: usize,
    /// Whether query, key and value have a bias.
    pub qkv_bias: bool,
    pub use_swiglu_ffn: bool,
}

impl Dinov2Architecture {
    /// Reads and checks `config.json`.
    pub(super) fn read(config_json: &[u8]) -> Result<Self, Dinov2WeightsError> {
        let read = serde_json::from_slice::<Self>(config_json).map_err(|error| error.to_string());
        let reason = match read {
            Ok(architecture) => match architecture.unfit() {
                None => return Ok(architecture),
                Some(reason) => reason,
            },
            Err(reason) => reason,
        };
        Err(Dinov2WeightsError::Config { reason })
    }

    /// Patches along each side of the stored position embeddings.
    pub(super) fn stored_grid(&self) -> usize {
        self.image_size / self.patch_size
    }

    /// Width of the feed-forward network between its two projections.
    pub(super) fn feed_forward_size(&self) -> usize {
        let size = (self.hidden_size as f64 * self.mlp_ratio) as usize;
        // SwiGLU keeps two thirds, rounded up to a multiple of 8.
        if self.use_swiglu_ffn { (size * 2 / 3).next_multiple_of(8) } else { size }
    }

    /// Reason why the architecture is not supported.
    fn unfit(&self) -> Option<String> {
        let words = [("model_type", &self.model_type, "dinov2"), ("hidden_act", &self.hidden_act, "gelu")];
        for (key, found, known) in words {
            if found != known {
                return Some(format!("{key} is {found:?}; only {known:?} is known"));
            }
        }
        let ranges = [
            ("hidden_size", self.hidden_size, 1, 8192),
            ("num_hidden_layers", self.num_hidden_layers, 1, 256),
            ("num_attention_heads", self.num_attention_heads, 1, self.hidden_size),
            ("num_channels", self.num_channels, 3, 3),
            ("patch_size", self.patch_size, 1, SIDE_PX),
            ("image_size", self.image_size, self.patch_size, 8192),
        ];
        if let Some(reason) = unfit_sizes(&ranges, self.hidden_size, self.num_attention_heads) {
            return Some(reason);
        }
        if !(0.1..=64.0).contains(&self.mlp_ratio) {
            return Some(format!("mlp_ratio is {}, outside 0.1 to 64", self.mlp_ratio));
        }
        unfit_epsilon(self.layer_norm_eps)
    }
}
