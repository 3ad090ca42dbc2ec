//! The file format of one exchange: readable JSON, with the digest of the request body in place of the body.

use std::time::Duration;

use base64::engine::general_purpose::STANDARD;
use base64::{DecodeError, Engine as _};
use bytes::Bytes;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use runtime::digest::hex;

use super::redaction::without_signatures;
use crate::message::{HttpRequest, HttpResponse};

/// A request and its response.
#[derive(Serialize, Deserialize)]
pub(super) struct Exchange {
    request: RequestRecord,
    reply: ResponseRecord,
}

/// Describes the request to a reader; replay finds an exchange by its file name.
#[derive(Serialize, Deserialize)]
struct RequestRecord {
    method: String,
    url: String,
    headers: Vec<(String, String)>,
    content_type: String,
    body_bytes: u64,
    body_sha256: String,
}

#[derive(Serialize, Deserialize)]
struct ResponseRecord {
    status: u16,
    content_type: String,
    retry_after_secs: Option<u64>,
    #[serde(flatten)]
    body: BodyRecord,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum BodyRecord {
    Text(String),
    Base64(String),
}

/// Reason why a file is no recorded exchange.
#[derive(Debug, thiserror::Error)]
pub enum ExchangeError {
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    #[error(transparent)]
    Base64(#[from] DecodeError),
}

/// SHA-256 of the parts of a request that decide its response and are not secret: 64 hexadecimal digits.
pub fn request_digest(request: &HttpRequest) -> String {
    let HttpRequest { method, url, headers, content_type, body, .. } = request;
    let url = without_signatures(url);
    let mut digest = Sha256::new();
    let mut part = |bytes: &[u8]| {
        digest.update((bytes.len() as u64).to_le_bytes());
        digest.update(bytes);
    };
    part(method.as_str().as_bytes());
    part(url.as_bytes());
    part(content_type.as_bytes());
    part(body);
    for (name, value) in headers {
        part(name.to_ascii_lowercase().as_bytes());
        part(value.as_bytes());
    }
    hex(&digest.finalize())
}

impl Exchange {
    pub(super) fn new(request: &HttpRequest, response: &HttpResponse) -> Self {
        let redacted = match &request.bearer {
            Some(bearer) => bearer.redact(response.body.clone()),
            None => response.body.clone(),
        };
        let body = match std::str::from_utf8(&redacted) {
            Ok(text) => BodyRecord::Text(without_signatures(text).into_owned()),
            Err(_) => BodyRecord::Base64(STANDARD.encode(&redacted)),
        };
        Self {
            request: RequestRecord {
                method: request.method.to_string(),
                url: without_signatures(&request.url).into_owned(),
                headers: request.headers.clone(),
                content_type: request.content_type.clone().into_owned(),
                body_bytes: request.body.len() as u64,
                body_sha256: hex(&Sha256::digest(&request.body)),
            },
            reply: ResponseRecord {
                status: response.status,
                content_type: response.content_type.clone(),
                retry_after_secs: response.retry_after.map(|pause| pause.as_secs()),
                body,
            },
        }
    }

    pub(super) fn to_json(&self) -> Vec<u8> {
        // Strings and numbers always have a JSON form.
        let mut text = serde_json::to_vec_pretty(self).unwrap_or_default();
        text.push(b'\n');
        text
    }

    /// The response in a file, or the reason why the file is malformed.
    pub(super) fn read(text: &[u8]) -> Result<HttpResponse, ExchangeError> {
        let Self { reply, .. } = serde_json::from_slice(text)?;
        let body = match reply.body {
            BodyRecord::Text(text) => Bytes::from(text),
            BodyRecord::Base64(text) => STANDARD.decode(text)?.into(),
        };
        Ok(HttpResponse {
            status: reply.status,
            content_type: reply.content_type,
            retry_after: reply.retry_after_secs.map(Duration::from_secs),
            body,
        })
    }
}
