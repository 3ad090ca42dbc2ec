//! The client: sends requests to allowed addresses and reads bounded responses.
//!
//! It connects only to addresses that [`AddressPolicy`] allows, uses no proxy, keeps no cookies, and reads at most as
//! many bytes of a response as the caller permits. Redirects are followed for `GET` alone; the policy checks each
//! target. Authentication headers are not sent to another origin. A request with a body is never redirected.
//! Exchanges can be recorded, and a recording can replace the network ([`cassette`](super::cassette)).

use std::sync::Arc;
use std::time::{Duration, SystemTime};

use bytes::BytesMut;
use reqwest::header::{CONTENT_LENGTH, CONTENT_TYPE, LOCATION, RETRY_AFTER};
use reqwest::redirect::Policy;
use reqwest::{Client, Method, Url};

use runtime::error_chain;

use super::address::{AddressError, AddressPolicy, CheckedResolver};
use super::cassette::Cassette;
use super::message::{HttpRequest, HttpResponse};
use super::retry::retry_after;

/// Maximum redirects of one `GET`.
const MAX_REDIRECTS: usize = 5;

/// Handle on the client; clones share its connections.
#[derive(Clone)]
pub struct HttpClient {
    policy: AddressPolicy,
    transport: Transport,
}

/// The source of responses.
#[derive(Clone)]
enum Transport {
    Network(Connectors),
    Recording(Connectors, Arc<Cassette>),
    /// Without a network.
    Replay(Arc<Cassette>),
}

/// Two clients, because a resolver does not know the port: one may resolve the names of private hosts, and serves the
/// URLs whose host and port the policy names.
#[derive(Clone)]
struct Connectors {
    private: Client,
    public: Client,
}

impl Connectors {
    fn new(policy: &AddressPolicy, connect_timeout: Duration) -> Result<Self, reqwest::Error> {
        let client = |policy: AddressPolicy| {
            Client::builder()
                .no_proxy()
                .redirect(Policy::none())
                .referer(false)
                .connect_timeout(connect_timeout)
                .pool_idle_timeout(Duration::from_secs(30))
                .user_agent(concat!("tabletopgen/", env!("CARGO_PKG_VERSION")))
                .dns_resolver(Arc::new(CheckedResolver(policy)))
                .build()
        };
        let public = client(policy.public())?;
        let private = if policy.has_private_hosts() { client(policy.clone())? } else { public.clone() };
        Ok(Self { private, public })
    }
}

/// Treatment of a response that is longer than its limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Excess {
    Refused,
    Cut,
}

