//! Patch tokens of vision transformers (Dosovitskiy et al., 2021): each square patch of the input, projected.

use candle_core::{Device, Result, Tensor};
use candle_nn::{Linear, Module};

use crate::network_weights::{NetworkWeights, NetworkWeightsError};

/// Normalized colors, channel by channel, each row-major from the top.
pub(crate) struct Pixels {
    pub rgb: Vec<f32>,
    pub height_px: usize,
    pub width_px: usize,
}

/// A convolution whose stride is its size, as a matrix over the values of a patch.
pub(crate) struct PatchProjection {
    side_px: usize,
    projection: Linear,
}

impl PatchProjection {
    /// The tensors `<name>.weight` (hidden x 3 x side x side) and, with a bias, `<name>.bias`.
    pub(crate) fn read(
        weights: &NetworkWeights,
        name: &str,
        side_px: usize,
        hidden: usize,
        has_bias: bool,
    ) -> std::result::Result<Self, NetworkWeightsError> {
        let kernel = weights.shaped(&format!("{name}.weight"), &[hidden, 3, side_px, side_px])?;
        let bias = has_bias.then(|| weights.vector(&format!("{name}.bias"), hidden)).transpose()?;
        let projection = Linear::new(kernel.reshape((hidden, 3 * side_px * side_px))?, bias);
        Ok(Self { side_px, projection })
    }

    /// Tokens of the patches (patches x hidden), row-major; both sides of the input must be multiples of a patch's.
    pub(crate) fn forward(&self, pixels: &Pixels) -> Result<Tensor> {
        let side = self.side_px;
        let (rows, columns) = (pixels.height_px / side, pixels.width_px / side);
        let colors = Tensor::from_slice(&pixels.rgb, (3, rows, side, columns, side), &Device::Cpu)?;
        let patches = colors.permute((1, 3, 0, 2, 4))?.reshape((rows * columns, 3 * side * side))?;
        self.projection.forward(&patches)
    }
}
