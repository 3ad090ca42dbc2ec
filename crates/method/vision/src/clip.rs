//! Image tower of CLIP (Radford et al., "Learning Transferable Visual Models From Natural Language Supervision", 2021)
//! from published weights.
//!
//! The feature is the projected embedding, normalized to length 1, so that the dot product of two is the cosine that
//! published evaluations report. The image is resized and cropped as in the reference ([`input`]); its patches and a
//! class token with position embeddings pass the transformer's layers ([`layer`]), all in f32. The class token is
//! normalized and projected.
//!
//! Weights are read from bytes in the layout of Hugging Face's `CLIPVisionModelWithProjection` or `CLIPModel`, whose
//! text tower is ignored: `openai/clip-vit-base-patch32` and `openai/clip-vit-large-patch14` are of this form. Every
//! tensor is checked when the model is read: a missing, misshapen or non-finite one is an error that names it.
//!
//! Embeddings agree with the reference to 1e-4, its preprocessing with Pillow to the last byte; tests verify it on
//! small random models, and a random ViT-B/32 was 5e-6 off. As of DINOv2, the last bits depend on the processor's
//! vector instructions, not on the number of threads.
//!
//! Cost: about 9 GFLOP an image with ViT-B/32, 162 with ViT-L/14.

mod architecture;
mod error;
mod input;
mod layer;

use candle_core::{D, Tensor};
use candle_nn::{LayerNorm, Linear, Module};

use crate::network_weights::{NetworkError, NetworkWeights};
use crate::patch_projection::{PatchProjection, Pixels};
use crate::unit_length::to_unit_length;
use imaging::Image;
use layer::TransformerLayer;
use runtime::CancelFlag;

pub use architecture::{ClipActivation, ClipArchitecture};
pub use error::ClipWeightsError;

/// An image tower with its weights.
pub struct ClipImageTower {
    architecture: ClipArchitecture,
    patch_projection: PatchProjection,
    /// 1 x hidden.
    class_token: Tensor,
    /// Tokens x hidden, the class token's first.
    positions: Tensor,
    pre_norm: LayerNorm,
    layers: Vec<TransformerLayer>,
    post_norm: LayerNorm,
    projection: Linear,
}

impl ClipImageTower {
    /// Reads a tower from the bytes of `config.json` and `model.safetensors`.
    ///
    /// # Errors
    ///
    /// A [`ClipWeightsError`] that names the key or tensor.
    pub fn read(config_json: &[u8], safetensors: Vec<u8>) -> Result<Self, ClipWeightsError> {
        let architecture = ClipArchitecture::read(config_json)?;
        let weights = NetworkWeights::read(safetensors)?;
        let hidden = architecture.hidden_size;
        let patch = architecture.patch_size;
        let tokens = 1 + architecture.grid() * architecture.grid();
        let norm = |name: &str| {
            weights.layer_norm(&format!("vision_model.{name}"), hidden, architecture.layer_norm_eps)
        };
        let layer = |index: usize| {
            TransformerLayer::read(&weights, &format!("vision_model.encoder.layers.{index}"), &architecture)
        };
        let embedding = |name: &str| format!("vision_model.embeddings.{name}");
        Ok(Self {
            patch_projection: PatchProjection::read(
                &weights,
                &embedding("patch_embedding"),
                patch,
                hidden,
                false,
            )?,
            class_token: weights.vector(&embedding("class_embedding"), hidden)?.reshape((1, hidden))?,
            positions: weights.matrix(&embedding("position_embedding.weight"), Some(tokens), hidden)?,
            // The name is misspelled in all published weights.
            pre_norm: norm("pre_layrnorm")?,
            layers: (0..architecture.num_hidden_layers).map(layer).collect::<Result<_, _>>()?,
            post_norm: norm("post_layernorm")?,
            projection: weights.linear("visual_projection", hidden, architecture.projection_dim, false)?,
            architecture,
        })
    }

    /// The architecture of the tower.
    pub fn architecture(&self) -> &ClipArchitecture {
        &self.architecture
    }

    /// The unit-length features of an image, whose colors are sRGB; alpha is ignored. Only the square
    /// at the center of the image counts. Cancellation is polled twice a layer.
    ///
    /// # Errors
    ///
    /// [`NetworkError::NotFinite`] for useless weights, [`NetworkError::Cancelled`] if `cancel` was set.
    pub fn features(&self, image: &Image, cancel: &CancelFlag) -> Result<Vec<f32>, NetworkError> {
        let pixels = input::pixels(image, self.architecture.image_size);
        to_unit_length(self.embedding(&pixels, cancel)?).ok_or(NetworkError::NotFinite)
    }

    /// The projected embedding (projection_dim values), of any length.
    fn embedding(&self, pixels: &Pixels, cancel: &CancelFlag) -> Result<Vec<f32>, NetworkError> {
        let patches = self.patch_projection.forward(pixels)?;
        let tokens = (Tensor::cat(&[&self.class_token, &patches], 0)? + &self.positions)?;
        let mut tokens = self.pre_norm.forward(&tokens)?;
        for layer in &self.layers {
            cancel.check()?;
            tokens = layer.attend(&tokens)?;
            cancel.check()?;
            tokens = layer.feed_forward(&tokens)?;
        }
        let class_token = self.post_norm.forward(&tokens.narrow(0, 0, 1)?)?;
        let embedding = self.projection.forward(&class_token)?;
        Ok(embedding.squeeze(D::Minus2)?.to_vec1()?)
    }
}

#[cfg(test)]
mod tests;
