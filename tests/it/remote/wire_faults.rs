//! Faults that any HTTP server may have, for the servers that speak vendors' protocols: a script of them, one
//! a request.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::body::Body;
use axum::response::Response;
use bytes::Bytes;
use futures::stream;

/// Fault that one request gets in place of a good answer.
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

    /// Response in place of the good answer `body`.
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
            Self::Status(status, message) => Response::builder()
                .status(status)
                .header("content-type", "application/json")
                .body(message.into())
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
            Self::Body(message) => ok("application/json", message.into()),
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

/// Faults of the first requests, the class of the result, and the recorded outcomes.
pub type Case<F> = (Vec<F>, &'static str, Vec<&'static str>);

/// The script that every adapter has to survive whose question is answered at once and costs something.
pub fn cases<F>(fault: impl Fn(WireFault) -> F) -> Vec<Case<F>> {
    use WireFault::*;
    const ANSWERED: &str = "answered";
    const UNKNOWN: &str = "outcome_unknown";
    let cases: Vec<Case<WireFault>> = vec![
        (vec![], "ok", vec![ANSWERED]),
        (vec![Latency(Duration::from_millis(100))], "ok", vec![ANSWERED]),
        (vec![Busy(0)], "ok", vec!["provider_busy", ANSWERED]),
        // Longer than anybody waits here: the job goes back to its queue.
        (vec![Busy(3600)], "rate_limited 3600", vec!["provider_busy"]),
        (vec![Status(500, "{}")], "ok", vec!["provider_server_error", ANSWERED]),
        (vec![Status(500, "{}"); 3], "transient provider_server_error", vec!["provider_server_error"; 3]),
        (vec![Status(401, "{}")], "misconfigured provider_denied", vec!["provider_denied"]),
        (vec![Status(404, "{}")], "misconfigured provider_not_found", vec!["provider_not_found"]),
        (vec![Status(422, "{}")], "rejected provider_rejected_request", vec!["provider_rejected_request"]),
        (vec![ResetMidBody], "ok", vec![UNKNOWN, ANSWERED]),
        (vec![ResetMidBody; 3], "transient provider_connection_lost", vec![UNKNOWN; 3]),
        (vec![ResetBeforeHeader], "ok", vec![UNKNOWN, ANSWERED]),
        (vec![Silence], "ok", vec![UNKNOWN, ANSWERED]),
        (vec![Page], "ok", vec!["provider_bad_answer", ANSWERED]),
        (vec![Page; 3], "transient provider_bad_answer", vec!["provider_bad_answer"; 3]),
        (vec![Body("[]")], "ok", vec!["provider_bad_answer", ANSWERED]),
        (vec![Endless], "transient provider_answer_too_large", vec!["provider_answer_too_large"]),
        (
            vec![Redirect("http://169.254.169.254/")],
            "misconfigured provider_redirected",
            vec!["provider_redirected"],
        ),
    ];
    let all = cases
        .into_iter()
        .map(|(faults, class, outcomes)| (faults.into_iter().map(&fault).collect(), class, outcomes));
    all.collect()
}

/// Faults of the next requests, in order; those after them get good answers.
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

    /// Faults that no request has taken yet.
    pub fn left(&self) -> usize {
        self.0.lock().unwrap().len()
    }
}
