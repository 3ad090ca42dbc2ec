//! Selection of the adapter.

use std::cmp::Reverse;

use wgpu::{Adapter, AdapterInfo, Backends, DeviceType, DownlevelFlags, Instance, Limits};

use super::{DeviceChoice, GpuError};

/// The best present adapter that meets the requirements of the kernels. `Auto` rejects software renderers.
///
/// # Errors
///
/// [`GpuError::NoAdapter`] with the reason for each rejected adapter.
pub fn best(instance: &Instance, backends: Backends, choice: DeviceChoice) -> Result<Adapter, GpuError> {
    let mut found = pollster::block_on(instance.enumerate_adapters(backends));
    let mut rejected: Vec<String> = Vec::new();
    found.retain(|adapter| {
        let refused = refusal(adapter, choice);
        rejected.extend(refused.map(|why| format!("{} {why}", described(&adapter.get_info()))));
        refused.is_none()
    });
    let best = found.into_iter().min_by_key(|adapter| Reverse(rank(&adapter.get_info())));
    best.ok_or_else(|| GpuError::NoAdapter {
        rejected: if rejected.is_empty() { "there is no adapter".into() } else { rejected.join(", ") },
    })
}

/// Whether the second failure is at least as informative as the first: it names an adapter, or neither does.
pub fn is_more_informative(first: &GpuError, second: &GpuError) -> bool {
    let names_no_adapter = |error: &GpuError| match error {
        GpuError::NoAdapter { rejected } => rejected.starts_with("there is no"),
        _ => false,
    };
    names_no_adapter(first) || !names_no_adapter(second)
}

/// Backend, name and driver of the adapter.
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
    // Some software renderers report an unknown device type.
    let hardware = [DeviceType::DiscreteGpu, DeviceType::IntegratedGpu, DeviceType::VirtualGpu];
    let software = !hardware.contains(&adapter.get_info().device_type);
    (choice == DeviceChoice::Auto && software).then_some("is a software renderer")
}

/// Preference by device type; higher is better.
fn rank(info: &AdapterInfo) -> u32 {
    match info.device_type {
        DeviceType::DiscreteGpu => 4,
        DeviceType::IntegratedGpu => 3,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 1,
        DeviceType::Cpu => 0,
    }
}
