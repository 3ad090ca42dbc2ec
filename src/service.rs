//! The server: the HTTP interface, with or without a worker, until the operator stops it.

mod feeding;
mod listening;
mod process;
pub mod role;
mod upkeep;

use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use serde_json::Value;
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use crate::api;
use crate::api::Api;
use crate::app::{App, AppError, cpu_pool, metrics, open, worker as scene_worker};
use crate::executor::Executor;
use crate::freezer::Freezer;
use crate::recorder::Recorder;
use crate::webhooks;
use crate::worker::{BuildScene, Worker};
use runtime::CpuPool;
use store::{Intent, Store};

use process::Process;

/// A running server. Dropping it does not stop it; [`Service::stop`] does.
pub struct Service {
    /// Address on which it listens.
    pub address: SocketAddr,
    pub store: Store,
    /// Cancelled = not ready any more, nothing new is begun.
    pub shutdown: CancellationToken,
    process: Process,
}

/// A running worker without the HTTP interface.
pub struct WorkerService {
    /// Address on which it answers probes, if any.
    pub address: Option<SocketAddr>,
    pub store: Store,
    process: Process,
}

/// Opens the store, listens, starts to work. When it returns, requests are answered.
pub async fn start(app: &App, data_dir: &Path, build: BuildScene) -> Result<Service, AppError> {
    serve(app, data_dir, Some(build)).await
}

/// As [`start`], without a worker: jobs are left to other processes.
pub async fn start_api(app: &App, data_dir: &Path) -> Result<Service, AppError> {
    serve(app, data_dir, None).await
}

async fn serve(app: &App, data_dir: &Path, build: Option<BuildScene>) -> Result<Service, AppError> {
    let config = app.config();
    let listener = listening::bind(&config.server).await?;
    let address = address_of(&listener, &config.server.listen)?;
    let store = open(data_dir, config, Intent::Create).await?;
    listening::advise_on_keys(&config.server, &store).await?;
    let cpu = cpu_pool(config)?;
    let worker = build.map(|build| worker(app, data_dir, &store, &cpu, build));
    let (draining, closing) = (CancellationToken::new(), CancellationToken::new());
    if worker.is_some() {
        start_background(app, &store, &draining);
    }
    let api = interface(app, &config.server, &store, cpu, &draining, &closing);
    let (router, settings, closed) = (api::router(api), config.server.clone(), closing.clone());
    let listener = tokio::spawn(async move { api::serve::serve(listener, router, &settings, closed).await });
    let process = Process {
        draining: draining.clone(),
        closing,
        close_delay: Duration::from_secs(config.server.close_delay_secs),
        listener: Some(listener),
        worker: worker.map(|worker| tokio::spawn(worker.run(draining.clone()))),
    };
    Ok(Service { address, store, shutdown: draining, process })
}

/// Opens the store and starts to work; `listen` is the address for probes and metrics.
pub async fn start_worker(
    app: &App,
    data_dir: &Path,
    listen_on: Option<&str>,
    build: BuildScene,
) -> Result<WorkerService, AppError> {
    let config = app.config();
    let listener = match listen_on {
        // Probes and metrics are for everyone who can reach the address.
        Some(address) => Some(TcpListener::bind(address).await.map_err(unusable(address))?),
        None => None,
    };
    let address = listener.as_ref().map(|bound| address_of(bound, &config.worker.listen)).transpose()?;
    let store = open(data_dir, config, Intent::Create).await?;
    let cpu = cpu_pool(config)?;
    let worker = worker(app, data_dir, &store, &cpu, build);
    let (draining, closing) = (CancellationToken::new(), CancellationToken::new());
    start_background(app, &store, &draining);
    let listener = listener.map(|listener| {
        let settings = api::Settings {
            listen: listen_on.unwrap_or_default().to_owned(),
            allowed_hosts: "*".to_owned(),
            allowed_origins: String::new(),
            ..config.server.clone()
        };
        let router = api::probe_router(interface(app, &settings, &store, cpu, &draining, &closing));
        let closed = closing.clone();
        tokio::spawn(async move { api::serve::serve(listener, router, &settings, closed).await })
    });
    let process = Process {
        draining: draining.clone(),
        closing,
        close_delay: Duration::from_secs(config.server.close_delay_secs),
        listener,
        worker: Some(tokio::spawn(worker.run(draining))),
    };
    Ok(WorkerService { address, store, process })
}

impl Service {
    /// Waits until `stop` is done (then drains) or a part of the server ends by itself (an error).
    pub async fn run_until(self, stop: impl Future<Output = ()>) -> Result<(), AppError> {
        self.process.run_until(stop).await
    }

    /// Stops in good order: not ready, running stages finish and commit, jobs are given back, requests
    /// that are being answered are answered.
    pub async fn stop(self) -> Result<(), AppError> {
        self.process.stop().await
    }
}

impl WorkerService {
    /// Waits until `stop` is done (then drains) or the worker ends by itself (an error).
    pub async fn run_until(self, stop: impl Future<Output = ()>) -> Result<(), AppError> {
        self.process.run_until(stop).await
    }

    /// Stops in good order.
    pub async fn stop(self) -> Result<(), AppError> {
        self.process.stop().await
    }
}

/// The worker of a service, which carries out jobs of every kind.
fn worker(app: &App, data_dir: &Path, store: &Store, cpu: &CpuPool, build: BuildScene) -> Worker {
    let freezer = Freezer::new(store.clone(), cpu.clone(), data_dir);
    let (recording, executing) = (app.clone(), app.clone());
    let prepare = Arc::new(move |archive: &[u8], order: &Value| recording.prepare_recording(archive, order));
    let recorder = Recorder::new(store.clone(), cpu.clone(), data_dir, prepare, &app.config().worker);
    let execute = Arc::new(move |archive: &[u8], order: &Value| executing.execute_stored(archive, order));
    let executor = Executor::new(store.clone(), cpu.clone(), execute);
    scene_worker(store, app.config(), cpu, build)
        .with(Arc::new(freezer))
        .with(Arc::new(recorder))
        .with(Arc::new(executor))
}

/// Starts what a process with a worker does beside jobs.
fn start_background(app: &App, store: &Store, draining: &CancellationToken) {
    upkeep::start(store, app.config(), draining);
    feeding::start(store, app, draining);
    let poll = Duration::from_millis(app.config().worker.poll_ms);
    webhooks::start(store, &app.config().webhooks, poll, draining);
}

fn address_of(listener: &TcpListener, stated: &str) -> Result<SocketAddr, AppError> {
    listener.local_addr().map_err(unusable(stated))
}

fn unusable(address: &str) -> impl Fn(std::io::Error) -> AppError {
    move |source| AppError::Listen { address: address.to_owned(), source }
}

/// State that handlers share.
fn interface(
    app: &App,
    settings: &api::Settings,
    store: &Store,
    cpu: CpuPool,
    draining: &CancellationToken,
    closing: &CancellationToken,
) -> Api {
    let mut api =
        Api::new(store.clone(), app.clone(), cpu, settings.clone(), metrics::recorder(), closing.clone());
    api.draining = draining.clone();
    api
}
