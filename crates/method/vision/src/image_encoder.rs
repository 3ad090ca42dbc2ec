//! Image encoder: EfficientNet-lite (Tan and Le, 2019), with normalizations folded into its convolutions.
//!
//! The recognizer of objects uses all of it, the table network the outputs of some of its first blocks, which learned
//! from photographs alone (`training/encoder.py`).

mod channel_bias;
mod depthwise;

use candle_core::{Result, Tensor};

use crate::network_weights::{NetworkWeights, NetworkWeightsError};
use channel_bias::ChannelBias;
use depthwise::{Depthwise, zeros_before};

/// Mean and standard deviation of ImageNet's red, green and blue, 0..1.
pub(crate) const MEAN: [f32; 3] = [0.485, 0.456, 0.406];
const DEVIATION: [f32; 3] = [0.229, 0.224, 0.225];

/// Input of a network that learned from ImageNet for a color of 0..1 in a channel.
pub(crate) fn normalized(channel: usize, color: f32) -> f32 {
    (color - MEAN[channel]) / DEVIATION[channel]
}

/// The network up to the mean of its last maps. Widths, depths and kernels follow from the tensors.
pub struct ImageEncoder {
    stem: Stem,
    blocks: Vec<InvertedResidual>,
    head: Pointwise,
}

/// Convolution of the colors by 3 x 3 with a stride of 2, then ReLU6.
struct Stem {
    weight: Tensor,
    bias: ChannelBias,
}

/// `x + project(depthwise(expand(x)))`, without `x` where the size or the number of channels changes.
struct InvertedResidual {
    expand: Option<Pointwise>,
    depthwise: Depthwise,
    project: Pointwise,
}

/// Convolution by 1 x 1, then ReLU6 except after a projection.
struct Pointwise {
    weight: Tensor,
    bias: ChannelBias,
}

impl ImageEncoder {
    /// Reads the encoder's tensors of a file of `training/recognizer.py`.
    pub(crate) fn read(file: &NetworkWeights) -> std::result::Result<Self, NetworkWeightsError> {
        let weight = file.take("stem.weight")?;
        let mut channels = weight.dim(0)?;
        let bias = ChannelBias::read(file, "stem.bias", channels, true)?;
        let mut blocks = Vec::new();
        while file.has(&format!("blocks.{}.project.weight", blocks.len())) {
            let block = InvertedResidual::read(file, &format!("blocks.{}", blocks.len()), channels)?;
            channels = block.project.outputs()?;
            blocks.push(block);
        }
        Ok(Self { stem: Stem { weight, bias }, blocks, head: Pointwise::read(file, "head", channels, true)? })
    }

    /// Number of features.
    pub(crate) fn features(&self) -> usize {
        self.head.weight.dim(0).unwrap_or(0)
    }

    /// Channels of the output of a block; `None` = there is no such block.
    pub(crate) fn channels_of(&self, block: usize) -> Option<usize> {
        self.blocks.get(block)?.project.outputs().ok()
    }

    /// Outputs of the blocks of these numbers, in their order, for normalized colors (channels, rows, columns).
    pub(crate) fn between(&self, rgb: &Tensor, numbers: &[usize]) -> Result<Vec<Tensor>> {
        let mut x = self.stem.forward(rgb)?;
        let mut outputs = Vec::new();
        let count = numbers.last().map_or(0, |last| last + 1);
        for (number, block) in self.blocks.iter().take(count).enumerate() {
            x = block.forward(&x)?;
            if numbers.contains(&number) {
                outputs.push(x.clone());
            }
        }
        Ok(outputs)
    }

    /// Features of normalized colors (channels, rows, columns).
    pub(crate) fn forward(&self, rgb: &Tensor) -> Result<Tensor> {
        let mut x = self.stem.forward(rgb)?;
        for block in &self.blocks {
            x = block.forward(&x)?;
        }
        self.head.forward(&x)?.mean((1, 2))
    }
}

impl Stem {
    fn forward(&self, rgb: &Tensor) -> Result<Tensor> {
        let (_, height, width) = rgb.dims3()?;
        let mut x = rgb.unsqueeze(0)?;
        for (dimension, length) in [(2, height), (3, width)] {
            let before = zeros_before(length, 3, 2);
            x = x.pad_with_zeros(dimension, before, 2)?;
        }
        let x = x.conv2d(&self.weight, 0, 2, 1, 1)?.squeeze(0)?;
        let x = x.narrow(1, 0, height.div_ceil(2))?.narrow(2, 0, width.div_ceil(2))?;
        x.contiguous()?.apply_op1_no_bwd(&self.bias)
    }
}

impl InvertedResidual {
    fn read(
        file: &NetworkWeights,
        name: &str,
        inputs: usize,
    ) -> std::result::Result<Self, NetworkWeightsError> {
        let expand = format!("{name}.expand");
        let expand = match file.has(&format!("{expand}.weight")) {
            true => Some(Pointwise::read(file, &expand, inputs, true)?),
            false => None,
        };
        let channels = expand.as_ref().map_or(Ok(inputs), Pointwise::outputs)?;
        let tensor = format!("{name}.depthwise.weight");
        let kernels = file.take(&tensor)?;
        let found = kernels.dims().to_vec();
        let [_, side, _] = found[..] else {
            let expected = format!("({channels}, n, n)");
            return Err(NetworkWeightsError::Shape { tensor, found, expected });
        };
        if found != [channels, side, side] || side % 2 == 0 {
            let expected = format!("({channels}, n, n) with an odd n");
            return Err(NetworkWeightsError::Shape { tensor, found, expected });
        }
        let stride = file.vector(&format!("{name}.stride"), 1)?.to_vec1::<f32>()?[0] as usize;
        let depthwise = Depthwise {
            kernels: kernels.flatten_all()?.to_vec1()?,
            biases: file.vector(&format!("{name}.depthwise.bias"), channels)?.to_vec1()?,
            side,
            stride: stride.max(1),
        };
        let project = Pointwise::read(file, &format!("{name}.project"), channels, false)?;
        Ok(Self { expand, depthwise, project })
    }

    fn forward(&self, x: &Tensor) -> Result<Tensor> {
        let wide = match &self.expand {
            Some(expand) => &expand.forward(x)?,
            None => x,
        };
        let y = self.project.forward(&wide.apply_op1_no_bwd(&self.depthwise)?)?;
        if y.dims() == x.dims() { x + y } else { Ok(y) }
    }
}

impl Pointwise {
    fn read(
        file: &NetworkWeights,
        name: &str,
        inputs: usize,
        is_capped: bool,
    ) -> std::result::Result<Self, NetworkWeightsError> {
        let weight = file.matrix(&format!("{name}.weight"), None, inputs)?;
        let outputs = weight.dim(0)?;
        let bias = ChannelBias::read(file, &format!("{name}.bias"), outputs, is_capped)?;
        Ok(Self { weight, bias })
    }

    fn outputs(&self) -> Result<usize> {
        self.weight.dim(0)
    }

    fn forward(&self, x: &Tensor) -> Result<Tensor> {
        let (channels, height, width) = x.dims3()?;
        let flat = x.reshape((channels, height * width))?;
        let y = self.weight.matmul(&flat)?.reshape((self.outputs()?, height, width))?;
        y.apply_op1_no_bwd(&self.bias)
    }
}
