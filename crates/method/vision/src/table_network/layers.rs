//! Convolutions and residual blocks, read by name and checked.

use candle_core::{Result, Tensor};

use crate::network_weights::{NetworkWeights, NetworkWeightsError};

/// Square, odd-sized, padded by half its size; with a bias.
pub(super) struct Convolution {
    weight: Tensor,
    bias: Tensor,
    stride: usize,
    padding: usize,
}

/// `relu(x + widen(relu(narrow(x))))`.
pub(super) struct Block {
    narrow: Convolution,
    widen: Convolution,
}

impl NetworkWeights {
    pub(super) fn convolution(
        &self,
        name: &str,
        inputs: usize,
        stride: usize,
    ) -> std::result::Result<Convolution, NetworkWeightsError> {
        let (tensor, weight) = (format!("{name}.weight"), self.take(&format!("{name}.weight"))?);
        let found = weight.dims().to_vec();
        let sound = matches!(found[..], [_, from, a, b] if from == inputs && a == b && a % 2 == 1);
        if !sound {
            let expected = format!("(any number, {inputs}, n, n) with an odd n");
            return Err(NetworkWeightsError::Shape { tensor, found, expected });
        }
        let bias = self.vector(&format!("{name}.bias"), found[0])?.reshape((1, found[0], 1, 1))?;
        Ok(Convolution { weight, bias, stride, padding: found[2] / 2 })
    }

    pub(super) fn block(&self, name: &str, width: usize) -> std::result::Result<Block, NetworkWeightsError> {
        let narrow = self.convolution(&format!("{name}.narrow"), width, 1)?;
        let widen = self.convolution(&format!("{name}.widen"), narrow.outputs()?, 1)?;
        Ok(Block { narrow, widen: widen.with_outputs(width, &format!("{name}.widen.weight"))? })
    }
}

impl Convolution {
    pub(super) fn outputs(&self) -> Result<usize> {
        self.weight.dim(0)
    }

    /// The convolution itself, if it has this number of outputs.
    pub(super) fn with_outputs(
        self,
        outputs: usize,
        tensor: &str,
    ) -> std::result::Result<Self, NetworkWeightsError> {
        let found = self.weight.dims().to_vec();
        if found[0] == outputs {
            return Ok(self);
        }
        let expected = format!("({outputs}, {}, {}, {})", found[1], found[2], found[3]);
        Err(NetworkWeightsError::Shape { tensor: tensor.to_owned(), found, expected })
    }

    pub(super) fn forward(&self, x: &Tensor) -> Result<Tensor> {
        x.conv2d(&self.weight, self.padding, self.stride, 1, 1)?.broadcast_add(&self.bias)
    }
}

impl Block {
    pub(super) fn forward(&self, x: &Tensor) -> Result<Tensor> {
        (x + self.widen.forward(&self.narrow.forward(x)?.relu()?)?)?.relu()
    }
}
