//! Where a process computes: its GPU, looked for when it is first asked for.

use std::sync::{Arc, OnceLock};

use super::{ComputeSettings, DeviceChoice, Gpu, GpuError};

/// The device of a process. Whoever never asks for it never loads a driver.
#[derive(Debug)]
pub struct Compute {
    choice: DeviceChoice,
    opened: OnceLock<Option<Arc<Gpu>>>,
}

impl Compute {
    pub fn new(settings: &ComputeSettings) -> Self {
        Self { choice: settings.device, opened: OnceLock::new() }
    }

    /// The GPU; `None`, and once a line in the log, where there is none, where it was given up, and where the CPU was
    /// asked for. The first call takes as long as loading drivers does.
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
            // Without a GPU the CPU is what `auto` means.
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

    /// The GPU that [`Self::gpu`] found, given up or not.
    pub fn opened(&self) -> Option<Arc<Gpu>> {
        self.opened.get().cloned().flatten()
    }
}

#[cfg(test)]
mod tests;