/// Failure of a request without a response.
#[derive(Debug, thiserror::Error)]
pub enum SendError {
    #[error(transparent)]
    Address(#[from] AddressError),
    /// No connection; nothing was sent.
    #[error("no connection: {0}")]
    Unreachable(String),
    /// The request may have been sent, and the response is lost.
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

impl HttpClient {
    /// A client that uses the network.
    ///
    /// # Errors
    ///
    /// Fails where the system's certificates cannot be loaded: without them no `https` address can be reached.
    pub fn new(policy: AddressPolicy, connect_timeout: Duration) -> Result<Self, reqwest::Error> {
        // Only the first installation counts; another part of the process may have installed the same provider.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let connectors = Connectors::new(&policy, connect_timeout)?;
        Ok(Self { policy, transport: Transport::Network(connectors) })
    }

    /// Records every response in `cassette`.
    pub fn recording(self, cassette: Arc<Cassette>) -> Self {
        let transport = match self.transport {
            Transport::Network(connectors) | Transport::Recording(connectors, _) => {
                Transport::Recording(connectors, cassette)
            }
            replay @ Transport::Replay(_) => replay,
        };
        Self { transport, ..self }
    }

    /// A client that takes every response from `cassette` and never uses the network.
    pub fn replaying(policy: AddressPolicy, cassette: Arc<Cassette>) -> Self {
        Self { policy, transport: Transport::Replay(cassette) }
    }

    /// Whether responses come from a recording and are therefore not billed.
    pub fn is_replaying(&self) -> bool {
        matches!(self.transport, Transport::Replay(_))
    }

    /// Sends `request` and reads at most `limit` bytes of the response. It has no deadline; the caller sets one.
    ///
    /// # Errors
    ///
    /// [`SendError`] tells whether the request may have been sent. A response of any status is no error.
    pub async fn send(&self, request: &HttpRequest, limit: usize) -> Result<HttpResponse, SendError> {
        self.answer(request, limit, Excess::Refused).await
    }

    /// As [`Self::send`]; a longer response is no error, and what is beyond `limit` bytes of it is not read.
    ///
    /// # Errors
    ///
    /// Those of [`Self::send`] but [`SendError::TooLarge`].
    pub async fn send_and_cut(&self, request: &HttpRequest, limit: usize) -> Result<HttpResponse, SendError> {
        self.answer(request, limit, Excess::Cut).await
    }

    async fn answer(
        &self,
        request: &HttpRequest,
        limit: usize,
        excess: Excess,
    ) -> Result<HttpResponse, SendError> {
        let url = self.policy.check(&request.url)?;
        match &self.transport {
            Transport::Network(connectors) => {
                self.send_following_redirects(connectors, request, url, (limit, excess)).await
            }
            Transport::Recording(connectors, cassette) => {
                let response =
                    self.send_following_redirects(connectors, request, url, (limit, excess)).await?;
                let recorded = cassette.record(request, &response).await;
                recorded.map_err(|error| SendError::NotKept(error.to_string()))?;
                Ok(response)
            }
            Transport::Replay(cassette) => match cassette.next_response(request) {
                Some(response) if response.body.len() > limit => match excess {
                    Excess::Refused => Err(SendError::TooLarge { limit }),
                    Excess::Cut => Ok(HttpResponse { body: response.body.slice(..limit), ..response }),
                },
                Some(response) => Ok(response),
                None => {
                    let message =
                        format!("{} {}{}", request.method, url.origin().ascii_serialization(), url.path());
                    Err(SendError::NotRecorded(message))
                }
            },
        }
    }

    async fn send_following_redirects(
        &self,
        connectors: &Connectors,
        request: &HttpRequest,
        first: Url,
        bound: (usize, Excess),
    ) -> Result<HttpResponse, SendError> {
        let mut url = first.clone();
        for _ in 0..=MAX_REDIRECTS {
            let client = if self.policy.names(&url) { &connectors.private } else { &connectors.public };
            let mut builder = client.request(request.method.clone(), url.clone());
            for (name, value) in &request.headers {
                builder = builder.header(name, value);
            }
            let same_origin = url.origin() == first.origin();
            for (name, value) in request.transient_headers.iter().filter(|_| same_origin) {
                builder = builder.header(name, value);
            }
            if let Some(bearer) = request.bearer.as_ref().filter(|_| same_origin) {
                builder = builder.bearer_auth(bearer.expose());
            }
            if !request.body.is_empty() {
                builder = builder.header(CONTENT_TYPE, &*request.content_type).body(request.body.clone());
            }
            let response = builder.send().await.map_err(|error| send_error(&error))?;
            match redirect_target(&response, &url) {
                None => return read_bounded(response, bound).await,
                Some(target) if request.method == Method::GET => {
                    url =
                        self.policy.check(&target.ok_or_else(|| SendError::Redirected("nowhere".into()))?)?;
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

/// The target of a redirect; the outer `None` means that the response is no redirect.
fn redirect_target(response: &reqwest::Response, at: &Url) -> Option<Option<String>> {
    if !matches!(response.status().as_u16(), 301 | 302 | 303 | 307 | 308) {
        return None;
    }
    let location = response.headers().get(LOCATION).and_then(|value| value.to_str().ok());
    Some(location.and_then(|location| at.join(location).ok()).map(String::from))
}

async fn read_bounded(
    mut response: reqwest::Response,
    (limit, excess): (usize, Excess),
) -> Result<HttpResponse, SendError> {
    let header = |name| response.headers().get(name).and_then(|value| value.to_str().ok());
    let content_type = header(CONTENT_TYPE).and_then(|value| value.split(';').next()).unwrap_or_default();
    let content_type = content_type.trim().to_ascii_lowercase();
    let retry_after = header(RETRY_AFTER).and_then(|value| retry_after(value, SystemTime::now()));
    let content_length: Option<usize> = header(CONTENT_LENGTH).and_then(|value| value.parse().ok());
    let status = response.status().as_u16();
    if excess == Excess::Refused && content_length.is_some_and(|bytes| bytes > limit) {
        return Err(SendError::TooLarge { limit });
    }
    let mut body = BytesMut::new();
    while let Some(chunk) = response.chunk().await.map_err(|error| SendError::Lost(chain(&error)))? {
        let room = limit - body.len();
        body.extend_from_slice(&chunk[..room.min(chunk.len())]);
        match excess {
            _ if chunk.len() <= room => {}
            Excess::Refused => return Err(SendError::TooLarge { limit }),
            Excess::Cut => break,
        }
    }
    Ok(HttpResponse { status, content_type, retry_after, body: body.freeze() })
}

fn send_error(error: &reqwest::Error) -> SendError {
    let mut cause: Option<&(dyn std::error::Error + 'static)> = std::error::Error::source(error);
    while let Some(inner) = cause {
        if let Some(refused) = inner.downcast_ref::<AddressError>() {
            return SendError::Address(refused.clone());
        }
        cause = inner.source();
    }
    match error.is_connect() || error.is_builder() {
        true => SendError::Unreachable(chain(error)),
        false => SendError::Lost(chain(error)),
    }
}

/// The chain of causes without the URL: its query may hold a signature.
fn chain(error: &reqwest::Error) -> String {
    std::error::Error::source(error).map_or_else(|| "no reason is known".into(), error_chain)
}
