//! One request and its answer as a file: JSON, so that people can read it. Of the request's body only the digest is kept.

use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use super::redaction::without_signatures;
use crate::outbound::{Outgoing, Reply};

/// A request and its answer.
#[derive(Serialize, Deserialize)]
pub(super) struct Exchange {
    request: Request,
    reply: Answer,
}

/// For people; what is played is found by the file's name.
#[derive(Serialize, Deserialize)]
struct Request {
    method: String,
    url: String,
    headers: Vec<(String, String)>,
    content_type: String,
    body_bytes: u64,
    body_sha256: String,
}

#[derive(Serialize, Deserialize)]
struct Answer {
    status: u16,
    content_type: String,
    retry_after_secs: Option<u64>,
    #[serde(flatten)]
    body: Body,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Body {
    Text(String),
    Base64(String),
}

/// Of everything that decides an answer and is no secret: 64 hexadecimal digits.
pub fn digest_of(outgoing: &Outgoing) -> String {
    let Outgoing { method, url, headers, content_type, body, .. } = outgoing;
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
    hexadecimal(&digest.finalize())
}

impl Exchange {
    pub(super) fn of(outgoing: &Outgoing, reply: &Reply) -> Self {
        let kept = match &outgoing.bearer {
            Some(bearer) => bearer.redact(reply.body.clone()),
            None => reply.body.clone(),
        };
        let body = match std::str::from_utf8(&kept) {
            Ok(text) => Body::Text(without_signatures(text).into_owned()),
            Err(_) => Body::Base64(STANDARD.encode(&kept)),
        };
        Self {
            request: Request {
                method: outgoing.method.to_string(),
                url: without_signatures(&outgoing.url).into_owned(),
                headers: outgoing.headers.clone(),
                content_type: outgoing.content_type.clone().into_owned(),
                body_bytes: outgoing.body.len() as u64,
                body_sha256: hexadecimal(&Sha256::digest(&outgoing.body)),
            },
            reply: Answer {
                status: reply.status,
                content_type: reply.content_type.clone(),
                retry_after_secs: reply.retry_after.map(|pause| pause.as_secs()),
                body,
            },
        }
    }

    pub(super) fn text(&self) -> Vec<u8> {
        // Strings and numbers always have a JSON form.
        let mut text = serde_json::to_vec_pretty(self).unwrap_or_default();
        text.push(b'\n');
        text
    }

    /// The answer that a file holds, or why it holds none.
    pub(super) fn read(text: &[u8]) -> Result<Reply, String> {
        let Self { reply, .. } = serde_json::from_slice(text).map_err(|error| error.to_string())?;
        let body = match reply.body {
            Body::Text(text) => Bytes::from(text),
            Body::Base64(text) => STANDARD.decode(text).map_err(|error| error.to_string())?.into(),
        };
        Ok(Reply {
            status: reply.status,
            content_type: reply.content_type,
            retry_after: reply.retry_after_secs.map(Duration::from_secs),
            body,
        })
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
