//! Faults that any HTTP server may have, for the servers that speak vendors' protocols: a script of them, one a request.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::body::Body;
use axum::response::Response;
use bytes::Bytes;
use futures::stream;

/// What one request gets in place of a good answer.
#[derive(Clone, Debug)]
pub enum WireFault {
    /// A good answer, late.
    Latency(Duration),
    /// No answer.
    Silence,
    /// 429 with `Retry-After`, seconds.
    Busy(u64),
    /// A status, with this body.
    Status(u16, &'static str),
    /// Half of a good answer, then the connection breaks.
    ResetMidBody,
    /// The connection breaks before the answer.
    ResetBeforeHeader,
    /// A page for people, with status 200.
    Page,
    /// Status 200 with this body.
    Body(&'static str),
    /// More bytes than anybody wants.
    Endless,
    /// Leads to another address.
    Redirect(&'static str),
}

impl WireFault {
    /// Whether the server did what it was asked to, and asks money for it.
    pub fn is_billed(&self) -> bool {
        !matches!(self, Self::Busy(_) | Self::Status(..) | Self::Redirect(_))
    }

    /// What comes in place of the good answer `body`.
    pub async fn response(self, content_type: &str, body: Bytes) -> Response {
        let ok = |content_type: &str, body: Body| {
            Response::builder().header("content-type", content_type).body(body).unwrap()
        };
        match self {
            Self::Latency(pause) => {
                tokio::time::sleep(pause).await;
                ok(content_type, body.into())
            }
            Self::Silence => std::future::pending().await,
            Self::Busy(seconds) => Response::builder()
                .status(429)
                .header("retry-after", seconds)
                .body(r#"{"detail": "Too many requests"}"#.into())
                .unwrap(),
            Self::Status(status, told) => Response::builder()
                .status(status)
                .header("content-type", "application/json")
                .body(told.into())
                .unwrap(),
            Self::ResetMidBody => {
                let half = body.slice(..body.len() / 2);
                let broken = Err(std::io::Error::other("reset"));
                ok(content_type, Body::from_stream(stream::iter([Ok(half), broken])))
            }
            Self::ResetBeforeHeader => panic!("the connection of this request breaks"),
            Self::Page => {
                ok("text/html; charset=utf-8", "<!doctype html><title>Just a moment...</title>".into())
            }
            Self::Body(told) => ok("application/json", told.into()),
            Self::Endless => {
                let chunk = Bytes::from(vec![b' '; 64 << 10]);
                let chunks = stream::repeat_with(move || Ok::<_, std::io::Error>(chunk.clone()));
                ok("application/json", Body::from_stream(chunks))
            }
            Self::Redirect(target) => {
                Response::builder().status(307).header("location", target).body(Body::empty()).unwrap()
            }
        }
    }
}

/// What the next requests get, in order; those after them, good answers.
#[derive(Clone, Debug)]
pub struct Faults<F>(Arc<Mutex<VecDeque<F>>>);

impl<F> Default for Faults<F> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<F> Faults<F> {
    pub fn script(&self, faults: impl IntoIterator<Item = F>) {
        self.0.lock().unwrap().extend(faults);
    }

    pub fn next(&self) -> Option<F> {
        self.0.lock().unwrap().pop_front()
    }

    /// Faults nobody has come for yet.
    pub fn left(&self) -> usize {
        self.0.lock().unwrap().len()
    }
}
