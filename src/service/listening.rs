//! The listening socket. Without authentication it is bound to loopback alone, unless the operator says otherwise.
//! Lines of the log say who may use the server.

use tokio::net::{TcpListener, lookup_host};

use crate::api::Settings;
use crate::api::authentication::Mode;
use crate::app::AppError;
use store::Store;

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
    let address = &settings.listen;
    match settings.authentication.mode {
        Mode::None if is_open && !settings.allow_unauthenticated => {
            return Err(AppError::OpenToOthers { address: address.clone() });
        }
        Mode::None if is_open => {
            tracing::warn!(address, "clients are not authenticated, and other machines can connect");
        }
        Mode::None => tracing::info!(
            address,
            "clients are not authenticated: everyone on this machine may do everything (server.authentication.mode)"
        ),
        Mode::Keys if is_open && !settings.public_url.starts_with("https://") => tracing::warn!(
            address,
            "keys can be read on the way to this server unless a proxy in front of it speaks https; name its address in \
             server.public_url"
        ),
        Mode::Keys => tracing::info!(address, "clients need a key"),
    }
    TcpListener::bind(&addresses[..]).await.map_err(unusable)
}

/// Says how to make the first key, where clients need one and there is none.
pub async fn advise_on_keys(settings: &Settings, store: &Store) -> Result<(), AppError> {
    if settings.authentication.mode == Mode::Keys && !store.has_keys().await? {
        tracing::warn!(
            "clients need a key, and there is none yet: make one with `tabletopgen keys create --name NAME --scopes \
             read,submit,delete,operate,admin` on this data directory"
        );
    }
    Ok(())
}
