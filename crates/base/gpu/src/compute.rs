//! The compute device of a process, opened on first use.

use std::sync::{Arc, OnceLock};

use super::{ComputeSettings, DeviceChoice, Gpu, GpuError};

/// The compute device of a process. No driver is loaded before the first call of [`Self::gpu`].
#[derive(Debug)]
pub struct Compute {
    choice: DeviceChoice,
    opened: OnceLock<Option<Arc<Gpu>>>,
}

impl Compute {
    pub fn new(settings: &ComputeSettings) -> Self {
        Self { choice: settings.device, opened: OnceLock::new() }
    }

    /// The GPU. `None` if the settings choose the CPU, no GPU can be opened, or the GPU was given up. A GPU that cannot
    /// be opened is logged once. The first call loads drivers, which takes a while.
    pub fn gpu(&self) -> Option<Arc<Gpu>> {
        self.gpu_or(Gpu::open)
    }

    pub(crate) fn gpu_or(
        &self,
        open: impl FnOnce(DeviceChoice) -> Result<Option<Arc<Gpu>>, GpuError>,
    ) -> Option<Arc<Gpu>> {
        let opened = self.opened.get_or_init(|| match open(self.choice) {
            Ok(gpu) => {
                let device = gpu.as_ref().map_or("the CPU", |gpu| gpu.name());
                tracing::info!(device, "kernels have their device");
                gpu
            }
            // `auto` falls back to the CPU.
            Err(error) if self.choice == DeviceChoice::Auto => {
                tracing::info!(%error, "no GPU: computing on the CPU");
                None
            }
            Err(error) => {
                tracing::warn!(%error, "no GPU although compute.device asks for one: computing on the CPU");
                None
            }
        });
        opened.clone().filter(|gpu| gpu.given_up().is_none())
    }

    /// The GPU that [`Self::gpu`] opened, even if it was given up since.
    pub fn opened(&self) -> Option<Arc<Gpu>> {
        self.opened.get().cloned().flatten()
    }
}

#[cfg(all(test, feature = "wgpu"))]
mod tests;
