//! A bias for each channel and ReLU6 in one pass over the values.

use candle_core::{CpuStorage, CustomOp1, Layout, Result, Shape, bail};

use crate::network_weights::{NetworkWeights, NetworkWeightsError};

/// Adds a bias to each channel of (channels, rows, columns), and limits the sums to 0..6 if it is capped.
pub(super) struct ChannelBias {
    biases: Vec<f32>,
    is_capped: bool,
}

impl ChannelBias {
    pub(super) fn read(
        file: &NetworkWeights,
        tensor: &str,
        channels: usize,
        is_capped: bool,
    ) -> std::result::Result<Self, NetworkWeightsError> {
        Ok(Self { biases: file.vector(tensor, channels)?.to_vec1()?, is_capped })
    }
}

impl CustomOp1 for ChannelBias {
    fn name(&self) -> &'static str {
        "channel bias"
    }

    fn cpu_fwd(&self, storage: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        let (channels, height, width) = layout.shape().dims3()?;
        let Some((from, to)) = layout.contiguous_offsets() else {
            bail!("a bias wants contiguous values");
        };
        if channels != self.biases.len() {
            bail!("biases of {} channels got {channels}", self.biases.len());
        }
        let mut values = storage.as_slice::<f32>()?[from..to].to_vec();
        for (plane, bias) in values.chunks_exact_mut(height * width).zip(&self.biases) {
            if self.is_capped {
                plane.iter_mut().for_each(|value| *value = (*value + bias).clamp(0.0, 6.0));
            } else {
                plane.iter_mut().for_each(|value| *value += bias);
            }
        }
        Ok((CpuStorage::F32(values), layout.shape().clone()))
    }
}
