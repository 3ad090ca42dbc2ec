//! Bodies of requests on their way in: not encoded, within a size, a total time, a minimum rate and the memory of all
//! bodies.

use std::ops::Deref;
use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::http::request::Parts;
use axum::http::{HeaderMap, header};
use bytes::Bytes;
use http_body_util::BodyExt;
use tokio::time::{Instant, timeout, timeout_at};

use super::Api;
use super::body_memory::Reservation;
use super::serve::connection::Connection;
use crate::problem::{Problem, ProblemType};

/// Initial capacity of a collected body. More follows as bytes arrive, whatever the header promises.
const INITIAL_CAPACITY: usize = 64 << 10;

/// Before a body is refused, this much of the rest is read for this long: many clients read the answer only after they
/// have sent everything.
const MAX_DISCARDED_BYTES: usize = 64 << 20;
const MAX_DISCARD_TIME: Duration = Duration::from_secs(2);

/// Code of the refusal of a body with a `Content-Encoding`.
pub(super) const ENCODED_BODY: &str = "content_encoding";

/// A body that is being read.
pub struct BodyReader {
    body: Body,
    max_bytes: usize,
    received_bytes: usize,
    /// Length that the header promises.
    promised_bytes: Option<usize>,
    /// Whether the header says that the bytes are compressed, or encoded otherwise.
    is_encoded: bool,
    memory: Reservation,
    timeout: Duration,
    deadline: Instant,
    rate: RateWindow,
    connection: Option<Arc<Connection>>,
}

/// The bytes of the present window of the minimum rate.
struct RateWindow {
    length: Duration,
    min_bytes: u64,
    ends: Instant,
    bytes: u64,
}

/// A body that has arrived, and its memory.
#[derive(Debug)]
pub struct ReceivedBody {
    pub bytes: Vec<u8>,
    pub memory: Reservation,
}

impl Deref for ReceivedBody {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.bytes
    }
}

impl BodyReader {
    /// A reader of the body of a request, of at most `max_bytes`.
    pub fn new(api: &Api, parts: &Parts, body: Body, max_bytes: usize) -> Self {
        let connection = parts.extensions.get::<Arc<Connection>>().cloned();
        Self {
            connection,
            promised_bytes: content_length(&parts.headers),
            is_encoded: is_encoded(&parts.headers),
            ..Self::of(api, body, max_bytes)
        }
    }

    /// A reader of a body whose request is not known.
    pub fn of(api: &Api, body: Body, max_bytes: usize) -> Self {
        let settings = &api.settings;
        let timeout = Duration::from_secs(settings.body_timeout_secs);
        let length = Duration::from_secs(settings.rate_window_secs.max(1));
        let min_bytes = settings.min_rate_bytes_per_s.saturating_mul(length.as_secs());
        let now = Instant::now();
        Self {
            body,
            max_bytes,
            received_bytes: 0,
            promised_bytes: None,
            is_encoded: false,
            memory: api.body_memory.reservation(),
            timeout,
            deadline: now + timeout,
            rate: RateWindow { length, min_bytes, ends: now + length, bytes: 0 },
            connection: None,
        }
    }

    /// The next bytes; `None` at the end. Memory for all bytes so far is reserved.
    ///
    /// # Errors
    ///
    /// A [`Problem`] where the body is encoded, too large, too slow or incomplete, or the memory is used up.
    pub async fn next(&mut self) -> Result<Option<Bytes>, Problem> {
        if self.is_encoded {
            let detail = "send the body as it is: this server takes no Content-Encoding but identity";
            let problem = Problem::new(ProblemType::UnsupportedMediaType, ENCODED_BODY, detail);
            return Err(self.refuse(problem).await);
        }
        if self.promised_bytes.is_some_and(|bytes| bytes > self.max_bytes) {
            return Err(self.refuse(self.too_large()).await);
        }
        if let Some(connection) = &self.connection {
            connection.await_body(true);
        }
        let next = self.next_before_deadline().await;
        if let Some(connection) = &self.connection {
            connection.await_body(false);
        }
        let Some(bytes) = next? else { return Ok(None) };
        self.received_bytes += bytes.len();
        self.rate.bytes += bytes.len() as u64;
        if self.received_bytes > self.max_bytes {
            return Err(self.refuse(self.too_large()).await);
        }
        if let Err(problem) = self.memory.grow_to(self.received_bytes) {
            return Err(self.refuse(problem).await);
        }
        Ok(Some(bytes))
    }

