//! Which adapter is taken.

use std::cmp::Reverse;

use wgpu::{Adapter, AdapterInfo, Backends, DeviceType, DownlevelFlags, Instance, Limits};

use super::{DeviceChoice, GpuError};

/// The best adapter that is there and can do what the kernels ask; `auto` refuses software.
pub fn best(instance: &Instance, backends: Backends, choice: DeviceChoice) -> Result<Adapter, GpuError> {
    let mut found = pollster::block_on(instance.enumerate_adapters(backends));
    let mut looked_at: Vec<String> = Vec::new();
    found.retain(|adapter| {
        let refused = refusal(adapter, choice);
        looked_at.extend(refused.map(|why| format!("{} {why}", described(&adapter.get_info()))));
        refused.is_none()
    });
    let best = found.into_iter().min_by_key(|adapter| Reverse(rank(&adapter.get_info())));
    best.ok_or_else(|| GpuError::NoAdapter {
        looked_at: if looked_at.is_empty() { "there is no adapter".into() } else { looked_at.join(", ") },
    })
}

/// Whether the second failure tells more than the first.
pub fn told_more(first: &GpuError, second: &GpuError) -> bool {
    let nothing_there = |error: &GpuError| match error {
        GpuError::NoAdapter { looked_at } => looked_at.starts_with("there is no"),
        _ => false,
    };
    nothing_there(first) || !nothing_there(second)
}

/// Backend, name and driver.
pub fn described(info: &AdapterInfo) -> String {
    let words = [info.backend.to_str(), &info.name, &info.driver, &info.driver_info];
    words.into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" ")
}

fn refusal(adapter: &Adapter, choice: DeviceChoice) -> Option<&'static str> {
    if !adapter.get_downlevel_capabilities().flags.contains(DownlevelFlags::COMPUTE_SHADERS) {
        return Some("has no compute shaders");
    }
    if !Limits::downlevel_defaults().check_limits(&adapter.limits()) {
        return Some("is below the limits of OpenGL ES 3.1");
    }
    // Of an unknown type is also what some software renderers report.
    let hardware = [DeviceType::DiscreteGpu, DeviceType::IntegratedGpu, DeviceType::VirtualGpu];
    let software = !hardware.contains(&adapter.get_info().device_type);
    (choice == DeviceChoice::Auto && software).then_some("is a software renderer")
}

/// More is better.
fn rank(info: &AdapterInfo) -> u32 {
    match info.device_type {
        DeviceType::DiscreteGpu => 4,
        DeviceType::IntegratedGpu => 3,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 1,
        DeviceType::Cpu => 0,
    }
}
