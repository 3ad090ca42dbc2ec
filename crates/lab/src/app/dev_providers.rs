//! The stand-in for all remote models, on an address of its own.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

use crate::dev_providers::studio::Studio;
use crate::dev_providers::{DevProviders, router};
use embedded;
use ports::Call;
use runtime::Interrupt;
use tabletopgen::api;
use tabletopgen::app::AppError;
use tabletopgen::config::{ConfigErrors, Resolved};

/// A running server. Dropping it does not stop it; [`Running::stop`] does.
pub struct Running {
    pub address: SocketAddr,
    pub providers: Arc<DevProviders>,
    stopped: CancellationToken,
    server: JoinHandle<()>,
}

/// The protocols over the embedded ports of this configuration.
pub fn providers(resolved: &Resolved, seed: u64, latency: Duration) -> Result<Arc<DevProviders>, StartError> {
    let settings = tabletopgen::app::scenes::adapters(&resolved.config);
    let ports = embedded::ports(&settings, tabletopgen::app::network::load(resolved)?);
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

impl From<StartError> for tabletopgen::cli::Failure {
    fn from(error: StartError) -> Self {
        match error {
            StartError::Config(errors) => errors.into(),
            StartError::App(error) => error.into(),
        }
    }
}
