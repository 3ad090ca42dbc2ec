//! Table network: a dense predictor for images of tables, with weights from `training/`.
//!
//! Per cell it predicts the class, the outline of the top, object borders and contacts, center heatmap and votes,
//! footprint, height, and the camera.
//!
//! Architecture: a small residual encoder and a decoder with skip connections (`training/network.py`). It uses
//! convolutions, additions, ReLU, upsampling by 2 and one global mean. Widths and depths follow from the tensors,
//! so a larger network of the same form needs no other code. Every tensor is checked when the network is read. The last
//! levels of its encoder also get outputs of the pretrained [`ImageEncoder`], which has seen photographs.
//!
//! Maps agree with the reference implementation to 1e-4 at values of about 10; tests verify it on a small random
//! network.

pub mod frame;
mod layers;
pub mod maps;

use std::sync::Arc;

use candle_core::{Device, Tensor};

use crate::image_encoder::{ImageEncoder, normalized};
use crate::network_weights::{NetworkError, NetworkWeights, NetworkWeightsError};
use frame::{Frame, ImageCrop};
use imaging::Image;
use layers::{Block, Convolution};
use maps::Maps;
use runtime::CancelFlag;

/// Channels of the maps, in order: four classes, outline, border, contact, center, offset x and y, base x and y,
/// top, ground, latitude, focal length.
pub const MAP_CHANNELS: usize = 16;

/// The network with its weights.
pub struct TableNetwork {
    down: Vec<Convolution>,
    blocks: Vec<Vec<Block>>,
    spread: Convolution,
    across: Vec<Convolution>,
    up: Vec<Block>,
    maps: Convolution,
    pretrained: PretrainedFeatures,
}

/// Outputs of some blocks of the pretrained encoder, and the convolutions that lead them to the last levels.
struct PretrainedFeatures {
    encoder: Arc<ImageEncoder>,
    blocks: Vec<usize>,
    convolutions: Vec<Convolution>,
}

/// A dense predictor: per-pixel maps for an image crop.
pub trait DensePredictor {
    /// Maps of a crop of the image.
    ///
    /// # Errors
    ///
    /// [`NetworkError::NotFinite`] for useless weights, [`NetworkError::Cancelled`] if `cancel` was set.
    fn maps(&self, image: &Image, crop: ImageCrop, cancel: &CancelFlag) -> Result<Maps, NetworkError>;
}

/// Raw output of the network for a frame.
pub struct RawMaps {
    /// Channel by channel, each row by row from the top, at half the frame's size.
    pub maps: Vec<f32>,
    pub width: usize,
    pub height: usize,
}

impl TableNetwork {
    /// Reads the bytes of `weights.safetensors`, which were trained with that encoder.
    ///
    /// # Errors
    ///
    /// A [`NetworkWeightsError`] that names the missing or unfit tensor.
    pub fn read(safetensors: Vec<u8>, encoder: Arc<ImageEncoder>) -> Result<Self, NetworkWeightsError> {
        let reader = NetworkWeights::read(safetensors)?;
        let (mut down, mut blocks, mut widths) = (Vec::new(), Vec::new(), vec![3]);
        while reader.has(&format!("down.{}.weight", down.len())) {
            let level = down.len();
            let convolution = reader.convolution(&format!("down.{level}"), widths[level], 2)?;
            widths.push(convolution.outputs()?);
            let mut own = Vec::new();
            while reader.has(&format!("blocks.{level}.{}.narrow.weight", own.len())) {
                own.push(reader.block(&format!("blocks.{level}.{}", own.len()), widths[level + 1])?);
            }
            down.push(convolution);
            blocks.push(own);
        }
        if down.len() < 2 {
            return Err(NetworkWeightsError::Missing { tensor: format!("down.{}.weight", down.len()) });
        }
        let widths = &widths[1..];
        let widest = widths[widths.len() - 1];
        let levels = 0..widths.len() - 1;
        let across = levels.clone().map(|k| {
            let convolution = reader.convolution(&format!("across.{k}"), widths[k + 1], 1)?;
            convolution.with_outputs(widths[k], &format!("across.{k}.weight"))
        });
        let maps = reader.convolution("maps", widths[0], 1)?.with_outputs(MAP_CHANNELS, "maps.weight")?;
        Ok(Self {
            pretrained: PretrainedFeatures::read(&reader, encoder, widths)?,
            across: across.collect::<Result<_, _>>()?,
            up: levels.map(|k| reader.block(&format!("up.{k}"), widths[k])).collect::<Result<_, _>>()?,
            spread: reader.convolution("spread", widest, 1)?.with_outputs(widest, "spread.weight")?,
            down,
            blocks,
            maps,
        })
    }

    /// Side lengths of a frame must be multiples of this.
    pub fn granularity_px(&self) -> usize {
        1 << self.down.len()
    }

