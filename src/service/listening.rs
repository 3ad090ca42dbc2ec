//! The listening socket. Without authentication it is bound to loopback alone, unless the operator says otherwise.

use tokio::net::{TcpListener, lookup_host};

use crate::api::Settings;
use crate::app::AppError;

/// Binds `server.listen`.
///
/// # Errors
///
/// [`AppError::OpenToOthers`] for an address beyond loopback without `server.allow_unauthenticated`, and
/// [`AppError::Listen`] where the address cannot be bound.
pub async fn bind(settings: &Settings) -> Result<TcpListener, AppError> {
    let unusable = |source| AppError::Listen { address: settings.listen.clone(), source };
    let addresses: Vec<_> = lookup_host(&settings.listen).await.map_err(unusable)?.collect();
    let is_open = addresses.iter().any(|address| !address.ip().to_canonical().is_loopback());
    if is_open && !settings.allow_unauthenticated {
        return Err(AppError::OpenToOthers { address: settings.listen.clone() });
    }
    if is_open {
        tracing::warn!(
            address = settings.listen,
            "clients are not authenticated, and other machines can connect"
        );
    }
    TcpListener::bind(&addresses[..]).await.map_err(unusable)
}
