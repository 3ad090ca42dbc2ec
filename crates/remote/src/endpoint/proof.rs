//! What a request carries so that the vendor knows who asks.

use std::time::{SystemTime, UNIX_EPOCH};

use reqwest::Url;

use super::{Endpoint, Proof};
use crate::Secret;
use crate::outbound::Outgoing;
use crate::tencent::ACTION_HEADER;
use crate::tencent::signature::{Signed, authorization};

impl Endpoint {
    /// The key, where it is sent as it is.
    pub(super) fn bearer(&self) -> Option<Secret> {
        self.key.clone().filter(|_| self.proof == Proof::Bearer)
    }

    /// Headers that hold now and for this request alone; none where it goes elsewhere than to the endpoint.
    pub(super) fn signature(&self, outgoing: &Outgoing) -> Vec<(String, String)> {
        let (Proof::Tc3 { secret_id, service }, Some(key)) = (&self.proof, &self.key) else {
            return Vec::new();
        };
        let action = outgoing.headers.iter().find(|(name, _)| name == ACTION_HEADER);
        let (Ok(url), Some((_, action))) = (Url::parse(&outgoing.url), action) else { return Vec::new() };
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
            content_type: &outgoing.content_type,
            body: &outgoing.body,
            timestamp_s,
        };
        vec![
            ("X-TC-Timestamp".to_owned(), timestamp_s.to_string()),
            ("Authorization".to_owned(), authorization(&signed, key)),
        ]
    }
}
