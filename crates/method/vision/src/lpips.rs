//! LPIPS 0.1, the learned perceptual distance of two images (Zhang et al., "The Unreasonable Effectiveness of Deep
//! Features as a Perceptual Metric", 2018), from published weights.
//!
//! Both images pass the convolutions of a classifier of ImageNet ([`backbone`]). At five places the maps are divided by
//! their length over the channels, subtracted and squared; a weighted sum over the channels, which was fitted to
//! people's judgments, and the mean over all places give one number a layer. The distance is the sum of the five: 0 for
//! equal images, and larger the less alike they are.
//!
//! Weights are read from bytes: the classifier as a state dict of torchvision, the sums as that of the package `lpips`,
//! both as safetensors. Widths follow from the tensors, all of which are checked when the model is read.
//!
//! Distances agree with the package `lpips` 0.1.4 to 1e-5. Tests verify it on narrow random models; random ones of
//! full width were 4e-9 off, at distances of 0.03. As of DINOv2, the last bits depend on the processor's vector
//! instructions, not on the number of threads.
//!
//! Cost at 224 x 224 pixels an image: 1.3 GFLOP with AlexNet, 31 with VGG16; memory 2 MB and 25 MB for its
//! [`LpipsFeatures`].

mod backbone;
mod error;

use candle_core::{Device, Tensor};

use crate::network_weights::{NetworkWeights, NetworkWeightsError};
use backbone::Backbone;
use imaging::Image;
use runtime::CancelFlag;

pub use error::{LpipsError, LpipsWeightsError};

/// Classifier whose maps are compared. Distances of different ones are not comparable; published tables mean AlexNet
/// unless they say otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LpipsNetwork {
    AlexNet,
    Vgg16,
}

/// Shortest side of an image that leaves something after the last pooling of both networks, pixels.
pub const MIN_SIDE_PX: u32 = 32;

/// Mean and deviation of the scaling layer, for colors of -1..1: those of ImageNet as the reference rounds them.
const SHIFT: [f32; 3] = [-0.030, -0.088, -0.188];
const SCALE: [f32; 3] = [0.458, 0.448, 0.450];

/// Addend to a length before a division by it, that of the reference.
const EPSILON: f64 = 1e-10;

/// A model with its weights.
pub struct Lpips {
    network: LpipsNetwork,
    backbone: Backbone,
    /// Weight of each channel, one tensor (1 x channels) a layer.
    layer_weights: Vec<Tensor>,
}

/// Maps of one image, divided by their length over the channels. An image that is compared with many is passed through
/// the network once.
pub struct LpipsFeatures {
    size_px: [u32; 2],
    network: LpipsNetwork,
    /// Channels x places, one tensor a layer.
    layers: Vec<Tensor>,
}

impl LpipsNetwork {
    /// Name in torchvision.
    pub fn name(self) -> &'static str {
        match self {
            Self::AlexNet => "alexnet",
            Self::Vgg16 => "vgg16",
        }
    }
}

impl Lpips {
    /// Reads a model from the bytes of two safetensors files: `backbone` with torchvision's `features.0.weight` and so
    /// on, `linear_layers` with the package's `lin0.model.1.weight` to `lin4.model.1.weight`. Others are ignored.
    ///
    /// # Errors
    ///
    /// A [`LpipsWeightsError`] that names the file's content and the tensor.
    pub fn read(
        network: LpipsNetwork,
        backbone: Vec<u8>,
        linear_layers: Vec<u8>,
    ) -> Result<Self, LpipsWeightsError> {
        let backbone = NetworkWeights::read(backbone)
            .and_then(|weights| Backbone::read(network, &weights))
            .map_err(|source| LpipsWeightsError::Backbone { network: network.name(), source })?;
        let layer_weights = layer_weights(linear_layers, &backbone.layer_widths())
            .map_err(|source| LpipsWeightsError::LinearLayers { network: network.name(), source })?;
        Ok(Self { network, backbone, layer_weights })
    }

