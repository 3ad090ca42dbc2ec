//! One layer of the transformer: attention, then a feed-forward network, each after a norm and added to its input.
//! Tokens are rows.

use candle_core::{Result, Tensor};
use candle_nn::{LayerNorm, Linear, Module};

use super::architecture::{ClipActivation, ClipArchitecture};
use crate::attention::{Attention, AttentionNames};
use crate::network_weights::{NetworkWeights, NetworkWeightsError};

/// A layer with its weights.
pub(super) struct TransformerLayer {
    norm1: LayerNorm,
    attention: Attention,
    norm2: LayerNorm,
    fc1: Linear,
    activation: ClipActivation,
    fc2: Linear,
}

/// Projections below the prefix of a layer.
const ATTENTION: AttentionNames = AttentionNames {
    query: "self_attn.q_proj",
    key: "self_attn.k_proj",
    value: "self_attn.v_proj",
    output: "self_attn.out_proj",
};

impl TransformerLayer {
    /// The tensors below `prefix`.
    pub(super) fn read(
        weights: &NetworkWeights,
        prefix: &str,
        architecture: &ClipArchitecture,
    ) -> std::result::Result<Self, NetworkWeightsError> {
        let (hidden, inner) = (architecture.hidden_size, architecture.intermediate_size);
        let norm =
            |name: &str| weights.layer_norm(&format!("{prefix}.{name}"), hidden, architecture.layer_norm_eps);
        let heads = architecture.num_attention_heads;
        Ok(Self {
            norm1: norm("layer_norm1")?,
            attention: Attention::read(weights, prefix, &ATTENTION, hidden, heads, true)?,
            norm2: norm("layer_norm2")?,
            fc1: weights.linear(&format!("{prefix}.mlp.fc1"), hidden, inner, true)?,
            activation: architecture.hidden_act,
            fc2: weights.linear(&format!("{prefix}.mlp.fc2"), inner, hidden, true)?,
        })
    }

    /// Adds the attention over all tokens.
    pub(super) fn attend(&self, tokens: &Tensor) -> Result<Tensor> {
        tokens + self.attention.forward(&self.norm1.forward(tokens)?)?
    }

    /// Adds the feed-forward network of each token.
    pub(super) fn feed_forward(&self, tokens: &Tensor) -> Result<Tensor> {
        let inner = self.fc1.forward(&self.norm2.forward(tokens)?)?;
        tokens + self.fc2.forward(&self.activation.apply(&inner)?)?
    }
}
