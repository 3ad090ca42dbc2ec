//! An opened GPU with its compiled kernels, shared by all computations of the process.

use std::any::{Any, TypeId};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use wgpu::{
    Backends, Device, DeviceDescriptor, ErrorFilter, Instance, InstanceDescriptor, InstanceFlags, Limits,
    MemoryHints, Queue,
};

use super::transfer::TransferError;
use super::{DeviceChoice, GpuError, adapters, nodes};

/// A device with its compiled kernels and its first fatal error.
#[derive(Debug)]
pub struct Gpu {
    name: String,
    pub device: Device,
    pub queue: Queue,
    /// Compiled kernels by type and specialization number.
    kernels: Mutex<BTreeMap<(TypeId, usize), Arc<dyn Any + Send + Sync>>>,
    /// Serializes callers: `wgpu` panics after a bounded wait for OpenGL's single context.
    exclusive: Mutex<()>,
    /// The first error outside of any error scope.
    fatal_error: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// Opens the best adapter; `None` if the choice is the CPU. For `Auto`, drivers are loaded only if the system has a
    /// device node for them, because loading software renderers alone takes a quarter of a second.
    ///
    /// # Errors
    ///
    /// [`GpuError::NoAdapter`] or [`GpuError::NotOpened`]: the most informative failure of all backends.
    pub fn open(choice: DeviceChoice) -> Result<Option<Arc<Self>>, GpuError> {
        if choice == DeviceChoice::Auto && !nodes::may_have_hardware() {
            return Err(GpuError::NoAdapter {
                rejected: "there is no graphics device in /dev, so no driver was asked".into(),
            });
        }
        // OpenGL's libraries are loaded only if no primary backend has an adapter; software renderers come last.
        let hardware = [(Backends::PRIMARY, DeviceChoice::Auto), (Backends::GL, DeviceChoice::Auto)];
        let any = [(Backends::PRIMARY, DeviceChoice::Gpu), (Backends::GL, DeviceChoice::Gpu)];
        let tries = match choice {
            DeviceChoice::Cpu => return Ok(None),
            DeviceChoice::Auto => hardware.to_vec(),
            DeviceChoice::Gpu => [hardware, any].concat(),
        };
        let mut failure = GpuError::NoAdapter { rejected: "there is no backend".into() };
        for (backends, choice) in tries {
            match Self::open_among(backends, choice) {
                Ok(gpu) => return Ok(Some(gpu)),
                // The reason why an adapter was rejected is more informative than the absence of adapters.
                Err(error) if adapters::is_more_informative(&failure, &error) => failure = error,
                Err(_) => {}
            }
        }
        Err(failure)
    }

    /// As [`Self::open`], among the adapters of some backends.
    pub fn open_among(backends: Backends, choice: DeviceChoice) -> Result<Arc<Self>, GpuError> {
        // `wgpu` validates by itself; the validation layers of debug builds serve to debug drivers.
        let flags = InstanceFlags::empty();
        let descriptor =
            InstanceDescriptor { backends, flags, ..InstanceDescriptor::new_without_display_handle() };
        Self::open_of(&Instance::new(descriptor), backends, choice)
    }

    fn open_of(instance: &Instance, backends: Backends, choice: DeviceChoice) -> Result<Arc<Self>, GpuError> {
        let adapter = adapters::best(instance, backends, choice)?;
        let name = adapters::described(&adapter.get_info());
        let descriptor = DeviceDescriptor {
            label: Some("tabletopgen"),
            required_limits: with_large_buffers(&adapter.limits()),
            memory_hints: MemoryHints::Performance,
            ..DeviceDescriptor::default()
        };
        let opened = pollster::block_on(adapter.request_device(&descriptor));
        let (device, queue) = opened
            .map_err(|error| GpuError::NotOpened { adapter: name.clone(), reason: error.to_string() })?;
        let fatal_error = Arc::new(Mutex::new(None));
        let (uncaptured, lost) = (fatal_error.clone(), fatal_error.clone());
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| note(&uncaptured, error.to_string())));
        device.set_device_lost_callback(move |reason, message| {
            note(&lost, format!("the device was lost ({reason:?}): {message}"));
        });
        let (kernels, exclusive) = (Mutex::default(), Mutex::default());
        Ok(Arc::new(Self { name, device, queue, kernels, exclusive, fatal_error }))
    }

    /// Backend, adapter and driver, which results depend on.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Makes every later call fail with this reason.
    pub fn give_up(&self, reason: &str) {
        note(&self.fatal_error, reason.to_owned());
    }

    /// The first fatal error, if any. After it every call fails.
    pub fn given_up(&self) -> Option<String> {
        lock(&self.fatal_error).clone()
    }

    /// Runs device work exclusively and collects every error it causes. An error gives the device up.
    ///
    /// # Errors
    ///
    /// [`GpuError::Failed`] if the work or the device fails, or the device was given up before.
    pub fn guarded<T>(
        &self,
        attempted: &'static str,
        work: impl FnOnce() -> Result<T, TransferError>,
    ) -> Result<T, GpuError> {
        let failed = |reason| GpuError::Failed { attempted, adapter: self.name.clone(), reason };
        let _guard = lock(&self.exclusive);
        if let Some(reason) = self.given_up() {
            return Err(failed(reason));
        }
        let filters = [ErrorFilter::Validation, ErrorFilter::OutOfMemory, ErrorFilter::Internal];
        let scopes = filters.map(|filter| self.device.push_error_scope(filter));
        let result = work();
        // Scopes close in reverse order. Errors that `wgpu` captured are closer to the cause than the error of `work`.
        let captured = scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop()));
        let captured = captured.map(|error| error.to_string()).last();
        let reason =
            captured.or_else(|| self.given_up()).or_else(|| result.as_ref().err().map(ToString::to_string));
        match (reason, result) {
            (None, Ok(done)) => Ok(done),
            (reason, _) => {
                let reason = reason.unwrap_or_default();
                note(&self.fatal_error, reason.clone());
                Err(failed(reason))
            }
        }
    }

    /// The kernels of type `K` specialized for `number`, compiled at the first call.
    pub fn kernels<K: Any + Send + Sync>(
        &self,
        number: usize,
        compile: impl FnOnce(&Device) -> K,
    ) -> Result<Arc<K>, GpuError> {
        let mut all = lock(&self.kernels);
        let key = (TypeId::of::<K>(), number);
        if let Some(kernels) = all.get(&key).and_then(|kernels| kernels.clone().downcast().ok()) {
            return Ok(kernels);
        }
        let kernels = self.guarded("compiling kernels", || Ok(Arc::new(compile(&self.device))))?;
        all.insert(key, kernels.clone());
        Ok(kernels)
    }

    /// Maximum size of one storage buffer, bytes.
    pub fn max_buffer_bytes(&self) -> usize {
        let limits = self.device.limits();
        let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        usize::try_from(bytes).unwrap_or(usize::MAX)
    }
}

/// The limits of OpenGL ES 3.1, but the buffer sizes of the adapter, because textures of a scene may be larger.
fn with_large_buffers(of_adapter: &Limits) -> Limits {
    Limits {
        max_storage_buffer_binding_size: of_adapter.max_storage_buffer_binding_size,
        max_buffer_size: of_adapter.max_buffer_size,
        ..Limits::downlevel_defaults()
    }
}

/// Records the first error.
fn note(fatal_error: &Mutex<Option<String>>, reason: String) {
    lock(fatal_error).get_or_insert(reason);
}

/// Locks, ignoring poisoning: a panic cannot leave the guarded values inconsistent.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
