//! The stand-in for all remote models, on an address of its own.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

use super::AppError;
use crate::api;
use crate::config::{ConfigErrors, Resolved};
use crate::dev_providers::studio::Studio;
use crate::dev_providers::{DevProviders, router};
use crate::geometry::Interrupt;
use crate::provider::{Call, embedded};

/// A running server. Dropping it does not stop it; [`Running::stop`] does.
pub struct Running {
    pub address: SocketAddr,
    pub providers: Arc<DevProviders>,
    stopped: CancellationToken,
    server: JoinHandle<()>,
}

/// The protocols over the embedded ports of this configuration.
pub fn providers(resolved: &Resolved, seed: u64, latency: Duration) -> Result<Arc<DevProviders>, StartError> {
    let settings = super::scenes::adapters(&resolved.config);
    let ports = embedded::ports(&settings, super::network::load(resolved)?);
    let cpu = super::evaluation::cpu(&resolved.config)?;
    let turning = (resolved.config.canonicalize.clone(), resolved.config.dro.clone());
    let studio = Studio::new(ports, turning, Call::without_budget(cpu, Interrupt::default()), seed);
    Ok(DevProviders::new(studio, latency))
}

/// Listens; when it returns, requests are answered.
pub async fn start(
    resolved: &Resolved,
    listen: &str,
    providers: Arc<DevProviders>,
) -> Result<Running, AppError> {
    let unusable = |source| AppError::Listen { address: listen.to_owned(), source };
    let listener = TcpListener::bind(listen).await.map_err(unusable)?;
    let address = listener.local_addr().map_err(unusable)?;
    let stopped = CancellationToken::new();
    let (routes, settings, stopping) =
        (router(providers.clone()), resolved.config.server.clone(), stopped.clone());
    let server = tokio::spawn(async move { api::serve::serve(listener, routes, &settings, stopping).await });
    Ok(Running { address, providers, stopped, server })
}

/// Why the protocols cannot be answered.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    #[error(transparent)]
    Config(#[from] ConfigErrors),
    #[error(transparent)]
    App(#[from] AppError),
}

impl Running {
    /// What is being answered is answered; then the address is free.
    pub async fn stop(self) {
        self.stopped.cancel();
        if let Err(died) = self.server.await {
            tracing::error!(%died, "the listener died");
        }
    }
}
