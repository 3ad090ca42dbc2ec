//! Object recognizer: a network that names the object in a part of an image.
//!
//! The encoder is EfficientNet-lite2 (Tan and Le, 2019), trained by others on the photographs of ImageNet. Its last
//! blocks and a linear classifier on its features learned from close-ups of every category of the catalog, and of
//! shapes of no category, so that it can answer "unknown" (`training/recognizer.py`). The model card is
//! `weights/README.md`.
//!
//! Probabilities agree with the reference implementation to 1e-4; a test verifies it on a small random network.

mod crop;

use std::sync::Arc;

use candle_core::{Device, Tensor};
use rayon::prelude::*;

use crate::image_encoder::ImageEncoder;
use crate::network_weights::{NetworkError, NetworkWeights, NetworkWeightsError};
use catalog::Category;
use crop::square_crop;
use imaging::{Image, Mask};
use runtime::CancelFlag;

/// The recognizer with its weights.
pub struct ObjectRecognizer {
    encoder: Arc<ImageEncoder>,
    /// One row for each class.
    weight: Tensor,
    bias: Tensor,
    /// Category of each class; `None` = unknown, or not in this catalog.
    classes: Vec<Option<&'static Category>>,
    input_px: usize,
}

/// A category that an object may have.
#[derive(Clone, Copy, Debug)]
pub struct CategoryGuess {
    pub category: &'static Category,
    /// Probability, 0..1. Those of all categories add up to one minus the probability of "unknown".
    pub probability: f64,
}

/// Guesses below this probability are left out.
const MIN_PROBABILITY: f64 = 1e-3;

impl ObjectRecognizer {
    /// Reads the bytes of a file of `training/recognizer.py`. Classes that the catalog does not have count as
    /// unknown.
    ///
    /// # Errors
    ///
    /// A [`NetworkWeightsError`] that names the missing or unfit tensor.
    pub fn read(safetensors: Vec<u8>) -> Result<Self, NetworkWeightsError> {
        let file = NetworkWeights::read(safetensors)?;
        let encoder = Arc::new(ImageEncoder::read(&file)?);
        let names = file.text("categories")?;
        let classes: Vec<_> = names.lines().map(catalog::category).collect();
        let weight = file.matrix("classes.weight", Some(classes.len()), encoder.features())?;
        let bias = file.vector("classes.bias", classes.len())?;
        let input_px = file.vector("input_px", 1)?.to_vec1::<f32>()?[0] as usize;
        Ok(Self { encoder, weight, bias, classes, input_px })
    }

    /// The encoder, for the table network.
    pub fn encoder(&self) -> Arc<ImageEncoder> {
        self.encoder.clone()
    }

    /// The likely categories of the objects with these masks, most likely first.
    ///
    /// # Errors
    ///
    /// [`NetworkError::NotFinite`] for useless weights, [`NetworkError::Cancelled`] if `cancel` was set.
    pub fn recognize(
        &self,
        image: &Image,
        masks: &[&Mask],
        cancel: &CancelFlag,
    ) -> Result<Vec<Vec<CategoryGuess>>, NetworkError> {
        let guesses = |mask: &&Mask| {
            cancel.check()?;
            let square = square_crop(image, mask, self.input_px);
            square.map_or(Ok(Vec::new()), |square| self.guesses(&self.probabilities(&square)?))
        };
        masks.par_iter().map(guesses).collect()
    }

    /// Probability of each class for a square of normalized colors, channel by channel.
    fn probabilities(&self, rgb: &[f32]) -> Result<Vec<f32>, NetworkError> {
        let x = Tensor::from_slice(rgb, (3, self.input_px, self.input_px), &Device::Cpu)?;
        let features = self.encoder.forward(&x)?.unsqueeze(1)?;
        let logits = (self.weight.matmul(&features)?.squeeze(1)? + &self.bias)?;
        Ok(candle_nn::ops::softmax(&logits, 0)?.to_vec1()?)
    }

    fn guesses(&self, probabilities: &[f32]) -> Result<Vec<CategoryGuess>, NetworkError> {
        if probabilities.iter().any(|p| !p.is_finite()) {
            return Err(NetworkError::NotFinite);
        }
        let known = self.classes.iter().zip(probabilities).filter_map(|(class, p)| {
            let (category, probability) = ((*class)?, f64::from(*p));
            (probability >= MIN_PROBABILITY).then_some(CategoryGuess { category, probability })
        });
        let mut guesses: Vec<CategoryGuess> = known.collect();
        guesses.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        Ok(guesses)
    }
}

#[cfg(test)]
mod tests;
