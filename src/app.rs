//! The wiring: configuration in, running parts out. Nothing else knows which adapter answers which port.
//!
//! Three programs are made of the same parts: the server and a worker without the HTTP interface
//! ([`service`]), and a worker for one job inside the calling process ([`local`]). All open a store, build
//! scenes through the worker, and refuse the same requests.

pub mod logging;
pub mod metrics;
pub mod telemetry;
pub mod features;
pub mod network;
pub mod remote;
mod fetching;
mod listening;
pub mod pipeline;
pub mod activity;
mod grasps;
pub mod tasks;
pub mod episodes;
pub mod executions;
pub mod role;
mod process;
mod upkeep;
mod feeding;
mod recording;
pub mod service;
pub mod local;

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// The configuration, re-exported for the command line.
pub use crate::config;

use crate::config::Config;
use crate::pipeline::checkpoint::StageRuntime;
use crate::worker::{BuildScene, SceneBuilder, Worker};
use runtime::CpuPool;
use store::queue::control::QueueControl;
use store::{Intent, Store, StoreError};

/// Reason why the program could not start or go on.
#[derive(Debug, thiserror::Error)]
pub enum AppError {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error("cannot listen on {address}; choose another with --listen (port 0 takes a free one)")]
    Listen { address: String, source: std::io::Error },
    #[error(
        "refusing to listen on {address}: clients are not authenticated, so everyone who reaches this address could submit, \
         read and delete scenes; listen on a loopback address such as 127.0.0.1:8080, or let a reverse proxy \
         authenticate clients and give --allow-unauthenticated (server.allow_unauthenticated = true)"
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

/// The operator's connection to the queue, beside running processes.
pub async fn queue_control(data_dir: &Path, config: &Config) -> Result<QueueControl, AppError> {
    Ok(QueueControl::open(data_dir, &config.store).await?)
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
