//! A compute device for kernels, opened once a process, through `wgpu`.
//!
//! [`Compute`] is a process's device, [`Gpu`] one that was opened, [`transfer`] moves bytes there and back. What is
//! computed belongs to the crates above: `render` and `soft_raster`. The crate must not depend on them.
//!
//! Portable: storage buffers and 32-bit integer atomics only, the limits of OpenGL ES 3.1 but for the size of buffers.
//! Errors are values, never panics: no adapter, a job that does not fit (the device remains good), and anything a
//! driver refuses, after which the device is given up ([`Gpu::given_up`]).

mod adapters;
mod compute;
mod device;
mod nodes;
#[cfg(any(test, feature = "test-devices"))]
pub mod test_devices;
pub mod transfer;

use serde::{Deserialize, Serialize};

pub use compute::Compute;
pub use device::Gpu;

/// Which device computes.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct ComputeSettings {
    /// Where kernels run that have a GPU version.
    pub device: DeviceChoice,
}

/// Where kernels run that have a GPU version.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum DeviceChoice {
    /// On a GPU if there is one; software adapters, which gain nothing, do not count.
    Auto,
    /// On the CPU.
    Cpu,
    /// On whatever adapter there is, also a software one.
    Gpu,
}

/// Why something could not be computed on a GPU; the CPU can.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    #[error(
        "looking for a GPU: {looked_at}; install a Vulkan or OpenGL driver, or set compute.device to cpu"
    )]
    NoAdapter { looked_at: String },
    #[error("opening {adapter}: {reason}; update its driver or set compute.device to cpu")]
    NotOpened { adapter: String, reason: String },
    #[error("a picture {side_px} pixels wide or high on a GPU: at most {largest_px} fit; use a smaller one")]
    TooLarge { side_px: usize, largest_px: usize },
    #[error(
        "{attempted} on {adapter}: a buffer of {bytes} bytes, and at most {largest_bytes} fit; draw it on the CPU"
    )]
    DoesNotFit { attempted: &'static str, adapter: String, bytes: usize, largest_bytes: usize },
    #[error(
        "painting on {adapter}: more than {most} layers of glass in two rows of pixels; draw it on the CPU"
    )]
    TooManyLayers { adapter: String, most: usize },
    #[error("{attempted} on {adapter}: {reason}")]
    Failed { attempted: &'static str, adapter: String, reason: String },
}

impl GpuError {
    /// Whether another scene would fail as well; the others tell what does not fit, and leave the device good.
    pub fn is_of_the_device(&self) -> bool {
        matches!(self, Self::NoAdapter { .. } | Self::NotOpened { .. } | Self::Failed { .. })
    }
}
