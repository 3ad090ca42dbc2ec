//! Architecture of an image tower: the part of `config.json` that determines shapes and arithmetic.

use candle_core::{Result as TensorResult, Tensor};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::error::ClipWeightsError;
use crate::config_json::{unfit_epsilon, unfit_sizes};

/// Keys of a `CLIPVisionConfig`, under their names there; other keys do not change the computation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClipArchitecture {
    /// Values a token.
    pub hidden_size: usize,
    /// Width of the feed-forward network between its two projections.
    pub intermediate_size: usize,
    /// Values of an embedding.
    pub projection_dim: usize,
    pub num_hidden_layers: usize,
    pub num_attention_heads: usize,
    pub hidden_act: ClipActivation,
    pub layer_norm_eps: f64,
    /// Side of the input square, pixels.
    pub image_size: usize,
    /// Side of a patch, pixels.
    pub patch_size: usize,
    /// Early files do not state it.
    #[serde(default = "three")]
    pub num_channels: usize,
}

/// Activation of the feed-forward network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClipActivation {
    /// `x * sigmoid(1.702 x)`, that of OpenAI's weights.
    QuickGelu,
    /// `x * Phi(x)` with the normal distribution's `Phi`.
    Gelu,
}

fn three() -> usize {
    3
}

impl ClipActivation {
    /// The activation of each value.
    pub(super) fn apply(self, x: &Tensor) -> TensorResult<Tensor> {
        match self {
            Self::QuickGelu => x * candle_nn::ops::sigmoid(&(x * 1.702)?)?,
            Self::Gelu => x.gelu_erf(),
        }
    }
}

impl ClipArchitecture {
    /// Reads and checks `config.json`, that of the tower or of both towers. The latter has the tower's in
    /// `vision_config` and the width of embeddings beside it.
    pub(super) fn read(config_json: &[u8]) -> Result<Self, ClipWeightsError> {
        let config = |reason: String| ClipWeightsError::Config { reason };
        let mut whole: Value =
            serde_json::from_slice(config_json).map_err(|error| config(error.to_string()))?;
        let model_type = whole.get("model_type").and_then(Value::as_str).unwrap_or_default();
        let mut tower = match model_type {
            "clip_vision_model" => whole.take(),
            "clip" => whole.get_mut("vision_config").map(Value::take).unwrap_or_default(),
            other => {
                let known = "\"clip\" and \"clip_vision_model\" are known";
                return Err(config(format!("model_type is {other:?}; only {known}")));
            }
        };
        if let (Some(width), Some(tower)) = (whole.get_mut("projection_dim"), tower.as_object_mut()) {
            tower.insert("projection_dim".to_owned(), width.take());
        }
        let architecture: Self = serde_json::from_value(tower).map_err(|error| config(error.to_string()))?;
        match architecture.unfit() {
            None => Ok(architecture),
            Some(reason) => Err(config(reason)),
        }
    }

    /// Patches along each side of the input.
    pub(super) fn grid(&self) -> usize {
        self.image_size / self.patch_size
    }

    /// Reason why the architecture is not supported.
    fn unfit(&self) -> Option<String> {
        let ranges = [
            ("hidden_size", self.hidden_size, 1, 8192),
            ("intermediate_size", self.intermediate_size, 1, 65_536),
            ("projection_dim", self.projection_dim, 1, 8192),
            ("num_hidden_layers", self.num_hidden_layers, 1, 256),
            ("num_attention_heads", self.num_attention_heads, 1, self.hidden_size),
            ("num_channels", self.num_channels, 3, 3),
            ("image_size", self.image_size, 1, 1024),
            ("patch_size", self.patch_size, 1, self.image_size),
        ];
        if let Some(reason) = unfit_sizes(&ranges, self.hidden_size, self.num_attention_heads) {
            return Some(reason);
        }
        if !self.image_size.is_multiple_of(self.patch_size) {
            let (side, patch) = (self.image_size, self.patch_size);
            return Some(format!("image_size = {side} is no multiple of patch_size = {patch}"));
        }
        unfit_epsilon(self.layer_norm_eps)
    }
}
