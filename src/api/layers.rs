//! Layers around every handler: a request id, the body of problem documents, metrics, and a panic that becomes a 500
//! instead of a closed connection.

use std::time::{Duration, Instant};

use axum::body::Body;
use axum::extract::{DefaultBodyLimit, MatchedPath, Request};
use axum::http::{HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::{Next, from_fn};
use axum::response::{IntoResponse, Response};
use axum::{Router, middleware};
use tower_http::catch_panic::CatchPanicLayer;
use tracing::{Instrument, Span};
use uuid::Uuid;

use super::Api;
use crate::path_without_keys::path_without_keys;
use crate::problem::{Problem, ProblemType};
use crate::spans;

/// Refusals by a limit are answered after this pause. A client that does not heed `Retry-After` sends again when it has
/// the answer, and answering it at once would take the processor from other tenants.
const PAUSE_OF_REFUSAL: Duration = Duration::from_millis(100);

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Wraps the routes.
pub(super) fn around(router: Router<Api>, api: &Api) -> Router<Api> {
    router
        .layer(DefaultBodyLimit::max(api.settings.max_body_bytes))
        .layer(CatchPanicLayer::custom(|_| {
            Problem::new(
                ProblemType::Internal,
                "internal_error",
                "a bug stopped this request; the log has the details under this request id",
            )
            .into_response()
        }))
        .layer::<middleware::FromFnLayer<_, (), _>>(from_fn(answer))
        .route_layer(from_fn(count))
}

/// Gives the request an id (the client's, when it is a sane one) and finishes problem documents.
async fn answer(request: Request, next: Next) -> Response {
    let given = request.headers().get(REQUEST_ID).and_then(|id| id.to_str().ok()).filter(|id| {
        (1..=128).contains(&id.len())
            && id.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'-' | b'_' | b'.' | b':'))
    });
    let id = given.map_or_else(|| Uuid::now_v7().to_string(), str::to_owned);
    let started = Instant::now();
    let trace_parent = request.headers().get("traceparent").and_then(|value| value.to_str().ok());
    let path = path_without_keys(request.uri().path());
    let span = spans::request(&id, request.method().as_str(), &path, trace_parent);
    let route = request.extensions().get::<MatchedPath>().cloned();
    let mut response = next.run(request).instrument(span.clone()).await;
    log_access(&span, route.as_ref(), response.status(), started);
    if let Some(problem) = response.extensions_mut().remove::<Problem>() {
        if problem.limit.is_some() {
            tokio::time::sleep(PAUSE_OF_REFUSAL).await;
        }
        let body = problem.document(&id).to_string();
        *response.body_mut() = Body::from(body);
        let headers = response.headers_mut();
        headers.remove(header::CONTENT_LENGTH);
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
    } else if response.status() == StatusCode::BAD_REQUEST && is_plain(&response) {
        // Extractors of the framework refuse in plain text.
        let text = axum::body::to_bytes(std::mem::take(response.body_mut()), 4096).await.unwrap_or_default();
        let detail = String::from_utf8_lossy(&text).into_owned();
        let problem = Problem::new(ProblemType::MalformedRequest, "malformed_request", detail);
        response = problem.document(&id).to_string().into_response();
        *response.status_mut() = StatusCode::BAD_REQUEST;
        response
            .headers_mut()
            .insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
    }
    if let Ok(id) = HeaderValue::from_str(&id) {
        response.headers_mut().insert(REQUEST_ID, id);
    }
    response.headers_mut().insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    response
}

/// A line in the access log, and route and status in the span.
fn log_access(span: &Span, route: Option<&MatchedPath>, status: StatusCode, started: Instant) {
    let (route, status) = (route.map_or("none", MatchedPath::as_str), status.as_u16());
    span.record("route", route).record("status", status);
    let seconds = started.elapsed().as_secs_f64();
    let _entered = span.enter();
    if spans::is_probe(route) {
        tracing::debug!(target: "tabletopgen::access", seconds, "answered");
    } else {
        tracing::info!(target: "tabletopgen::access", seconds, "answered");
    }
}

fn is_plain(response: &Response) -> bool {
    let kind = response.headers().get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok());
    kind.is_some_and(|kind| kind.starts_with("text/plain"))
}

/// Counts and times requests by route.
async fn count(route: MatchedPath, request: Request, next: Next) -> Response {
    // Any word is a method; a label has a few values.
    let known = [Method::GET, Method::HEAD, Method::POST, Method::DELETE, Method::OPTIONS];
    let method = known.iter().find(|known| *known == request.method()).map_or("other", Method::as_str);
    let method = method.to_owned();
    let started = Instant::now();
    let response = next.run(request).await;
    let labels = [
        ("method", method),
        ("route", route.as_str().to_owned()),
        ("status", response.status().as_u16().to_string()),
    ];
    metrics::counter!("tabletopgen_http_requests_total", &labels).increment(1);
    metrics::histogram!("tabletopgen_http_request_seconds", &labels).record(started.elapsed().as_secs_f64());
    response
}
