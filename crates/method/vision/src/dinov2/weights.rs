//! Tensors of a safetensors file by name, each checked before it is used.

use candle_core::safetensors::BufferedSafetensors;
use candle_core::{DType, Device, Tensor};

use super::error::Dinov2WeightsError;

/// The file; unused tensors are not checked.
pub(super) struct Weights(BufferedSafetensors);

impl Weights {
    pub(super) fn read(safetensors: Vec<u8>) -> Result<Self, Dinov2WeightsError> {
        match BufferedSafetensors::new(safetensors) {
            Ok(file) => Ok(Self(file)),
            Err(error) => Err(Dinov2WeightsError::Format { reason: error.to_string() }),
        }
    }

    /// The tensor, in f32, if it has this shape and every value is finite.
    pub(super) fn take(&self, tensor: &str, shape: &[usize]) -> Result<Tensor, Dinov2WeightsError> {
        let name = || tensor.to_owned();
        let Ok(view) = self.0.get(tensor) else {
            return Err(Dinov2WeightsError::Missing { tensor: name() });
        };
        if view.shape() != shape {
            let (found, expected) = (view.shape().to_vec(), shape.to_vec());
            return Err(Dinov2WeightsError::Shape { tensor: name(), found, expected });
        }
        let dtype = view.dtype();
        if !DType::try_from(dtype).is_ok_and(|dtype| dtype.is_float()) {
            return Err(Dinov2WeightsError::NumberType { tensor: name(), dtype: format!("{dtype:?}") });
        }
        let values = self.0.load(tensor, &Device::Cpu)?.to_dtype(DType::F32)?;
        if !values.sum_all()?.to_scalar::<f32>()?.is_finite() {
            return Err(Dinov2WeightsError::NotFinite { tensor: name() });
        }
        Ok(values)
    }
}
