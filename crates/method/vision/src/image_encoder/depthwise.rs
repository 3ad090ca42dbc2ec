//! Depthwise convolution: each channel with a kernel of its own. A general convolution in groups handles a channel at a
//! time, with all its costs.

use candle_core::{CpuStorage, CustomOp1, Layout, Result, Shape, bail};

/// A square, odd-sized kernel for each channel, a bias, and then ReLU6. The output has a value for every `stride`-th
/// pixel; missing neighbors count as zeros, of an odd number of them one more at the far end ("same" padding).
pub(super) struct Depthwise {
    /// Channel by channel, each row by row.
    pub kernels: Vec<f32>,
    pub biases: Vec<f32>,
    pub side: usize,
    pub stride: usize,
}

impl CustomOp1 for Depthwise {
    fn name(&self) -> &'static str {
        "depthwise convolution"
    }

    fn cpu_fwd(&self, storage: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        let (channels, height, width) = layout.shape().dims3()?;
        let Some((from, to)) = layout.contiguous_offsets() else {
            bail!("a depthwise convolution wants contiguous values");
        };
        if channels != self.biases.len() {
            bail!("a depthwise convolution of {} channels got {channels}", self.biases.len());
        }
        let planes = storage.as_slice::<f32>()?[from..to].chunks_exact(height * width);
        let (rows, columns) = (height.div_ceil(self.stride), width.div_ceil(self.stride));
        let mut values = Vec::with_capacity(channels * rows * columns);
        let mut padded = vec![0.0; (height + self.side) * (width + self.side)];
        for (channel, plane) in planes.enumerate() {
            self.pad(plane, [height, width], &mut padded);
            self.convolve(channel, &padded, width + self.side, [rows, columns], &mut values);
        }
        Ok((CpuStorage::F32(values), Shape::from((channels, rows, columns))))
    }
}

/// Zeros before the first of `length` values.
pub(super) fn zeros_before(length: usize, side: usize, stride: usize) -> usize {
    ((length.div_ceil(stride) - 1) * stride + side).saturating_sub(length) / 2
}

impl Depthwise {
    fn pad(&self, plane: &[f32], [height, width]: [usize; 2], padded: &mut [f32]) {
        let [top, left] = [height, width].map(|length| zeros_before(length, self.side, self.stride));
        for (row, values) in plane.chunks_exact(width).enumerate() {
            padded[(row + top) * (width + self.side) + left..][..width].copy_from_slice(values);
        }
    }

    fn convolve(
        &self,
        channel: usize,
        padded: &[f32],
        padded_width: usize,
        [rows, columns]: [usize; 2],
        values: &mut Vec<f32>,
    ) {
        let kernel = &self.kernels[channel * self.side * self.side..][..self.side * self.side];
        for row in 0..rows {
            let first = values.len();
            values.resize(first + columns, self.biases[channel]);
            let sums = &mut values[first..];
            for (k, factor) in kernel.iter().enumerate() {
                let (y, x) = (row * self.stride + k / self.side, k % self.side);
                let line = &padded[y * padded_width + x..];
                match self.stride {
                    1 => sums.iter_mut().zip(line).for_each(|(sum, value)| *sum += factor * value),
                    stride => {
                        let line = line.iter().step_by(stride);
                        sums.iter_mut().zip(line).for_each(|(sum, value)| *sum += factor * value);
                    }
                }
            }
            sums.iter_mut().for_each(|sum| *sum = sum.clamp(0.0, 6.0));
        }
    }
}
