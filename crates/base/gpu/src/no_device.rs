//! In place of a device in a program that was built without the feature `wgpu`: none can be opened.

use std::sync::Arc;

use super::{DeviceChoice, GpuError};

/// A device that cannot exist.
#[derive(Debug)]
pub enum Gpu {}

impl Gpu {
    /// `None` if the choice is the CPU.
    ///
    /// # Errors
    ///
    /// [`GpuError::NotBuilt`] for every other choice.
    pub fn open(choice: DeviceChoice) -> Result<Option<Arc<Self>>, GpuError> {
        match choice {
            DeviceChoice::Cpu => Ok(None),
            DeviceChoice::Auto | DeviceChoice::Gpu => Err(GpuError::NotBuilt),
        }
    }

    /// The name of the device.
    pub fn name(&self) -> &str {
        match *self {}
    }

    /// The first fatal error.
    pub fn given_up(&self) -> Option<String> {
        match *self {}
    }
}
