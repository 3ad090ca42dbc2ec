//! Multi-head self-attention (Vaswani et al., 2017) over all tokens of one image, without a mask.

use candle_core::{Result, Tensor};
use candle_nn::ops::softmax_last_dim;
use candle_nn::{Linear, Module};

use crate::network_weights::{NetworkWeights, NetworkWeightsError};

/// Attention of one layer with its weights.
pub(crate) struct Attention {
    heads: usize,
    query: Linear,
    key: Linear,
    value: Linear,
    output: Linear,
}

/// Names of the four projections below the prefix of a layer.
pub(crate) struct AttentionNames {
    pub query: &'static str,
    pub key: &'static str,
    pub value: &'static str,
    pub output: &'static str,
}

impl Attention {
    /// The projections below `prefix`, all of `hidden` x `hidden`; the output's has a bias always.
    pub(crate) fn read(
        weights: &NetworkWeights,
        prefix: &str,
        names: &AttentionNames,
        hidden: usize,
        heads: usize,
        has_bias: bool,
    ) -> std::result::Result<Self, NetworkWeightsError> {
        let linear = |name: &str, has_bias: bool| {
            weights.linear(&format!("{prefix}.{name}"), hidden, hidden, has_bias)
        };
        Ok(Self {
            heads,
            query: linear(names.query, has_bias)?,
            key: linear(names.key, has_bias)?,
            value: linear(names.value, has_bias)?,
            output: linear(names.output, true)?,
        })
    }

    /// The mixed tokens (tokens x hidden) of normalized ones.
    pub(crate) fn forward(&self, normed: &Tensor) -> Result<Tensor> {
        let (count, hidden) = normed.dims2()?;
        let width = hidden / self.heads;
        let by_head = |projection: &Linear| {
            projection.forward(normed)?.reshape((count, self.heads, width))?.transpose(0, 1)?.contiguous()
        };
        let (query, key, value) = (by_head(&self.query)?, by_head(&self.key)?, by_head(&self.value)?);
        let scores = (query.matmul(&key.transpose(1, 2)?)? * (width as f64).powf(-0.5))?;
        let mixed = softmax_last_dim(&scores)?.matmul(&value)?.transpose(0, 1)?.reshape((count, hidden))?;
        self.output.forward(&mixed)
    }
}
