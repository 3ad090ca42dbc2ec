//! The devices on which kernels are tested, for the tests of the crates above.

use std::io::Write;
use std::sync::Arc;

use wgpu::Backends;

use crate::{DeviceChoice, Gpu};

/// A device of each backend that has one.
pub fn devices() -> Vec<Arc<Gpu>> {
    let backends = [Backends::VULKAN, Backends::GL, Backends::METAL, Backends::DX12];
    let opened = backends.map(|backend| Gpu::open_among(backend, DeviceChoice::Gpu));
    let failures: Vec<String> =
        opened.iter().filter_map(|o| o.as_ref().err()).map(ToString::to_string).collect();
    let devices: Vec<_> = opened.into_iter().flatten().collect();
    if devices.is_empty() {
        let told = format!("GPU test SKIPPED, no adapter: {}", failures.join("; "));
        assert!(std::env::var("TABLETOPGEN_GPU_TESTS").as_deref() != Ok("require"), "{told}");
        // Past the harness, which hides what passing tests print.
        writeln!(std::io::stderr().lock(), "{told}").expect("standard error");
    }
    devices
}
