//! A compute device for kernels, opened once per process, through `wgpu`.
//!
//! [`Compute`] is the device of a process, [`Gpu`] an opened device, `transfer` moves bytes between host and device. A
//! program that was built without the feature `wgpu` opens none, and computes on the CPU.
//! The kernels belong to `render`; this crate must not depend on them, nor on any other crate of the
//! workspace.
//!
//! Kernels use storage buffers and 32-bit integer atomics only. Except for buffer sizes, the limits are those of OpenGL
//! ES 3.1. Errors are values, never panics: no adapter, a job that does not fit (the device remains usable), and any
//! driver error, after which the device is given up ([`Gpu::given_up`]).
//!
//! ```
//! use gpu::{Compute, ComputeSettings, DeviceChoice};
//!
//! let compute = Compute::new(&ComputeSettings { device: DeviceChoice::Cpu });
//! assert!(compute.gpu().is_none());
//! ```

#[cfg(feature = "wgpu")]
mod adapters;
mod compute;
#[cfg(feature = "wgpu")]
mod device;
#[cfg(not(feature = "wgpu"))]
mod no_device;
#[cfg(feature = "wgpu")]
mod nodes;
#[cfg(all(feature = "wgpu", any(test, feature = "test-devices")))]
pub mod test_devices;
#[cfg(feature = "wgpu")]
pub mod transfer;

use serde::{Deserialize, Serialize};

pub use compute::Compute;
#[cfg(feature = "wgpu")]
pub use device::Gpu;
#[cfg(not(feature = "wgpu"))]
pub use no_device::Gpu;

/// Settings of the compute device.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct ComputeSettings {
    /// Device for the kernels that have a GPU version.
    pub device: DeviceChoice,
}

/// Device for the kernels that have a GPU version.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum DeviceChoice {
    /// A hardware GPU if there is one, else the CPU. Software adapters bring no gain and are skipped.
    Auto,
    /// The CPU.
    Cpu,
    /// Any adapter, including software.
    Gpu,
}

/// Failure of a computation on a GPU. The CPU kernels can do it instead.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    #[error("looking for a GPU: {rejected}; install a Vulkan or OpenGL driver, or set compute.device to cpu")]
    NoAdapter { rejected: String },
    #[error("looking for a GPU: this program was built without it; build with `--features gpu`")]
    NotBuilt,
    #[error("opening {adapter}: {reason}; update its driver or set compute.device to cpu")]
    NotOpened { adapter: String, reason: String },
    #[error("an image {side_px} pixels wide or high on a GPU: at most {largest_px} fit; use a smaller one")]
    TooLarge { side_px: usize, largest_px: usize },
    #[error(
        "{attempted} on {adapter}: a buffer of {bytes} bytes, and at most {largest_bytes} fit; draw it on the CPU"
    )]
    DoesNotFit { attempted: &'static str, adapter: String, bytes: usize, largest_bytes: usize },
    #[error(
        "rendering on {adapter}: more than {highest} layers of glass in two rows of pixels; draw it on the CPU"
    )]
    TooManyLayers { adapter: String, highest: usize },
    #[error("{attempted} on {adapter}: {reason}")]
    Failed { attempted: &'static str, adapter: String, reason: String },
}

impl GpuError {
    /// Whether the device itself failed, so that every other scene fails as well. Other errors leave the device usable.
    pub fn is_device_failure(&self) -> bool {
        matches!(self, Self::NoAdapter { .. } | Self::NotBuilt | Self::NotOpened { .. } | Self::Failed { .. })
    }
}
