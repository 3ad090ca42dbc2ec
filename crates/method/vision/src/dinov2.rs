//! Feature extractor `Phi`, learned form: DINOv2 (Oquab et al., "DINOv2: Learning Robust Visual Features without
//! Supervision", 2023) from published weights.
//!
//! The feature is the class token after the final layer norm, normalized to length 1. The opaque part of the image
//! becomes a square of [`SIDE_PX`] pixels ([`input`]), the square a row of patch tokens with position embeddings
//! ([`position`]). The tokens pass the transformer's layers ([`layer`]), all in f32.
//!
//! Weights are read from bytes in the layout of Hugging Face's `Dinov2Model`, with or without SwiGLU. Variants
//! with register tokens are another architecture and rejected. Every tensor is checked when the model is read: a
//! missing, misshapen or non-finite one is an error that names it, never a wrong result later.
//!
//! Class tokens agree with the reference implementation to 1e-5. Tests verify it on small random models, at sizes
//! with and without interpolated position embeddings; a random ViT-S/14 was 6e-6 off. The order of sums depends on
//! the processor's vector instructions, so the last bits may differ between machines, but not with the number of
//! threads.
//!
//! Cost: about 12 GFLOP an image with ViT-S/14 (a second of one core), 46 with ViT-B/14.

mod architecture;
mod error;
mod input;
mod layer;
mod position;

use candle_core::{Device, Tensor};
use candle_nn::{LayerNorm, Module};

use crate::network_weights::NetworkWeights;
use crate::patch_projection::{PatchProjection, Pixels};
use crate::unit_length::to_unit_length;
use imaging::Image;
use layer::TransformerLayer;
use runtime::CancelFlag;

pub use architecture::Dinov2Architecture;
pub use error::{Dinov2Error, Dinov2WeightsError};

/// Longest side of the input square, pixels: that of the published evaluations. A patch size that does not divide
/// it takes the next smaller multiple.
pub const SIDE_PX: usize = 224;

/// A model with its weights.
pub struct Dinov2 {
    architecture: Dinov2Architecture,
    patch_projection: PatchProjection,
    /// 1 x hidden.
    class_token: Tensor,
    /// 1 x hidden.
    class_position: Tensor,
    /// Row-major over the stored grid, hidden values a cell.
    positions: Vec<f32>,
    layers: Vec<TransformerLayer>,
    norm: LayerNorm,
}

impl Dinov2 {
    /// Reads a model from the bytes of `config.json` and `model.safetensors`.
    ///
    /// # Errors
    ///
    /// A [`Dinov2WeightsError`] that names the key or tensor.
    pub fn read(config_json: &[u8], safetensors: Vec<u8>) -> Result<Self, Dinov2WeightsError> {
        let architecture = Dinov2Architecture::read(config_json)?;
        let weights = NetworkWeights::read(safetensors)?;
        let hidden = architecture.hidden_size;
        let patch = architecture.patch_size;
        let grid = architecture.stored_grid();
        let projection = "embeddings.patch_embeddings.projection";
        let patch_projection = PatchProjection::read(&weights, projection, patch, hidden, true)?;
        let class_token = weights.shaped("embeddings.cls_token", &[1, 1, hidden])?.reshape((1, hidden))?;
        let stored = "embeddings.position_embeddings";
        let stored = weights.shaped(stored, &[1, 1 + grid * grid, hidden])?.squeeze(0)?;
        let layers = (0..architecture.num_hidden_layers)
            .map(|index| TransformerLayer::read(&weights, &format!("encoder.layer.{index}"), &architecture))
            .collect::<Result<_, _>>()?;
        Ok(Self {
            patch_projection,
            class_token,
            class_position: stored.narrow(0, 0, 1)?,
            positions: stored.narrow(0, 1, grid * grid)?.flatten_all()?.to_vec1()?,
            layers,
            norm: weights.layer_norm("layernorm", hidden, architecture.layer_norm_eps)?,
            architecture,
        })
    }

    /// The architecture of the model.
    pub fn architecture(&self) -> &Dinov2Architecture {
        &self.architecture
    }

    /// Side of the input square, pixels.
    pub fn side_px(&self) -> usize {
        SIDE_PX / self.architecture.patch_size * self.architecture.patch_size
    }

    /// The unit-length features of an image; all zeros if nothing is opaque. Cancellation is polled twice a layer.
    ///
    /// # Errors
    ///
    /// [`Dinov2Error::NotFinite`] for useless weights, [`Dinov2Error::Cancelled`] if `cancel` was set.
    pub fn features(&self, image: &Image, cancel: &CancelFlag) -> Result<Vec<f32>, Dinov2Error> {
        let Some(pixels) = input::pixels(image, self.side_px()) else {
            return Ok(vec![0.0; self.architecture.hidden_size]);
        };
        to_unit_length(self.class_token(&pixels, cancel)?).ok_or(Dinov2Error::NotFinite)
    }

    /// The class token after the final layer norm; both sides of the input must be multiples of the patch size.
    fn class_token(&self, pixels: &Pixels, cancel: &CancelFlag) -> Result<Vec<f32>, Dinov2Error> {
        let patch = self.architecture.patch_size;
        let (rows, columns) = (pixels.height_px / patch, pixels.width_px / patch);
        let positions = self.positions(rows, columns);
        let positions =
            Tensor::from_vec(positions, (rows * columns, self.architecture.hidden_size), &Device::Cpu)?;
        let class_token = (&self.class_token + &self.class_position)?;
        let patches = (self.patch_projection.forward(pixels)? + positions)?;
        let mut tokens = Tensor::cat(&[class_token, patches], 0)?;
        for layer in &self.layers {
            cancel.check()?;
            tokens = layer.attend(&tokens)?;
            cancel.check()?;
            tokens = layer.feed_forward(&tokens)?;
        }
        let class_token = self.norm.forward(&tokens.narrow(0, 0, 1)?)?;
        Ok(class_token.squeeze(0)?.to_vec1()?)
    }

    /// Position embeddings of a grid of patches, row-major.
    fn positions(&self, rows: usize, columns: usize) -> Vec<f32> {
        let stored = self.architecture.stored_grid();
        position::interpolate(&self.positions, stored, self.architecture.hidden_size, rows, columns)
    }
}

#[cfg(test)]
mod tests;
