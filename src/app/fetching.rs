//! Images that requests name by their address, through the one client for everything outbound. A client's addresses
//! are not a provider's: they have rules of their own, and keys never go along.

use std::sync::OnceLock;
use std::time::Duration;

use bytes::Bytes;

use http_client::{AddressError, AddressPolicy, HttpClient, HttpRequest, SendError};

/// Reason why an image could not be fetched; the client reads it.
#[derive(Debug, thiserror::Error)]
pub enum FetchError {
    #[error("this server cannot fetch images; send the bytes as `base64`")]
    NoClient,
    #[error("cannot be fetched: {0}{advice}", advice = advice(.0))]
    Unreachable(#[source] SendError),
    #[error("did not come within {timeout_secs} s")]
    TooSlow { timeout_secs: u64 },
    #[error("was answered with status {status} in place of an image")]
    OtherStatus { status: u16 },
}

fn advice(error: &SendError) -> &'static str {
    match error {
        SendError::Address(AddressError::NotHttps(_)) => {
            "; use https, or let the operator name the host in server.fetch_hosts"
        }
        _ => "",
    }
}

/// Fetches images from addresses that clients give.
pub struct ImageFetcher {
    policy: AddressPolicy,
    timeout: Duration,
    /// Made for the first image: a server that fetches none needs no certificates.
    client: OnceLock<Option<HttpClient>>,
}

impl ImageFetcher {
    /// A fetcher that waits for `timeout` at most. `hosts` may be asked by plain HTTP and at private addresses.
    pub fn new(timeout: Duration, hosts: &str) -> Self {
        // Each address is checked by itself, at every redirect: an exception holds for its host and port alone.
        Self { policy: AddressPolicy::with_exceptions(hosts), timeout, client: OnceLock::new() }
    }

    /// The image at an address, of at most so many bytes.
    ///
    /// # Errors
    ///
    /// [`FetchError`] if the address does not answer with an image in time.
    pub async fn fetch(&self, url: String, max_bytes: usize) -> Result<Bytes, FetchError> {
        let client = || HttpClient::new(self.policy.clone(), self.timeout).ok();
        let Some(client) = self.client.get_or_init(client) else {
            return Err(FetchError::NoClient);
        };
        let outgoing = HttpRequest::get(url);
        let reply = tokio::time::timeout(self.timeout, client.send(&outgoing, max_bytes))
            .await
            .map_err(|_| FetchError::TooSlow { timeout_secs: self.timeout.as_secs() })?
            .map_err(FetchError::Unreachable)?;
        match reply.status {
            200 => Ok(reply.body),
            status => Err(FetchError::OtherStatus { status }),
        }
    }
}
