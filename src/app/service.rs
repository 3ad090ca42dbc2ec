//! The server: the HTTP interface and a worker on one data directory, until the operator stops it.

use std::net::SocketAddr;
use std::path::Path;
use std::sync::OnceLock;

use metrics_exporter_prometheus::{PrometheusBuilder, PrometheusHandle};
use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

use super::AppError;
use crate::api;
use crate::api::Api;
use crate::config::Resolved;
use crate::worker::BuildScene;
use store::{Store, StoreError};

/// A running server. Dropping it does not stop it; [`Service::stop`] does.
pub struct Service {
    /// Where it listens.
    pub address: SocketAddr,
    pub store: Store,
    /// Cancelled = not ready any more, nothing new is begun.
    pub shutdown: CancellationToken,
    server: JoinHandle<()>,
    worker: JoinHandle<Result<(), StoreError>>,
}

/// Opens the data directory, listens, starts to work. When it returns, requests are answered.
pub async fn start(resolved: &Resolved, data_dir: &Path, build: BuildScene) -> Result<Service, AppError> {
    let config = &resolved.config;
    let address = config.server.listen.clone();
    let unusable = |source| AppError::Listen { address: address.clone(), source };
    let listener = TcpListener::bind(&address).await.map_err(unusable)?;
    let address = listener.local_addr().map_err(unusable)?;
    let store = super::open(data_dir, config).await?;
    let worker = super::worker(&store, config, build)?;

    let shutdown = CancellationToken::new();
    let validate = super::pipeline::validate(resolved);
    let understand = super::pipeline::understand(resolved);
    let fetch_image = super::fetching::fetch_image(&config.server);
    let (settings, store_of_api) = (config.server.clone(), store.clone());
    let api =
        Api::new(store_of_api, settings, validate, understand, fetch_image, recorder(), shutdown.clone());
    let (router, settings, stopped) = (api::router(api), config.server.clone(), shutdown.clone());
    let server = tokio::spawn(async move { api::serve::serve(listener, router, &settings, stopped).await });
    let worker = tokio::spawn(worker.run(shutdown.clone()));
    Ok(Service { address, store, shutdown, server, worker })
}

impl Service {
    /// Waits until `stop` is done (then drains) or a part of the server ends by itself (an error).
    pub async fn run_until(mut self, stop: impl Future<Output = ()>) -> Result<(), AppError> {
        tokio::select! {
            () = stop => self.stop().await,
            ended = &mut self.worker => {
                let reason = match ended {
                    Ok(Ok(())) => "without a reason".to_owned(),
                    Ok(Err(error)) => error.chain(),
                    Err(died) => died.to_string(),
                };
                self.shutdown.cancel();
                // What is being answered may finish; nothing else is left to save.
                let _ = self.server.await;
                Err(AppError::WorkerEnded { reason })
            }
        }
    }

    /// Stops in good order: not ready, running stages finish and commit, jobs are given back, requests
    /// that are being answered are answered.
    pub async fn stop(self) -> Result<(), AppError> {
        self.shutdown.cancel();
        let (server, worker) = tokio::join!(self.server, self.worker);
        if let Err(died) = server {
            tracing::error!(%died, "the listener died");
        }
        match worker {
            Ok(result) => Ok(result?),
            Err(died) => Err(AppError::WorkerEnded { reason: died.to_string() }),
        }
    }
}

/// The recorder of metrics, of which a process has one.
fn recorder() -> PrometheusHandle {
    static RECORDER: OnceLock<PrometheusHandle> = OnceLock::new();
    let handle = RECORDER.get_or_init(|| {
        let recorder = PrometheusBuilder::new().build_recorder();
        let handle = recorder.handle();
        // A recorder that is installed already stays; `/metrics` is then empty.
        let _ = metrics::set_global_recorder(recorder);
        handle
    });
    handle.clone()
}
