//! The one client for everything that leaves the program.
//!
//! It speaks to the addresses that [`AddressRules`] allow and to no proxy, keeps no cookies, and reads at most as much
//! of an answer as its caller wants. Redirects are followed for `GET` alone, each checked like the first address; what
//! proves who we are does not follow to another origin. A request that has a body is never sent elsewhere. What is said can
//! be recorded, and a recording speaks in place of the network ([`cassette`](super::cassette)).

use std::borrow::Cow;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use bytes::{Bytes, BytesMut};
use reqwest::header::{CONTENT_LENGTH, CONTENT_TYPE, LOCATION, RETRY_AFTER};
use reqwest::redirect::Policy;
use reqwest::{Client, Method, Url};

use super::Secret;
use super::address::{AddressRefused, AddressRules, CheckedResolver};
use super::cassette::Cassette;
use super::patience::asked_pause;

/// Most redirects of one `GET`.
const MAX_REDIRECTS: usize = 5;

/// Handle on the client; cloning shares its connections.
#[derive(Clone)]
pub struct Outbound {
    rules: AddressRules,
    line: Line,
}

/// What is spoken through.
#[derive(Clone)]
enum Line {
    Network(Client),
    Recorded(Client, Arc<Cassette>),
    /// There is no network.
    Played(Arc<Cassette>),
}

/// What is sent.
#[derive(Clone, Debug)]
pub struct Outgoing {
    pub method: Method,
    pub url: String,
    /// Names and values; none of them secret, and all of them part of what is asked.
    pub headers: Vec<(String, String)>,
    /// Names and values that differ from try to try, or prove who asks: no part of what is asked.
    pub passing_headers: Vec<(String, String)>,
    /// Sent as `Authorization: Bearer`.
    pub bearer: Option<Secret>,
    pub content_type: Cow<'static, str>,
    pub body: Bytes,
}

impl Outgoing {
    /// A file from an address that somebody else names: nothing of ours goes along.
    pub fn fetching(url: String) -> Self {
        Self {
            method: Method::GET,
            url,
            headers: Vec::new(),
            passing_headers: Vec::new(),
            bearer: None,
            content_type: "application/octet-stream".into(),
            body: Bytes::new(),
        }
    }
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
    #[error("the recording has no answer to {0}; record the same scene with the same settings")]
    NotRecorded(String),
    #[error("the answer came and could not be recorded: {0}")]
    NotKept(String),
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
        Ok(Self { rules, line: Line::Network(client) })
    }

    /// Keeps whatever is answered.
    pub fn recording(self, cassette: Arc<Cassette>) -> Self {
        let line = match self.line {
            Line::Network(client) | Line::Recorded(client, _) => Line::Recorded(client, cassette),
            played @ Line::Played(_) => played,
        };
        Self { line, ..self }
    }

    /// Answers from a recording alone.
    pub fn playing(rules: AddressRules, cassette: Arc<Cassette>) -> Self {
        Self { rules, line: Line::Played(cassette) }
    }

    /// Whether answers come from a recording, so that nobody is paid for them.
    pub fn is_playing(&self) -> bool {
        matches!(self.line, Line::Played(_))
    }

    /// Sends it and reads the answer, at most `limit` bytes. Takes as long as it takes: time is the caller's.
    pub async fn send(&self, outgoing: &Outgoing, limit: usize) -> Result<Reply, SendError> {
        let url = self.rules.check(&outgoing.url)?;
        match &self.line {
            Line::Network(client) => self.spoken(client, outgoing, url, limit).await,
            Line::Recorded(client, cassette) => {
                let reply = self.spoken(client, outgoing, url, limit).await?;
                let kept = cassette.keep(outgoing, &reply).await;
                kept.map_err(|error| SendError::NotKept(error.to_string()))?;
                Ok(reply)
            }
            Line::Played(cassette) => match cassette.find(outgoing) {
                Some(reply) if reply.body.len() > limit => Err(SendError::TooLarge { limit }),
                Some(reply) => Ok(reply),
                None => {
                    let told =
                        format!("{} {}{}", outgoing.method, url.origin().ascii_serialization(), url.path());
                    Err(SendError::NotRecorded(told))
                }
            },
        }
    }

    async fn spoken(
        &self,
        client: &Client,
        outgoing: &Outgoing,
        first: Url,
        limit: usize,
    ) -> Result<Reply, SendError> {
        let mut url = first.clone();
        for _ in 0..=MAX_REDIRECTS {
            let mut request = client.request(outgoing.method.clone(), url.clone());
            for (name, value) in &outgoing.headers {
                request = request.header(name, value);
            }
            let same_origin = url.origin() == first.origin();
            for (name, value) in outgoing.passing_headers.iter().filter(|_| same_origin) {
                request = request.header(name, value);
            }
            if let Some(bearer) = outgoing.bearer.as_ref().filter(|_| same_origin) {
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
