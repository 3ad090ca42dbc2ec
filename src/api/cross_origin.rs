//! Pages of other origins that the operator lets use this server, by the CORS protocol (Fetch standard, section 3.3).
//!
//! Such a page sends a key itself: cookies are not shared with it.

use std::time::Duration;

use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, header};
use tower_http::cors::CorsLayer;

/// Time for which a browser keeps the answer to a preflight request.
const PREFLIGHT_LIFETIME: Duration = Duration::from_secs(600);

/// The origins of the setting `server.allowed_origins`.
#[derive(Debug)]
pub(super) struct AllowedOrigins(Vec<HeaderValue>);

/// Whether a text is an origin as browsers send it, such as `https://app.example.org` or `http://localhost:3000`.
pub fn is_origin(text: &str) -> bool {
    let Some((scheme @ ("http" | "https"), authority)) = text.split_once("://") else { return false };
    let usual_port = if scheme == "http" { 80 } else { 443 };
    let is_plain =
        !authority.contains(['@', '/', '?', '#', '*']) && *authority == authority.to_ascii_lowercase();
    let parsed = authority.parse::<axum::http::uri::Authority>().ok().filter(|_| is_plain);
    parsed.is_some_and(|authority| {
        // A browser leaves out the usual port; one that is no number is none.
        let has_port = authority.host().len() < authority.as_str().len();
        !authority.host().is_empty()
            && (!has_port || authority.port_u16().is_some_and(|port| port != usual_port))
    })
}

impl AllowedOrigins {
    /// The origins of a text with spaces between them; those that are none are left out.
    pub fn new(allowed: &str) -> Self {
        let origins = allowed.split_whitespace().filter(|origin| is_origin(origin));
        Self(origins.filter_map(|origin| origin.parse().ok()).collect())
    }

    /// Whether a page of one of the origins sent the request.
    pub fn allow(&self, headers: &HeaderMap) -> bool {
        let mut origins = headers.get_all(header::ORIGIN).into_iter();
        let origin = origins.next().filter(|_| origins.next().is_none());
        origin.is_some_and(|origin| self.0.contains(origin))
    }

    /// The layer that answers preflight requests and lets the pages read answers; `None` where there are no origins.
    pub fn layer(&self) -> Option<CorsLayer> {
        let layer = || {
            CorsLayer::new()
                .allow_origin(self.0.clone())
                .allow_methods([Method::GET, Method::HEAD, Method::POST, Method::PATCH, Method::DELETE])
                .allow_headers([
                    header::AUTHORIZATION,
                    header::CONTENT_TYPE,
                    header::IF_MATCH,
                    header::IF_NONE_MATCH,
                    header::RANGE,
                    HeaderName::from_static("idempotency-key"),
                    HeaderName::from_static("last-event-id"),
                    HeaderName::from_static("prefer"),
                ])
                .expose_headers([
                    header::ACCEPT_RANGES,
                    header::CONTENT_DISPOSITION,
                    header::CONTENT_RANGE,
                    header::ETAG,
                    header::LOCATION,
                    header::RETRY_AFTER,
                    HeaderName::from_static("preference-applied"),
                    HeaderName::from_static("x-request-id"),
                ])
                .max_age(PREFLIGHT_LIFETIME)
        };
        (!self.0.is_empty()).then(layer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_those_that_browsers_send() {
        for (text, expected) in [
            ("https://app.example.org", true),
            ("http://localhost:3000", true),
            ("http://[::1]:3000", true),
            ("https://app.example.org:8443", true),
            ("https://app.example.org:443", false),
            ("http://app.example.org:80", false),
            ("https://app.example.org:", false),
            ("https://app.example.org/", false),
            ("https://App.example.org", false),
            ("https://*.example.org", false),
            ("https://user@app.example.org", false),
            ("https://", false),
            ("ftp://app.example.org", false),
            ("app.example.org", false),
            ("null", false),
            ("*", false),
        ] {
            assert_eq!(is_origin(text), expected, "{text:?}");
        }
    }
}
