//! Use cases: an order in, a value or a [`Problem`](crate::problem::Problem) out, one file each. The interface and the
//! command line only translate, so both refuse the same requests. Beside them the wiring: configuration in, running
//! parts out; nothing else knows which adapter answers which port.

pub mod logging;
pub mod metrics;
pub mod telemetry;
pub mod features;
pub mod network;
pub mod remote;
pub mod fetching;
pub mod pipeline;
pub mod activity;
pub mod terms;
pub mod submission;
pub mod scene_labels;
pub mod webhooks;
mod request_settings;
pub mod image;
mod json_detail;
pub mod json_error;
mod edit_operations;
pub mod edit_scene;
pub mod instructions;
pub mod variants;
pub mod batch_requests;
pub mod batch_reading;
mod grasps;
pub mod tasks;
pub mod catalog;
pub mod added_categories;
pub mod catalog_check;
pub mod robot_model;
pub mod episodes;
pub mod executions;
pub mod local;

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// The configuration, re-exported for the command line.
pub use crate::config;

use crate::config::{Config, Resolved};
use crate::pipeline::checkpoint::StageRuntime;
use crate::worker::{BuildScene, SceneBuilder, Worker};
use embedded::instruction_reader::EnglishReader;
use instructions::Reader;
use remote::Remote;
use runtime::CpuPool;
use store::{Intent, Operator, Store, StoreError};

/// The use cases of a process, each a method in the file of its subject; cloning shares them.
#[derive(Clone, Debug)]
pub struct App {
    resolved: Arc<Resolved>,
    reader: Reader,
}

impl App {
    /// With the embedded reader of instructions.
    pub fn new(resolved: &Resolved) -> Self {
        let reader = Reader { reader: Arc::new(EnglishReader), is_remote: false };
        Self { resolved: Arc::new(resolved.clone()), reader }
    }

    /// With the configured reader of instructions.
    pub fn reading_with(resolved: &Resolved, remote: &Remote) -> Self {
        let app = Self::new(resolved);
        match remote.reader() {
            Some(reader) => Self { reader: Reader { reader, is_remote: true }, ..app },
            None => app,
        }
    }

    pub fn config(&self) -> &Config {
        &self.resolved.config
    }

    fn resolved(&self) -> &Resolved {
        &self.resolved
    }
}

/// Reason why the program could not start or go on.
#[derive(Debug, thiserror::Error)]
pub enum AppError {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error("cannot listen on {address}; choose another with --listen (port 0 takes a free one)")]
    Listen { address: String, source: std::io::Error },
    #[error(
        "refusing to listen on {address}: clients are not authenticated, so everyone who reaches this address could submit, \
         read and delete scenes; set server.authentication.mode = keys and make a key with `tabletopgen keys create`, listen on \
         a loopback address such as 127.0.0.1:8080, or let a reverse proxy authenticate clients and give \
         --allow-unauthenticated (server.allow_unauthenticated = true)"
    )]
    OpenToOthers { address: String },
    #[error("cannot start the CPU pool of {threads} threads; set worker.cpu_threads to fewer")]
    CpuPool { threads: usize, source: rayon::ThreadPoolBuildError },
    #[error("the worker ended without a request to stop: {reason}")]
    WorkerEnded { reason: String },
}

impl AppError {
    /// Message and causes on one line.
    pub fn chain(&self) -> String {
        runtime::error_chain(self)
    }
}

/// Opens the store of a data directory, or of the settings.
pub async fn open(data_dir: &Path, config: &Config, intent: Intent) -> Result<Store, AppError> {
    Ok(Store::open(data_dir, &config.store, intent).await?)
}

/// The operator's connection, beside running processes.
pub async fn operator(data_dir: &Path, config: &Config) -> Result<Operator, AppError> {
    Ok(Operator::open(data_dir, &config.store).await?)
}

/// The pool that a process computes on.
pub fn cpu_pool(config: &Config) -> Result<CpuPool, AppError> {
    let threads = config.worker.cpu_threads;
    CpuPool::new(threads).map_err(|source| AppError::CpuPool { threads, source })
}

/// A worker on the store that builds scenes.
pub fn worker(store: &Store, config: &Config, cpu: &CpuPool, build: BuildScene) -> Worker {
    let stage_timeout = Duration::from_secs(config.worker.stage_timeout_secs);
    let runtime =
        StageRuntime::new(store.clone(), cpu.clone(), BACKEND, config.worker.fan_out, stage_timeout);
    let scenes = SceneBuilder { runtime, build };
    Worker::new(store.clone(), config.worker.clone()).with(Arc::new(scenes))
}

/// Hardware that results depend on besides inputs and settings, as part of every checkpoint's key: floating point
/// differs between architectures in the last bit, and nothing else here differs between machines. A GPU differs too;
/// the stages that use one have its name among their inputs.
pub const BACKEND: &str = if cfg!(target_arch = "x86_64") {
    "cpu-x86_64"
} else if cfg!(target_arch = "aarch64") {
    "cpu-aarch64"
} else {
    "cpu-other"
};
