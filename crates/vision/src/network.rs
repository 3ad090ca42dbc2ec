//! The network that reads pictures of tables, from weights that `training/` wrote: what is in front at each place, the
//! outline of the top, where objects meet, touch, have their middles and stand, how high they are, and the camera.
//!
//! A small residual encoder and a decoder with skips (`training/network.py`): convolutions, additions, ReLU, doubling,
//! one mean. Widths and depths are those of the tensors, so a larger network of the same form needs no other code. Every
//! tensor is looked at when the network is read.
//!
//! Maps agree with the reference implementation to 1e-4 of values of about 10: tests see to it on a small random network.

mod error;
pub mod frame;
mod layers;
pub mod maps;

use candle_core::safetensors::BufferedSafetensors;
use candle_core::{Device, Tensor};

use frame::{Frame, Look};
use imaging::Image;
use layers::{Block, Convolution, Reader};
use maps::Maps;
use runtime::Interrupt;

pub use error::{NetworkError, NetworkWeightsError};

/// Channels of the maps, in order: four kinds, outline, border, contact, center, offset x and y,
/// base x and y, top, ground, latitude, focal length.
pub const MAP_CHANNELS: usize = 16;

/// A network with its weights.
pub struct TableNetwork {
    down: Vec<Convolution>,
    blocks: Vec<Vec<Block>>,
    spread: Convolution,
    across: Vec<Convolution>,
    up: Vec<Block>,
    maps: Convolution,
}

/// Who looks at parts of pictures and says what is there.
pub trait Looks {
    /// Maps of what the look shows of the picture.
    fn maps(&self, picture: &Image, look: Look, interrupt: &Interrupt) -> Result<Maps, NetworkError>;
}

/// What the network says of a frame, unprocessed.
pub struct Answer {
    /// Channel by channel, each row by row from the top, at half the frame's size.
    pub maps: Vec<f32>,
    pub width: usize,
    pub height: usize,
}

impl TableNetwork {
    /// Reads the bytes of `weights.safetensors`.
    pub fn read(safetensors: Vec<u8>) -> Result<Self, NetworkWeightsError> {
        let file = BufferedSafetensors::new(safetensors)
            .map_err(|error| NetworkWeightsError::Format { reason: error.to_string() })?;
        let reader = Reader(file);
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
            convolution.must_give(widths[k], &format!("across.{k}.weight"))
        });
        let maps = reader.convolution("maps", widths[0], 1)?.must_give(MAP_CHANNELS, "maps.weight")?;
        Ok(Self {
            across: across.collect::<Result<_, _>>()?,
            up: levels.map(|k| reader.block(&format!("up.{k}"), widths[k])).collect::<Result<_, _>>()?,
            spread: reader.convolution("spread", widest, 1)?.must_give(widest, "spread.weight")?,
            down,
            blocks,
            maps,
        })
    }

    /// Side lengths of a frame must be multiples of this.
    pub fn granularity_px(&self) -> usize {
        1 << self.down.len()
    }

    /// To a frame: colors -1..1, channel by channel, each row by row from the top. The interrupt is polled at each
    /// level.
    pub fn answer(
        &self,
        rgb: &[f32],
        width_px: usize,
        height_px: usize,
        interrupt: &Interrupt,
    ) -> Result<Answer, NetworkError> {
        let mut x = Tensor::from_slice(rgb, (1, 3, height_px, width_px), &Device::Cpu)?;
        let mut skips = Vec::new();
        for (down, blocks) in self.down.iter().zip(&self.blocks) {
            interrupt.check()?;
            x = down.forward(&x)?.relu()?;
            for block in blocks {
                x = block.forward(&x)?;
            }
            skips.push(x.clone());
        }
        let mean = x.mean_keepdim(3)?.mean_keepdim(2)?;
        x = x.broadcast_add(&self.spread.forward(&mean)?)?.relu()?;
        for ((across, up), skip) in self.across.iter().zip(&self.up).zip(&skips).rev() {
            interrupt.check()?;
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
        Ok(Answer { maps, width, height })
    }
}

impl Looks for TableNetwork {
    /// The mean of what the network says of the frame and of its mirror image, which errs less than either.
    fn maps(&self, picture: &Image, look: Look, interrupt: &Interrupt) -> Result<Maps, NetworkError> {
        let frame = Frame::of(picture, look);
        let [width_px, height_px] = look.frame_px;
        let answer = |rgb: &[f32]| self.answer(rgb, width_px, height_px, interrupt);
        let (seen, mirrored) = rayon::join(|| answer(&frame.rgb), || answer(&frame.mirrored()));
        Ok(Maps::new(seen?.mean_with(&mirrored?.mirrored()), look))
    }
}

#[cfg(test)]
mod tests;
