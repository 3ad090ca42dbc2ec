//! Requests and responses as values, independent of the transport.

use std::borrow::Cow;
use std::time::Duration;

use bytes::Bytes;
use reqwest::Method;

use super::Secret;

/// A request.
#[derive(Clone, Debug)]
pub struct HttpRequest {
    pub method: Method,
    pub url: String,
    /// Names and values. They hold no secrets and are part of the request's digest.
    pub headers: Vec<(String, String)>,
    /// Names and values that differ between attempts or authenticate the sender. They are not part of the digest.
    pub transient_headers: Vec<(String, String)>,
    /// Sent as `Authorization: Bearer`.
    pub bearer: Option<Secret>,
    pub content_type: Cow<'static, str>,
    pub body: Bytes,
}

impl HttpRequest {
    /// A `GET` of a file at an address from outside the program; it carries no headers and no key.
    pub fn get(url: String) -> Self {
        Self {
            method: Method::GET,
            url,
            headers: Vec::new(),
            transient_headers: Vec::new(),
            bearer: None,
            content_type: "application/octet-stream".into(),
            body: Bytes::new(),
        }
    }
}

/// A response of any status.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HttpResponse {
    pub status: u16,
    /// Without parameters, in lower case; empty where the server sends none.
    pub content_type: String,
    /// The pause that `Retry-After` requests.
    pub retry_after: Option<Duration>,
    pub body: Bytes,
}
