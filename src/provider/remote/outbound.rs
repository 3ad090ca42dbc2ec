//! The one client for everything that leaves the program.
//!
//! It speaks to the addresses that [`AddressRules`] allow and to no proxy, keeps no cookies, and reads at most as much
//! of an answer as its caller wants. Redirects are followed for `GET` alone, each checked like the first address; what
//! proves who we are does not follow to another origin. A request that has a body is never sent elsewhere.

use std::borrow::Cow;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use bytes::{Bytes, BytesMut};
use reqwest::header::{CONTENT_LENGTH, CONTENT_TYPE, LOCATION, RETRY_AFTER};
use reqwest::redirect::Policy;
use reqwest::{Client, Method, Url};

use super::Secret;
use super::address::{AddressRefused, AddressRules, CheckedResolver};
use super::patience::asked_pause;

/// Most redirects of one `GET`.
const MAX_REDIRECTS: usize = 5;

/// Handle on the client; cloning shares its connections.
#[derive(Clone)]
pub struct Outbound {
    client: Client,
    rules: AddressRules,
}

/// What is sent.
#[derive(Clone, Debug)]
pub struct Outgoing {
    pub method: Method,
    pub url: String,
    /// Names and values; none of them secret.
    pub headers: Vec<(String, String)>,
    /// Sent as `Authorization: Bearer`.
    pub bearer: Option<Secret>,
    pub content_type: Cow<'static, str>,
    pub body: Bytes,
}

/// What came back, whatever its status.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reply {
    pub status: u16,
    /// Without parameters, in lower case; empty where none was sent.
    pub content_type: String,
    /// What `Retry-After` asks for.
    pub retry_after: Option<Duration>,
    pub body: Bytes,
}

/// Why nothing came back.
#[derive(Debug, thiserror::Error)]
pub enum SendError {
    #[error(transparent)]
    Address(#[from] AddressRefused),
    /// Nothing was sent.
    #[error("no connection: {0}")]
    Unreachable(String),
    /// It may have been sent, and the answer is lost.
    #[error("the connection broke: {0}")]
    Lost(String),
    #[error("the answer is larger than {limit} bytes")]
    TooLarge { limit: usize },
    #[error("the address leads on to another, which is not followed: {0}")]
    Redirected(String),
}

impl Outbound {
    /// Loads the system's certificates. Without them no https address can be reached, so that is an error.
    pub fn new(rules: AddressRules, connect_timeout: Duration) -> Result<Self, reqwest::Error> {
        // Only the first one counts; another part of the process may have set the same.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let client = Client::builder()
            .no_proxy()
            .redirect(Policy::none())
            .referer(false)
            .connect_timeout(connect_timeout)
            .pool_idle_timeout(Duration::from_secs(30))
            .user_agent(concat!("tabletopgen/", env!("CARGO_PKG_VERSION")))
            .dns_resolver(Arc::new(CheckedResolver(rules.clone())))
            .build()?;
        Ok(Self { client, rules })
    }

    /// Sends it and reads the answer, at most `limit` bytes. Takes as long as it takes: time is the caller's.
    pub async fn send(&self, outgoing: &Outgoing, limit: usize) -> Result<Reply, SendError> {
        let first = self.rules.check(&outgoing.url)?;
        let mut url = first.clone();
        for _ in 0..=MAX_REDIRECTS {
            let mut request = self.client.request(outgoing.method.clone(), url.clone());
            for (name, value) in &outgoing.headers {
                request = request.header(name, value);
            }
            if let Some(bearer) = outgoing.bearer.as_ref().filter(|_| url.origin() == first.origin()) {
                request = request.bearer_auth(bearer.expose());
            }
            if !outgoing.body.is_empty() {
                request = request.header(CONTENT_TYPE, &*outgoing.content_type).body(outgoing.body.clone());
            }
            let answer = request.send().await.map_err(|error| failed(&error))?;
            match next(&answer, &url) {
                None => return read(answer, limit).await,
                Some(target) if outgoing.method == Method::GET => {
                    url =
                        self.rules.check(&target.ok_or_else(|| SendError::Redirected("nowhere".into()))?)?;
                }
                Some(target) => {
                    let host = target.and_then(|url| Url::parse(&url).ok());
                    let host = host.and_then(|url| url.host_str().map(str::to_owned));
                    return Err(SendError::Redirected(host.unwrap_or_else(|| "nowhere".into())));
                }
            }
        }
        Err(SendError::Redirected(format!("more than {MAX_REDIRECTS} times")))
    }
}

/// Where a redirect leads; `None` for an answer that is none.
fn next(answer: &reqwest::Response, at: &Url) -> Option<Option<String>> {
    if !matches!(answer.status().as_u16(), 301 | 302 | 303 | 307 | 308) {
        return None;
    }
    let location = answer.headers().get(LOCATION).and_then(|value| value.to_str().ok());
    Some(location.and_then(|location| at.join(location).ok()).map(String::from))
}

async fn read(mut answer: reqwest::Response, limit: usize) -> Result<Reply, SendError> {
    let header = |name| answer.headers().get(name).and_then(|value| value.to_str().ok());
    let content_type = header(CONTENT_TYPE).and_then(|value| value.split(';').next()).unwrap_or_default();
    let content_type = content_type.trim().to_ascii_lowercase();
    let retry_after = header(RETRY_AFTER).and_then(|value| asked_pause(value, SystemTime::now()));
    let promised: Option<usize> = header(CONTENT_LENGTH).and_then(|value| value.parse().ok());
    let status = answer.status().as_u16();
    if promised.is_some_and(|bytes| bytes > limit) {
        return Err(SendError::TooLarge { limit });
    }
    let mut body = BytesMut::new();
    while let Some(chunk) = answer.chunk().await.map_err(|error| SendError::Lost(chain(&error)))? {
        if body.len() + chunk.len() > limit {
            return Err(SendError::TooLarge { limit });
        }
        body.extend_from_slice(&chunk);
    }
    Ok(Reply { status, content_type, retry_after, body: body.freeze() })
}

fn failed(error: &reqwest::Error) -> SendError {
    let mut cause: Option<&(dyn std::error::Error + 'static)> = std::error::Error::source(error);
    while let Some(inner) = cause {
        if let Some(refused) = inner.downcast_ref::<AddressRefused>() {
            return SendError::Address(refused.clone());
        }
        cause = inner.source();
    }
    match error.is_connect() || error.is_builder() {
        true => SendError::Unreachable(chain(error)),
        false => SendError::Lost(chain(error)),
    }
}

/// The causes without the URL, which the caller names where it has no query.
fn chain(error: &reqwest::Error) -> String {
    let mut cause = std::error::Error::source(error);
    let mut texts = Vec::new();
    while let Some(inner) = cause {
        texts.push(inner.to_string());
        cause = inner.source();
    }
    if texts.is_empty() { "no reason is known".into() } else { texts.join(": ") }
}
