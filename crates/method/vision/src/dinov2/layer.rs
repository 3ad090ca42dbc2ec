//! One layer of the transformer: attention, then a feed-forward network. Each follows a norm, is scaled value by
//! value and added to its input. Tokens are rows.

use candle_core::{D, Result, Tensor};
use candle_nn::ops::softmax_last_dim;
use candle_nn::{LayerNorm, Linear, Module};

use super::architecture::Dinov2Architecture;
use super::error::Dinov2WeightsError;
use crate::network_weights::NetworkWeights;

/// A layer with its weights.
pub(super) struct TransformerLayer {
    heads: usize,
    norm1: LayerNorm,
    query: Linear,
    key: Linear,
    value: Linear,
    attention_output: Linear,
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

/// The layer norm with the tensors below `prefix`.
pub(super) fn layer_norm(
    weights: &NetworkWeights,
    prefix: &str,
    architecture: &Dinov2Architecture,
) -> std::result::Result<LayerNorm, Dinov2WeightsError> {
    let hidden = architecture.hidden_size;
    let weight = weights.shaped(&format!("{prefix}.weight"), &[hidden])?;
    let bias = weights.shaped(&format!("{prefix}.bias"), &[hidden])?;
    Ok(LayerNorm::new(weight, bias, architecture.layer_norm_eps))
}

impl TransformerLayer {
    /// The tensors below `prefix`.
    pub(super) fn read(
        weights: &NetworkWeights,
        prefix: &str,
        architecture: &Dinov2Architecture,
    ) -> std::result::Result<Self, Dinov2WeightsError> {
        let hidden = architecture.hidden_size;
        let inner = architecture.feed_forward_size();
        let linear = |name: &str, from: usize, to: usize, has_bias: bool| {
            let weight = weights.shaped(&format!("{prefix}.{name}.weight"), &[to, from])?;
            let bias =
                has_bias.then(|| weights.shaped(&format!("{prefix}.{name}.bias"), &[to])).transpose()?;
            Ok::<_, Dinov2WeightsError>(Linear::new(weight, bias))
        };
        let norm = |name: &str| layer_norm(weights, &format!("{prefix}.{name}"), architecture);
        let scale = |name: &str| weights.shaped(&format!("{prefix}.{name}.lambda1"), &[hidden]);
        let projection = |name: &str| {
            linear(&format!("attention.attention.{name}"), hidden, hidden, architecture.qkv_bias)
        };
        Ok(Self {
            heads: architecture.num_attention_heads,
            norm1: norm("norm1")?,
            query: projection("query")?,
            key: projection("key")?,
            value: projection("value")?,
            attention_output: linear("attention.output.dense", hidden, hidden, true)?,
            layer_scale1: scale("layer_scale1")?,
            norm2: norm("norm2")?,
            feed_forward: match architecture.use_swiglu_ffn {
                false => FeedForward::Mlp {
                    fc1: linear("mlp.fc1", hidden, inner, true)?,
                    fc2: linear("mlp.fc2", inner, hidden, true)?,
                },
                true => FeedForward::SwiGlu {
                    weights_in: linear("mlp.weights_in", hidden, 2 * inner, true)?,
                    weights_out: linear("mlp.weights_out", inner, hidden, true)?,
                },
            },
            layer_scale2: scale("layer_scale2")?,
        })
    }

    /// Adds the attention over all tokens.
    pub(super) fn attend(&self, tokens: &Tensor) -> Result<Tensor> {
        let (count, hidden) = tokens.dims2()?;
        let width = hidden / self.heads;
        let normed = self.norm1.forward(tokens)?;
        let by_head = |projection: &Linear| {
            projection.forward(&normed)?.reshape((count, self.heads, width))?.transpose(0, 1)?.contiguous()
        };
        let (query, key, value) = (by_head(&self.query)?, by_head(&self.key)?, by_head(&self.value)?);
        let scores = (query.matmul(&key.transpose(1, 2)?)? * (width as f64).powf(-0.5))?;
        let mixed = softmax_last_dim(&scores)?.matmul(&value)?.transpose(0, 1)?.reshape((count, hidden))?;
        tokens + self.attention_output.forward(&mixed)?.broadcast_mul(&self.layer_scale1)?
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