    /// The network that the weights are of.
    pub fn network(&self) -> LpipsNetwork {
        self.network
    }

    /// Maps of an image, whose colors are sRGB; alpha is ignored. The image is not resized: the distance depends on the
    /// size, so the caller brings both to one, by [`resized`](crate::resized) where they differ. Cancellation is polled
    /// at every convolution.
    ///
    /// # Errors
    ///
    /// [`LpipsError::TooSmall`] below [`MIN_SIDE_PX`], [`LpipsError::Cancelled`] if `cancel` was set.
    pub fn features(&self, image: &Image, cancel: &CancelFlag) -> Result<LpipsFeatures, LpipsError> {
        let (width_px, height_px) = (image.width_px(), image.height_px());
        if width_px.min(height_px) < MIN_SIDE_PX {
            return Err(LpipsError::TooSmall { width_px, height_px });
        }
        let maps = self.backbone.maps(&input(image)?, cancel)?;
        let layers = maps.iter().map(with_unit_channels).collect::<candle_core::Result<_>>()?;
        Ok(LpipsFeatures { size_px: [width_px, height_px], network: self.network, layers })
    }

    /// Distance of two images of one size, 0 and up.
    ///
    /// # Errors
    ///
    /// [`LpipsError::SizesDiffer`] and [`LpipsError::NetworksDiffer`] for maps that have nothing in common,
    /// [`LpipsError::NotFinite`] for useless weights.
    pub fn distance(&self, a: &LpipsFeatures, b: &LpipsFeatures) -> Result<f64, LpipsError> {
        if a.network != self.network || b.network != self.network {
            return Err(LpipsError::NetworksDiffer);
        }
        if a.size_px != b.size_px {
            return Err(LpipsError::SizesDiffer { a: a.size_px, b: b.size_px });
        }
        let mut distance = 0.0;
        for ((weights, a), b) in self.layer_weights.iter().zip(&a.layers).zip(&b.layers) {
            let weighted = weights.matmul(&(a - b)?.sqr()?)?;
            distance += f64::from(weighted.mean_all()?.to_scalar::<f32>()?);
        }
        if distance.is_finite() { Ok(distance) } else { Err(LpipsError::NotFinite) }
    }
}

/// Weights of the channels of each layer (1 x channels).
fn layer_weights(safetensors: Vec<u8>, widths: &[usize]) -> Result<Vec<Tensor>, NetworkWeightsError> {
    let weights = NetworkWeights::read(safetensors)?;
    let layer = |(layer, width): (usize, &usize)| {
        Ok(weights.shaped(&format!("lin{layer}.model.1.weight"), &[1, *width, 1, 1])?.reshape((1, *width))?)
    };
    widths.iter().enumerate().map(layer).collect()
}

/// Scaled colors (1 x 3 x rows x columns).
fn input(image: &Image) -> candle_core::Result<Tensor> {
    let (width, height) = (image.width_px() as usize, image.height_px() as usize);
    let pixels = || image.as_rgba().chunks_exact(4);
    let mut colors = Vec::with_capacity(3 * width * height);
    for channel in 0..3 {
        let scaled = |byte: u8| (2.0 * f32::from(byte) / 255.0 - 1.0 - SHIFT[channel]) / SCALE[channel];
        colors.extend(pixels().map(|pixel| scaled(pixel[channel])));
    }
    Tensor::from_vec(colors, (1, 3, height, width), &Device::Cpu)
}

/// Maps (1 x channels x rows x columns) divided by their length over the channels, as channels x places.
fn with_unit_channels(maps: &Tensor) -> candle_core::Result<Tensor> {
    let maps = maps.squeeze(0)?.flatten_from(1)?;
    let length = (maps.sqr()?.sum_keepdim(0)?.sqrt()? + EPSILON)?;
    maps.broadcast_div(&length)
}

#[cfg(test)]
mod tests;
