//! Tensors of a network's safetensors file by name, each checked before it is used; errors of weights and inference.

use candle_core::safetensors::BufferedSafetensors;
use candle_core::{DType, Device, Tensor};
use candle_nn::{LayerNorm, Linear};

use runtime::Cancelled;

/// Reason why the weights are rejected; the caller adds the file name.
#[derive(Debug, thiserror::Error)]
pub enum NetworkWeightsError {
    #[error("the file is not a safetensors file: {reason}")]
    Format { reason: String },
    #[error("there is no tensor {tensor}; the file is of a network of another form")]
    Missing { tensor: String },
    #[error("tensor {tensor} has shape {found:?}, but {expected} is wanted")]
    Shape { tensor: String, found: Vec<usize>, expected: String },
    #[error("tensor {tensor} holds {dtype} numbers; F32, F16, BF16 or F64 are wanted")]
    NumberType { tensor: String, dtype: String },
    #[error("tensor {tensor} holds values that are not finite; the file is damaged")]
    NotFinite { tensor: String },
    #[error("preparing the tensors failed: {0}")]
    Computation(#[from] candle_core::Error),
}

/// Reason why inference failed.
#[derive(Debug, thiserror::Error)]
pub enum NetworkError {
    #[error("the network's answer is not finite; these weights are of no use for this image")]
    NotFinite,
    #[error("a tensor operation failed: {0}")]
    Computation(#[from] candle_core::Error),
    #[error(transparent)]
    Weights(#[from] NetworkWeightsError),
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Tensors of a file by name.
pub(crate) struct NetworkWeights(BufferedSafetensors);

impl NetworkWeights {
    pub(crate) fn read(safetensors: Vec<u8>) -> Result<Self, NetworkWeightsError> {
        match BufferedSafetensors::new(safetensors) {
            Ok(file) => Ok(Self(file)),
            Err(error) => Err(NetworkWeightsError::Format { reason: error.to_string() }),
        }
    }

    pub(crate) fn has(&self, tensor: &str) -> bool {
        self.0.get(tensor).is_ok()
    }

    /// The tensor in f32, if every value is finite.
    pub(crate) fn take(&self, tensor: &str) -> Result<Tensor, NetworkWeightsError> {
        let name = || tensor.to_owned();
        let Ok(view) = self.0.get(tensor) else {
            return Err(NetworkWeightsError::Missing { tensor: name() });
        };
        let dtype = view.dtype();
        if !DType::try_from(dtype).is_ok_and(|dtype| dtype.is_float()) {
            return Err(NetworkWeightsError::NumberType { tensor: name(), dtype: format!("{dtype:?}") });
        }
        let values = self.0.load(tensor, &Device::Cpu)?.to_dtype(DType::F32)?;
        if !values.sum_all()?.to_scalar::<f32>()?.is_finite() {
            return Err(NetworkWeightsError::NotFinite { tensor: name() });
        }
        Ok(values)
    }

    /// The tensor of that shape.
    pub(crate) fn shaped(&self, tensor: &str, shape: &[usize]) -> Result<Tensor, NetworkWeightsError> {
        let values = self.take(tensor)?;
        if values.dims() != shape {
            let (found, expected) = (values.dims().to_vec(), format!("{shape:?}"));
            return Err(NetworkWeightsError::Shape { tensor: tensor.to_owned(), found, expected });
        }
        Ok(values)
    }

    /// The vector of that many values.
    pub(crate) fn vector(&self, tensor: &str, length: usize) -> Result<Tensor, NetworkWeightsError> {
        self.shaped(tensor, &[length])
    }

    /// The matrix of that many rows, if a number is given, and columns.
    pub(crate) fn matrix(
        &self,
        tensor: &str,
        rows: Option<usize>,
        columns: usize,
    ) -> Result<Tensor, NetworkWeightsError> {
        let values = self.take(tensor)?;
        let found = values.dims().to_vec();
        if !matches!(found[..], [a, b] if rows.is_none_or(|rows| rows == a) && b == columns) {
            let rows = rows.map_or("any number".to_owned(), |rows| rows.to_string());
            let expected = format!("({rows}, {columns})");
            return Err(NetworkWeightsError::Shape { tensor: tensor.to_owned(), found, expected });
        }
        Ok(values)
    }

    /// The linear layer of `<name>.weight` (outputs x inputs) and, with a bias, `<name>.bias` (outputs).
    pub(crate) fn linear(
        &self,
        name: &str,
        inputs: usize,
        outputs: usize,
        has_bias: bool,
    ) -> Result<Linear, NetworkWeightsError> {
        let weight = self.shaped(&format!("{name}.weight"), &[outputs, inputs])?;
        let bias = has_bias.then(|| self.vector(&format!("{name}.bias"), outputs)).transpose()?;
        Ok(Linear::new(weight, bias))
    }

    /// The layer norm of `<name>.weight` and `<name>.bias`, over the last dimension of that width.
    pub(crate) fn layer_norm(
        &self,
        name: &str,
        width: usize,
        epsilon: f64,
    ) -> Result<LayerNorm, NetworkWeightsError> {
        let weight = self.vector(&format!("{name}.weight"), width)?;
        let bias = self.vector(&format!("{name}.bias"), width)?;
        Ok(LayerNorm::new(weight, bias, epsilon))
    }

    /// The text of a tensor of UTF-8 bytes.
    pub(crate) fn text(&self, tensor: &str) -> Result<String, NetworkWeightsError> {
        let missing = || NetworkWeightsError::Missing { tensor: tensor.to_owned() };
        let bytes = self.0.get(tensor).map_err(|_| missing())?.data().to_vec();
        String::from_utf8(bytes).map_err(|_| missing())
    }
}