    /// Runs the network on a frame: colors -1..1, channel by channel, each row by row from the top. Cancellation
    /// is polled at each level.
    pub fn answer(
        &self,
        rgb: &[f32],
        width_px: usize,
        height_px: usize,
        cancel: &CancelFlag,
    ) -> Result<RawMaps, NetworkError> {
        let mut x = Tensor::from_slice(rgb, (1, 3, height_px, width_px), &Device::Cpu)?;
        let features = self.pretrained.of(rgb, width_px, height_px)?;
        let first_level = self.down.len() - features.len();
        let mut skips = Vec::new();
        for (level, (down, blocks)) in self.down.iter().zip(&self.blocks).enumerate() {
            cancel.check()?;
            x = down.forward(&x)?;
            if level >= first_level {
                x = (x + &features[level - first_level])?;
            }
            x = x.relu()?;
            for block in blocks {
                x = block.forward(&x)?;
            }
            skips.push(x.clone());
        }
        let mean = x.mean_keepdim(3)?.mean_keepdim(2)?;
        x = x.broadcast_add(&self.spread.forward(&mean)?)?.relu()?;
        for ((across, up), skip) in self.across.iter().zip(&self.up).zip(&skips).rev() {
            cancel.check()?;
            let (_, _, height, width) = skip.dims4()?;
            x = across.forward(&x)?.upsample_nearest2d(height, width)?;
            x = up.forward(&(x + skip)?.relu()?)?;
        }
        let maps = self.maps.forward(&x)?;
        let (_, _, height, width) = maps.dims4()?;
        let maps: Vec<f32> = maps.flatten_all()?.to_vec1()?;
        if maps.iter().any(|value| !value.is_finite()) {
            return Err(NetworkError::NotFinite);
        }
        Ok(RawMaps { maps, width, height })
    }
}

impl PretrainedFeatures {
    fn read(
        reader: &NetworkWeights,
        encoder: Arc<ImageEncoder>,
        widths: &[usize],
    ) -> Result<Self, NetworkWeightsError> {
        let tensor = "known.blocks";
        let blocks: Vec<usize> = reader
            .take(tensor)?
            .flatten_all()?
            .to_vec1::<f32>()?
            .iter()
            .map(|block| *block as usize)
            .collect();
        let unfit = |expected: String| NetworkWeightsError::Shape {
            tensor: tensor.to_owned(),
            found: blocks.clone(),
            expected,
        };
        if blocks.len() > widths.len() || !blocks.is_sorted() {
            return Err(unfit(format!("at most {} numbers in ascending order", widths.len())));
        }
        let last_widths = &widths[widths.len() - blocks.len()..];
        let convolution = |(k, (block, width)): (usize, (&usize, &usize))| {
            let channels = encoder.channels_of(*block);
            let channels = channels.ok_or_else(|| unfit("numbers of blocks of the encoder".to_owned()))?;
            let name = format!("known.{k}");
            reader.convolution(&name, channels, 1)?.with_outputs(*width, &format!("{name}.weight"))
        };
        let convolutions =
            blocks.iter().zip(last_widths).enumerate().map(convolution).collect::<Result<_, _>>()?;
        Ok(Self { convolutions, encoder, blocks })
    }

    /// Contribution to each of the last levels for a frame of colors -1..1.
    fn of(&self, rgb: &[f32], width_px: usize, height_px: usize) -> Result<Vec<Tensor>, NetworkError> {
        let area = width_px * height_px;
        let colors = rgb.iter().enumerate().map(|(k, color)| normalized(k / area, 0.5 * (color + 1.0)));
        let x = Tensor::from_vec(colors.collect(), (3, height_px, width_px), &Device::Cpu)?;
        let outputs = self.encoder.between(&x, &self.blocks)?;
        let add = |(output, convolution): (&Tensor, &Convolution)| convolution.forward(&output.unsqueeze(0)?);
        Ok(outputs.iter().zip(&self.convolutions).map(add).collect::<candle_core::Result<_>>()?)
    }
}

impl DensePredictor for TableNetwork {
    /// Mean of the predictions for the frame and its mirror image, whose error is smaller than that of either.
    fn maps(&self, image: &Image, crop: ImageCrop, cancel: &CancelFlag) -> Result<Maps, NetworkError> {
        let frame = Frame::of(image, crop);
        let [width_px, height_px] = crop.frame_px;
        let answer = |rgb: &[f32]| self.answer(rgb, width_px, height_px, cancel);
        let (seen, mirrored) = rayon::join(|| answer(&frame.rgb), || answer(&frame.mirrored()));
        Ok(Maps::new(seen?.mean_with(&mirrored?.mirrored()), crop))
    }
}

#[cfg(test)]
mod tests;
