//! Images that requests name by their address, through the one client for everything outbound. A client's addresses
//! are not a provider's: they have rules of their own, and keys never go along.

use std::sync::{Arc, OnceLock};
use std::time::Duration;

use futures::FutureExt;

use crate::api;
use crate::api::FetchImage;
use http_client::{AddressError, AddressPolicy, HttpClient, HttpRequest, SendError};

/// The client is made for the first image: a server that fetches none needs no certificates.
pub fn fetch_image(settings: &api::Settings) -> FetchImage {
    let timeout = Duration::from_secs(settings.fetch_timeout_secs);
    // Each address is checked by itself, at every redirect: an exception holds for its host and port alone.
    let policy = AddressPolicy::with_exceptions(&settings.fetch_hosts);
    let client: Arc<OnceLock<Option<HttpClient>>> = Arc::default();
    Arc::new(move |url, max_bytes| {
        let (policy, client) = (policy.clone(), client.clone());
        async move {
            let Some(client) = client.get_or_init(|| HttpClient::new(policy, timeout).ok()) else {
                return Err("this server cannot fetch images; send the bytes as `base64`".to_owned());
            };
            let outgoing = HttpRequest::get(url);
            let reply = match tokio::time::timeout(timeout, client.send(&outgoing, max_bytes)).await {
                Ok(Ok(reply)) => reply,
                Ok(Err(error @ SendError::Address(AddressError::NotHttps(_)))) => {
                    let advice = "use https, or let the operator name the host in server.fetch_hosts";
                    return Err(format!("cannot be fetched: {error}; {advice}"));
                }
                Ok(Err(error)) => return Err(format!("cannot be fetched: {error}")),
                Err(_) => return Err(format!("did not come within {} s", timeout.as_secs())),
            };
            match reply.status {
                200 => Ok(reply.body),
                status => Err(format!("was answered with status {status} in place of an image")),
            }
        }
        .boxed()
    })
}
