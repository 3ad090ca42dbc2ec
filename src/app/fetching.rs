//! Images that requests name by their address, through the one client for everything outbound. A client's addresses
//! are not a provider's: they have rules of their own, and keys never go along.

use std::sync::OnceLock;
use std::time::Duration;

use bytes::Bytes;

use http_client::{AddressError, AddressPolicy, HttpClient, HttpRequest, SendError};

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
    /// For the client to read.
    pub async fn fetch(&self, url: String, max_bytes: usize) -> Result<Bytes, String> {
        let client = || HttpClient::new(self.policy.clone(), self.timeout).ok();
        let Some(client) = self.client.get_or_init(client) else {
            return Err("this server cannot fetch images; send the bytes as `base64`".to_owned());
        };
        let outgoing = HttpRequest::get(url);
        let reply = match tokio::time::timeout(self.timeout, client.send(&outgoing, max_bytes)).await {
            Ok(Ok(reply)) => reply,
            Ok(Err(error @ SendError::Address(AddressError::NotHttps(_)))) => {
                let advice = "use https, or let the operator name the host in server.fetch_hosts";
                return Err(format!("cannot be fetched: {error}; {advice}"));
            }
            Ok(Err(error)) => return Err(format!("cannot be fetched: {error}")),
            Err(_) => return Err(format!("did not come within {} s", self.timeout.as_secs())),
        };
        match reply.status {
            200 => Ok(reply.body),
            status => Err(format!("was answered with status {status} in place of an image")),
        }
    }
}
