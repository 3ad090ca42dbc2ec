//! Images that requests name by their address, through the one client for everything outbound. A client's addresses
//! are not a provider's: they have rules of their own, and keys never go along.

use std::sync::{Arc, OnceLock};
use std::time::Duration;

use futures::FutureExt;

use crate::api;
use crate::api::FetchImage;
use http_client::{AddressPolicy, HttpClient, HttpRequest};

/// The client is made for the first image: a server that fetches none needs no certificates.
pub fn fetch_image(settings: &api::Settings) -> FetchImage {
    let timeout = Duration::from_secs(settings.fetch_timeout_secs);
    // Plain HTTP is for hosts that are named; any other address has to be https.
    let named = AddressPolicy::new(true, &settings.fetch_hosts);
    let strict = AddressPolicy::new(false, "");
    let hosts = settings.fetch_hosts.clone();
    let clients: Arc<OnceLock<Option<(HttpClient, HttpClient)>>> = Arc::default();
    Arc::new(move |url, max_bytes| {
        let (named, strict, hosts, clients) = (named.clone(), strict.clone(), hosts.clone(), clients.clone());
        async move {
            let made = clients.get_or_init(|| {
                let client = |rules| HttpClient::new(rules, timeout).ok();
                Some((client(named)?, client(strict)?))
            });
            let Some((named, strict)) = made else {
                return Err("this server cannot fetch images; send the bytes as `base64`".to_owned());
            };
            let is_allowed_plain = is_named(&url, &hosts);
            let is_plain = !is_allowed_plain && url.to_ascii_lowercase().starts_with("http://");
            let client = if is_allowed_plain { named } else { strict };
            let outgoing = HttpRequest::get(url);
            let reply = match tokio::time::timeout(timeout, client.send(&outgoing, max_bytes)).await {
                Ok(Ok(reply)) => reply,
                Ok(Err(error)) if is_plain => {
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

/// Whether the operator names the URL's host, with its port or for every port.
fn is_named(url: &str, hosts: &str) -> bool {
    let authority =
        url.split_once("://").map_or("", |(_, rest)| rest.split(['/', '?', '#']).next().unwrap_or(""));
    let authority = authority.to_ascii_lowercase();
    let host = authority.rsplit_once(':').map_or(authority.as_str(), |(host, _)| host);
    hosts.split_whitespace().map(str::to_ascii_lowercase).any(|entry| entry == authority || entry == host)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts_are_named_whole() {
        let hosts = "Pictures.internal 127.0.0.1:8090";
        for (url, named) in [
            ("http://pictures.internal/a.png", true),
            ("http://PICTURES.internal:81/a.png", true),
            ("http://127.0.0.1:8090/a.png?b#c", true),
            ("http://127.0.0.1:8091/a.png", false),
            ("http://127.0.0.1/a.png", false),
            ("http://pictures.internal.example.org/a.png", false),
            ("http://a@pictures.internal/a.png", false),
            ("http://example.org/http://pictures.internal/", false),
            ("pictures.internal", false),
        ] {
            assert_eq!(is_named(url, hosts), named, "{url}");
        }
    }
}
