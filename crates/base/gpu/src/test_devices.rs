//! Devices for kernel tests, in this crate and in the crates that depend on it.

use std::io::Write;
use std::sync::Arc;

use wgpu::Backends;

use crate::{DeviceChoice, Gpu};

/// One device of each backend that has one.
///
/// # Panics
///
/// Panics without any device if `TABLETOPGEN_GPU_TESTS=require`.
pub fn devices() -> Vec<Arc<Gpu>> {
    let backends = [Backends::VULKAN, Backends::GL, Backends::METAL, Backends::DX12];
    let opened = backends.map(|backend| Gpu::open_among(backend, DeviceChoice::Gpu));
    let failures: Vec<String> =
        opened.iter().filter_map(|o| o.as_ref().err()).map(ToString::to_string).collect();
    let devices: Vec<_> = opened.into_iter().flatten().collect();
    if devices.is_empty() {
        let message = format!("GPU test SKIPPED, no adapter: {}", failures.join("; "));
        assert!(std::env::var("TABLETOPGEN_GPU_TESTS").as_deref() != Ok("require"), "{message}");
        // Written directly, because the test harness hides the output of passing tests.
        writeln!(std::io::stderr().lock(), "{message}").expect("standard error");
    }
    devices
}
