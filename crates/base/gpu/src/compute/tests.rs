//! Fallback to the CPU: no GPU, and a GPU that failed.

use std::io::Write;
use std::sync::{Arc, Mutex};

use wgpu::Backends;

use super::*;
use crate::test_devices::devices;
use crate::transfer::TransferError;

/// Captured log lines.
#[derive(Clone, Default)]
struct Lines(Arc<Mutex<Vec<u8>>>);

impl Write for Lines {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().expect("no panic").write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn compute_without_gpu_logs_once_and_falls_back_to_the_cpu() {
    for (device, level) in [(DeviceChoice::Auto, "INFO"), (DeviceChoice::Gpu, "WARN")] {
        let lines = Lines::default();
        let written = lines.clone();
        let log = tracing_subscriber::fmt().with_writer(move || written.clone()).with_ansi(false).finish();
        let compute = Compute::new(&ComputeSettings { device });
        let nowhere = |choice| Gpu::open_among(Backends::empty(), choice).map(Some);
        tracing::subscriber::with_default(log, || {
            assert!(compute.gpu_or(nowhere).is_none() && compute.gpu_or(nowhere).is_none());
        });
        let message = String::from_utf8(lines.0.lock().expect("no panic").clone()).expect("text");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(
            message.contains(level) && message.contains("on the CPU") && message.contains("no adapter"),
            "{message}"
        );
        assert!(compute.opened().is_none());
    }
}

#[test]
fn compute_does_not_return_a_gpu_that_was_given_up() {
    for gpu in devices() {
        let compute = Compute::new(&ComputeSettings { device: DeviceChoice::Gpu });
        assert!(compute.gpu_or(|_| Ok(Some(gpu.clone()))).is_some());
        let caused = gpu.guarded("failing", || Err::<(), _>(TransferError::NoAnswer));
        assert!(caused.is_err_and(|error| error.to_string().contains("failing")));
        assert!(compute.gpu().is_none() && compute.opened().is_some());
    }
}
