//! An opened GPU: one for the process, shared by everything that computes on it.

use std::any::{Any, TypeId};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use wgpu::{
    Backends, Device, DeviceDescriptor, ErrorFilter, Instance, InstanceDescriptor, InstanceFlags, Limits,
    MemoryHints, Queue,
};

use super::{DeviceChoice, GpuError, adapters, nodes};

/// A device, what it has compiled, and what went wrong with it.
#[derive(Debug)]
pub struct Gpu {
    name: String,
    pub device: Device,
    pub queue: Queue,
    /// By their type and the number they were compiled for.
    kernels: Mutex<BTreeMap<(TypeId, usize), Arc<dyn Any + Send + Sync>>>,
    /// One caller at a time: OpenGL's one context may be waited for only so long, then `wgpu` panics.
    turn: Mutex<()>,
    /// The first thing that went wrong outside of any error scope.
    trouble: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// Opens the best adapter; `None` where the choice is the CPU. For `auto`, drivers are loaded only where the system
    /// has a device node for them: software renderers alone take a quarter of a second to load, to be refused.
    pub fn open(choice: DeviceChoice) -> Result<Option<Arc<Self>>, GpuError> {
        if choice == DeviceChoice::Auto && !nodes::may_have_hardware() {
            return Err(GpuError::NoAdapter {
                looked_at: "there is no graphics device in /dev, so no driver was asked".into(),
            });
        }
        // OpenGL's libraries are loaded only where there is nothing better, software comes last.
        let hardware = [(Backends::PRIMARY, DeviceChoice::Auto), (Backends::GL, DeviceChoice::Auto)];
        let any = [(Backends::PRIMARY, DeviceChoice::Gpu), (Backends::GL, DeviceChoice::Gpu)];
        let tries = match choice {
            DeviceChoice::Cpu => return Ok(None),
            DeviceChoice::Auto => hardware.to_vec(),
            DeviceChoice::Gpu => [hardware, any].concat(),
        };
        let mut failure = GpuError::NoAdapter { looked_at: "there is no backend".into() };
        for (backends, choice) in tries {
            match Self::open_among(backends, choice) {
                Ok(gpu) => return Ok(Some(gpu)),
                // That nothing is there tells less than why what is there was not taken.
                Err(error) if adapters::told_more(&failure, &error) => failure = error,
                Err(_) => {}
            }
        }
        Err(failure)
    }

    /// The same among the adapters of some backends only.
    pub fn open_among(backends: Backends, choice: DeviceChoice) -> Result<Arc<Self>, GpuError> {
        // Validation layers of debug builds are for those who debug drivers; `wgpu` validates by itself.
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
        let trouble = Arc::new(Mutex::new(None));
        let (uncaptured, lost) = (trouble.clone(), trouble.clone());
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| note(&uncaptured, error.to_string())));
        device.set_device_lost_callback(move |reason, told| {
            note(&lost, format!("the device was lost ({reason:?}): {told}"));
        });
        let (kernels, turn) = (Mutex::default(), Mutex::default());
        Ok(Arc::new(Self { name, device, queue, kernels, turn, trouble }))
    }

    /// Backend, adapter and driver: what results depend on.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// From now on every call fails.
    pub fn give_up(&self, reason: &str) {
        note(&self.trouble, reason.to_owned());
    }

    /// What went wrong for good, if anything did; from then on every call fails.
    pub fn given_up(&self) -> Option<String> {
        lock(&self.trouble).clone()
    }

    /// Runs what talks to the device, alone, and gathers every error it causes; an error gives the device up.
    pub fn guarded<T>(
        &self,
        attempted: &'static str,
        work: impl FnOnce() -> Result<T, String>,
    ) -> Result<T, GpuError> {
        let failed = |reason| GpuError::Failed { attempted, adapter: self.name.clone(), reason };
        let _turn = lock(&self.turn);
        if let Some(reason) = self.given_up() {
            return Err(failed(reason));
        }
        let filters = [ErrorFilter::Validation, ErrorFilter::OutOfMemory, ErrorFilter::Internal];
        let scopes = filters.map(|filter| self.device.push_error_scope(filter));
        let result = work();
        // The last opened is closed first. What `wgpu` says is nearer to the cause than what came of it.
        let captured = scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop()));
        let captured = captured.map(|error| error.to_string()).last();
        let reason = captured.or_else(|| self.given_up()).or_else(|| result.as_ref().err().cloned());
        match (reason, result) {
            (None, Ok(done)) => Ok(done),
            (reason, _) => {
                let reason = reason.unwrap_or_default();
                note(&self.trouble, reason.clone());
                Err(failed(reason))
            }
        }
    }

    /// Kernels of that type, compiled for that number at the first call.
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

    /// Most bytes of one storage buffer.
    pub fn largest_buffer_bytes(&self) -> usize {
        let limits = self.device.limits();
        let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        usize::try_from(bytes).unwrap_or(usize::MAX)
    }
}

/// What OpenGL ES 3.1 promises, but buffers as large as the adapter has them: textures of a scene may take more.
fn with_large_buffers(of_adapter: &Limits) -> Limits {
    Limits {
        max_storage_buffer_binding_size: of_adapter.max_storage_buffer_binding_size,
        max_buffer_size: of_adapter.max_buffer_size,
        ..Limits::downlevel_defaults()
    }
}

/// Keeps the first thing that went wrong.
fn note(trouble: &Mutex<Option<String>>, reason: String) {
    lock(trouble).get_or_insert(reason);
}

/// Nothing under these locks is left half done by a panic.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
