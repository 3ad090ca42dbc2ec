//! Convolutions of AlexNet (Krizhevsky, 2014, "One weird trick") and VGG16 (Simonyan and Zisserman, 2015) as
//! torchvision lays them out, up to the last map that LPIPS compares.

use candle_core::Tensor;

use super::{LpipsError, LpipsNetwork};
use crate::network_weights::{NetworkWeights, NetworkWeightsError};
use runtime::CancelFlag;

/// A convolution in torchvision's numbering of `features`; a ReLU follows each.
struct Form {
    index: usize,
    side: usize,
    stride: usize,
    padding: usize,
}

/// Layers of a network, each with the side of the pooling (stride 2) before it, 0 = none, and its convolutions. The
/// maps after the last of them are compared.
type Layout = [(usize, &'static [Form]); 5];

const fn form(index: usize, side: usize, stride: usize, padding: usize) -> Form {
    Form { index, side, stride, padding }
}

const fn three(index: usize) -> Form {
    form(index, 3, 1, 1)
}

const ALEXNET: Layout = [
    (0, &[form(0, 11, 4, 2)]),
    (3, &[form(3, 5, 1, 2)]),
    (3, &[three(6)]),
    (0, &[three(8)]),
    (0, &[three(10)]),
];

const VGG16: Layout = [
    (0, &[three(0), three(2)]),
    (2, &[three(5), three(7)]),
    (2, &[three(10), three(12), three(14)]),
    (2, &[three(17), three(19), three(21)]),
    (2, &[three(24), three(26), three(28)]),
];

struct Convolution {
    weight: Tensor,
    /// 1 x outputs x 1 x 1.
    bias: Tensor,
    stride: usize,
    padding: usize,
}

struct Layer {
    /// 0 = none.
    pooling: usize,
    convolutions: Vec<Convolution>,
    width: usize,
}

/// The network with its weights.
pub(super) struct Backbone {
    layers: Vec<Layer>,
}

impl Backbone {
    /// The tensors `features.<index>.weight` and `.bias`. Numbers of outputs follow from them.
    pub(super) fn read(network: LpipsNetwork, weights: &NetworkWeights) -> Result<Self, NetworkWeightsError> {
        let layout = match network {
            LpipsNetwork::AlexNet => ALEXNET,
            LpipsNetwork::Vgg16 => VGG16,
        };
        let mut width = 3;
        let mut layers = Vec::new();
        for (pooling, forms) in layout {
            let mut convolutions = Vec::new();
            for form in forms {
                let convolution = Convolution::read(weights, form, width)?;
                width = convolution.weight.dim(0)?;
                convolutions.push(convolution);
            }
            layers.push(Layer { pooling, convolutions, width });
        }
        Ok(Self { layers })
    }

    /// Channels of the compared maps.
    pub(super) fn layer_widths(&self) -> Vec<usize> {
        self.layers.iter().map(|layer| layer.width).collect()
    }

    /// The compared maps (1 x channels x rows x columns) of scaled colors.
    pub(super) fn maps(&self, colors: &Tensor, cancel: &CancelFlag) -> Result<Vec<Tensor>, LpipsError> {
        let mut maps = Vec::with_capacity(self.layers.len());
        let mut x = colors.clone();
        for layer in &self.layers {
            if layer.pooling > 0 {
                x = x.max_pool2d_with_stride(layer.pooling, 2)?;
            }
            for convolution in &layer.convolutions {
                cancel.check()?;
                x = convolution.forward(&x)?;
            }
            maps.push(x.clone());
        }
        Ok(maps)
    }
}

impl Convolution {
    fn read(weights: &NetworkWeights, form: &Form, inputs: usize) -> Result<Self, NetworkWeightsError> {
        let Form { index, side, stride, padding } = *form;
        let tensor = format!("features.{index}.weight");
        let weight = weights.take(&tensor)?;
        let found = weight.dims().to_vec();
        let outputs = match found[..] {
            [outputs, from, rows, columns] if [from, rows, columns] == [inputs, side, side] => outputs,
            _ => {
                let expected = format!("(any number, {inputs}, {side}, {side})");
                return Err(NetworkWeightsError::Shape { tensor, found, expected });
            }
        };
        let bias = weights.vector(&format!("features.{index}.bias"), outputs)?.reshape((1, outputs, 1, 1))?;
        Ok(Self { weight, bias, stride, padding })
    }

    fn forward(&self, x: &Tensor) -> candle_core::Result<Tensor> {
        x.conv2d(&self.weight, self.padding, self.stride, 1, 1)?.broadcast_add(&self.bias)?.relu()
    }
}
