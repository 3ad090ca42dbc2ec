//! One layer of the transformer: attention, then a feed-forward network. Each follows a norm, is scaled value by
//! value and added to its input. Tokens are rows.

use candle_core::{D, Result, Tensor};
use candle_nn::{LayerNorm, Linear, Module};

use super::architecture::Dinov2Architecture;
use super::error::Dinov2WeightsError;
use crate::attention::{Attention, AttentionNames};
use crate::network_weights::NetworkWeights;

/// A layer with its weights.
pub(super) struct TransformerLayer {
    norm1: LayerNorm,
    attention: Attention,
    layer_scale1: Tensor,
    norm2: LayerNorm,
    feed_forward: FeedForward,
    layer_scale2: Tensor,
}

enum FeedForward {
    Mlp {
        fc1: Linear,
        fc2: Linear,
    },
    /// One projection yields gate and value, the gate first.
    SwiGlu {
        weights_in: Linear,
        weights_out: Linear,
    },
}

/// Projections below the prefix of a layer.
const ATTENTION: AttentionNames = AttentionNames {
    query: "attention.attention.query",
    key: "attention.attention.key",
    value: "attention.attention.value",
    output: "attention.output.dense",
};

impl TransformerLayer {
    /// The tensors below `prefix`.
    pub(super) fn read(
        weights: &NetworkWeights,
        prefix: &str,
        architecture: &Dinov2Architecture,
    ) -> std::result::Result<Self, Dinov2WeightsError> {
        let hidden = architecture.hidden_size;
        let inner = architecture.feed_forward_size();
        let linear =
            |name: &str, from: usize, to: usize| weights.linear(&format!("{prefix}.{name}"), from, to, true);
        let norm =
            |name: &str| weights.layer_norm(&format!("{prefix}.{name}"), hidden, architecture.layer_norm_eps);
        let scale = |name: &str| weights.vector(&format!("{prefix}.{name}.lambda1"), hidden);
        let heads = architecture.num_attention_heads;
        Ok(Self {
            norm1: norm("norm1")?,
            attention: Attention::read(weights, prefix, &ATTENTION, hidden, heads, architecture.qkv_bias)?,
            layer_scale1: scale("layer_scale1")?,
            norm2: norm("norm2")?,
            feed_forward: match architecture.use_swiglu_ffn {
                false => FeedForward::Mlp {
                    fc1: linear("mlp.fc1", hidden, inner)?,
                    fc2: linear("mlp.fc2", inner, hidden)?,
                },
                true => FeedForward::SwiGlu {
                    weights_in: linear("mlp.weights_in", hidden, 2 * inner)?,
                    weights_out: linear("mlp.weights_out", inner, hidden)?,
                },
            },
            layer_scale2: scale("layer_scale2")?,
        })
    }

    /// Adds the attention over all tokens.
    pub(super) fn attend(&self, tokens: &Tensor) -> Result<Tensor> {
        let mixed = self.attention.forward(&self.norm1.forward(tokens)?)?;
        tokens + mixed.broadcast_mul(&self.layer_scale1)?
    }

    /// Adds the feed-forward network of each token.
    pub(super) fn feed_forward(&self, tokens: &Tensor) -> Result<Tensor> {
        let normed = self.norm2.forward(tokens)?;
        let output = match &self.feed_forward {
            FeedForward::Mlp { fc1, fc2 } => fc2.forward(&fc1.forward(&normed)?.gelu_erf()?)?,
            FeedForward::SwiGlu { weights_in, weights_out } => {
                let halves = weights_in.forward(&normed)?.chunk(2, D::Minus1)?;
                weights_out.forward(&(halves[0].silu()? * &halves[1])?)?
            }
        };
        tokens + output.broadcast_mul(&self.layer_scale2)?
    }
}
