//! Authentication of requests: a bearer key or a TC3 signature.

use std::time::{SystemTime, UNIX_EPOCH};

use http_client::{HttpRequest, Secret, Url};

use super::Endpoint;
use crate::tencent::ACTION_HEADER;
use crate::tencent::signature::{Signed, authorization};

/// Method by which a key authenticates requests.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Auth {
    /// The key is sent as `Authorization: Bearer`.
    Bearer,
    /// The key signs requests as Tencent Cloud requires; `secret_id` is sent with the signature.
    Tc3 { secret_id: String, service: String },
}

impl Endpoint {
    /// The key, where it is sent as a bearer key.
    pub(super) fn bearer(&self) -> Option<Secret> {
        self.key.clone().filter(|_| self.auth == Auth::Bearer)
    }

    /// Signature headers, valid now and for this request only; empty where the request has no action header.
    pub(super) fn signature(&self, request: &HttpRequest) -> Vec<(String, String)> {
        let (Auth::Tc3 { secret_id, service }, Some(key)) = (&self.auth, &self.key) else {
            return Vec::new();
        };
        let action = request.headers.iter().find(|(name, _)| name == ACTION_HEADER);
        let (Ok(url), Some((_, action))) = (Url::parse(&request.url), action) else { return Vec::new() };
        let host = match (url.host_str(), url.port()) {
            (Some(host), Some(port)) => format!("{host}:{port}"),
            (host, _) => host.unwrap_or_default().to_owned(),
        };
        let timestamp_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        let signed = Signed {
            secret_id,
            service,
            host: &host,
            action,
            content_type: &request.content_type,
            body: &request.body,
            timestamp_s,
        };
        vec![
            ("X-TC-Timestamp".to_owned(), timestamp_s.to_string()),
            ("Authorization".to_owned(), authorization(&signed, key)),
        ]
    }
}
