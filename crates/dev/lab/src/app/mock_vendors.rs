//! The mock server of all remote models, on its own address.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

use crate::mock_vendors::image_sessions::ImageSessions;
use crate::mock_vendors::{MockVendors, router};
use ports::Call;
use runtime::CancelFlag;
use tabletopgen::api;
use tabletopgen::app::AppError;
use tabletopgen::config::{ConfigErrors, Resolved};

/// A running server. Dropping it does not stop it; [`Running::stop`] does.
pub struct Running {
    pub address: SocketAddr,
    pub providers: Arc<MockVendors>,
    stopped: CancellationToken,
    server: JoinHandle<()>,
}

/// The mock vendors over the embedded ports of this configuration.
pub fn providers(resolved: &Resolved, seed: u64, latency: Duration) -> Result<Arc<MockVendors>, StartError> {
    let settings = tabletopgen::app::pipeline::adapters(&resolved.config);
    let ports = embedded::ports(&settings, tabletopgen::app::network::load(resolved)?);
    let cpu = super::evaluation::cpu(&resolved.config)?;
    let upright_settings = (resolved.config.canonicalize.clone(), resolved.config.dro.clone());
    let sessions =
        ImageSessions::new(ports, upright_settings, Call::without_budget(cpu, CancelFlag::default()), seed);
    Ok(MockVendors::new(sessions, latency))
}

/// Starts listening; requests are answered once it returns.
pub async fn start(
    resolved: &Resolved,
    listen: &str,
    providers: Arc<MockVendors>,
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

/// Reason of a failed start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    #[error(transparent)]
    Config(#[from] ConfigErrors),
    #[error(transparent)]
    App(#[from] AppError),
}

impl Running {
    /// Finishes the open requests and frees the address.
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
