//! Outputs of reference implementations for tests: tensors of a safetensors file by name.

use candle_core::safetensors::BufferedSafetensors;
use candle_core::{DType, Device, Tensor};
use serde_json::Value;

use imaging::Image;

/// A file of `tests/golden/`.
pub struct Golden(BufferedSafetensors);

impl Golden {
    pub fn open(safetensors: &[u8]) -> Self {
        Self(BufferedSafetensors::new(safetensors.to_vec()).expect("a golden file"))
    }

    pub fn tensor(&self, name: &str) -> Tensor {
        self.0.load(name, &Device::Cpu).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Values of a tensor of floating-point numbers or bytes.
    pub fn values(&self, name: &str) -> Vec<f32> {
        let values = self.tensor(name).to_dtype(DType::F32).expect("numbers");
        values.flatten_all().expect("flat").to_vec1().expect("f32")
    }

    /// An image from a tensor of bytes (rows x columns x 3 or 4); opaque without a fourth channel.
    pub fn image(&self, name: &str) -> Image {
        let bytes = self.tensor(name);
        let (height, width, channels) = bytes.dims3().expect("rows, columns, channels");
        let bytes = bytes.flatten_all().expect("flat").to_vec1::<u8>().expect("bytes");
        let rgba = bytes
            .chunks_exact(channels)
            .flat_map(|pixel| [pixel[0], pixel[1], pixel[2], pixel.get(3).copied().unwrap_or(255)]);
        Image::from_rgba(width as u32, height as u32, rgba.collect()).expect("four bytes a pixel")
    }
}

/// Largest difference of two values at one place.
pub fn apart(found: &[f32], golden: &[f32]) -> f32 {
    assert_eq!(found.len(), golden.len());
    found.iter().zip(golden).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

pub fn tensor_names(safetensors: &[u8]) -> Vec<String> {
    let (_, header) = header(safetensors);
    let names = header.as_object().expect("an object").keys().filter(|name| *name != "__metadata__");
    names.cloned().collect()
}

/// The values of one tensor, in place.
pub fn bytes_of<'a>(safetensors: &'a mut [u8], tensor: &str) -> &'a mut [u8] {
    let (start, header) = header(safetensors);
    let offset = |index: usize| header[tensor]["data_offsets"][index].as_u64().expect("offset") as usize;
    let (first, end) = (offset(0), offset(1));
    &mut safetensors[start + first..start + end]
}

fn header(safetensors: &[u8]) -> (usize, Value) {
    let length = u64::from_le_bytes(safetensors[..8].try_into().expect("eight bytes")) as usize;
    (8 + length, serde_json::from_slice(&safetensors[8..8 + length]).expect("JSON"))
}