    async fn next_before_deadline(&mut self) -> Result<Option<Bytes>, Problem> {
        // A client that sends much at first and then nothing does not wait for the end of the second window.
        let stalls = Instant::now() + self.rate.length;
        loop {
            match timeout_at(self.deadline.min(self.rate.ends).min(stalls), self.body.frame()).await {
                Ok(None) => return Ok(None),
                Ok(Some(Ok(frame))) => match frame.into_data() {
                    Ok(bytes) => return Ok(Some(bytes)),
                    // Trailers say nothing here.
                    Err(_) => continue,
                },
                Ok(Some(Err(_))) => {
                    let detail = "the body ended too early";
                    return Err(Problem::new(ProblemType::MalformedRequest, "body_incomplete", detail));
                }
                Err(_) => self.check_rate(stalls)?,
            }
        }
    }

    /// At the end of a window or of the total time, or when nothing came for the length of a window.
    fn check_rate(&mut self, stalls: Instant) -> Result<(), Problem> {
        let now = Instant::now();
        let detail = if now >= self.deadline {
            format!("the body did not arrive within {} seconds", self.timeout.as_secs())
        } else if now >= stalls {
            format!("no bytes of the body arrived in {} seconds", self.rate.length.as_secs())
        } else if self.rate.bytes < self.rate.min_bytes {
            let (bytes, secs) = (self.rate.bytes, self.rate.length.as_secs());
            format!(
                "{bytes} bytes of the body arrived in {secs} seconds; send at least {}",
                self.rate.min_bytes
            )
        } else {
            (self.rate.bytes, self.rate.ends) = (0, now + self.rate.length);
            return Ok(());
        };
        metrics::counter!("tabletopgen_requests_refused_total", "reason" => "slow_body").increment(1);
        Err(Problem::new(ProblemType::RequestTimeout, "body_too_slow", detail))
    }

    fn too_large(&self) -> Problem {
        let detail = format!("send at most {} bytes", self.max_bytes);
        Problem::new(ProblemType::PayloadTooLarge, "body_too_large", detail)
    }

    /// Discards a bounded part of the rest, then refuses. The memory is given back first.
    async fn refuse(&mut self, problem: Problem) -> Problem {
        self.memory.shrink_to(0);
        let discard = async {
            let mut bytes = 0;
            while let Some(Ok(frame)) = self.body.frame().await {
                bytes += frame.data_ref().map_or(0, Bytes::len);
                if bytes > MAX_DISCARDED_BYTES {
                    break;
                }
            }
        };
        let _ = timeout(MAX_DISCARD_TIME, discard).await;
        problem
    }

    /// The whole body.
    ///
    /// # Errors
    ///
    /// As [`Self::next`].
    pub async fn collect(mut self) -> Result<ReceivedBody, Problem> {
        let mut bytes = Vec::new();
        while let Some(more) = self.next().await? {
            if bytes.is_empty() {
                bytes.reserve(self.promised_bytes.unwrap_or_default().min(INITIAL_CAPACITY));
            }
            bytes.extend_from_slice(&more);
        }
        Ok(ReceivedBody { bytes, memory: self.memory })
    }

    /// Takes the reservation of the bytes so far out of the reader.
    pub fn take_memory(&mut self) -> Reservation {
        std::mem::take(&mut self.memory)
    }
}

fn content_length(headers: &HeaderMap) -> Option<usize> {
    headers.get(header::CONTENT_LENGTH)?.to_str().ok()?.parse().ok()
}

/// Whether a body has a coding other than `identity`; what cannot be read is one.
fn is_encoded(headers: &HeaderMap) -> bool {
    let codings = headers.get_all(header::CONTENT_ENCODING).into_iter();
    codings.flat_map(|codings| codings.to_str().unwrap_or("unreadable").split(',')).any(|coding| {
        let coding = coding.trim();
        !coding.is_empty() && !coding.eq_ignore_ascii_case("identity")
    })
}
