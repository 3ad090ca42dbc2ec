//! Probes, metrics, version, contract.

use std::time::Duration;

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::Serialize;

use super::Api;
use super::download::served_as;
use super::studio;
use crate::app::metrics::process;
use crate::problem::{Problem, ProblemType};
use crate::schemas::datasets::OpenDocument;
use store::Outage;

/// The contract, as it lies in the repository.
pub const OPENAPI: &str = include_str!("../../openapi.yaml");

/// State of the process.
#[derive(Serialize, JsonSchema)]
pub(super) struct Status {
    status: ProbeStatus,
}

/// Result of a probe.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum ProbeStatus {
    Ok,
    Ready,
}

/// Version of the program.
#[derive(Serialize, JsonSchema)]
pub(super) struct Version {
    name: &'static str,
    version: &'static str,
    /// Whether the program has the page for people at `/studio/`.
    studio: bool,
}

/// A document by the OpenAPI Specification.
#[derive(JsonSchema)]
pub struct OpenApi {
    pub openapi: String,
    pub info: OpenDocument,
    pub paths: OpenDocument,
}

/// Time that a scrape waits for the database; the metrics of the process are answered without it.
const QUEUE_DEPTH_TIMEOUT: Duration = Duration::from_secs(2);

/// `GET /healthz`: the process answers.
pub async fn healthz() -> Response {
    Json(Status { status: ProbeStatus::Ok }).into_response()
}

/// `GET /readyz`: it takes new work.
pub async fn readyz(State(api): State<Api>) -> Result<Response, Problem> {
    if api.draining.is_cancelled() {
        return Err(Problem::new(ProblemType::Unavailable, "shutting_down", "the process is shutting down"));
    }
    api.store.is_healthy().await?;
    match *api.store.outage().borrow() {
        None => {}
        Some(Outage::Full) => return Err(Problem::storage_full()),
        Some(Outage::Other) => {
            let detail = "the database or the place of blobs takes no writes; the log says why";
            return Err(Problem::new(ProblemType::Unavailable, "store_unavailable", detail));
        }
    }
    Ok(Json(Status { status: ProbeStatus::Ready }).into_response())
}

/// `GET /metrics`: Prometheus text. The depth of the queue is read now, so that it is right without a worker too; where
/// the database does not answer it is not a number, and everything else is still said.
pub async fn metrics(State(api): State<Api>) -> Response {
    let depth = tokio::time::timeout(QUEUE_DEPTH_TIMEOUT, api.store.queue_depth()).await;
    let depth = depth.ok().and_then(Result::ok);
    metrics::gauge!("tabletopgen_store_readable").set(f64::from(u8::from(depth.is_some())));
    let count = |jobs: Option<i64>| jobs.map_or(f64::NAN, |jobs| jobs as f64);
    for (state, jobs) in [
        ("queued", depth.map(|depth| depth.queued)),
        ("running", depth.map(|depth| depth.running)),
        ("cancelling", depth.map(|depth| depth.cancelling)),
    ] {
        metrics::gauge!("tabletopgen_jobs", "state" => state).set(count(jobs));
    }
    let waited = depth.map_or(f64::NAN, |depth| depth.longest_wait.as_secs_f64());
    metrics::gauge!("tabletopgen_oldest_queued_job_seconds").set(waited);
    metrics::gauge!("tabletopgen_webhook_deliveries_waiting").set(count(depth.map(|depth| depth.deliveries)));
    let is_out = api.store.outage().borrow().is_some();
    metrics::gauge!("tabletopgen_store_outage").set(f64::from(u8::from(is_out)));
    metrics::gauge!("tabletopgen_body_memory_limit_bytes").set(api.settings.body_memory_bytes as f64);
    process::collect();
    api.metrics.run_upkeep();
    let kind = [(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")];
    (kind, api.metrics.render()).into_response()
}

/// `GET /version`.
pub async fn version() -> Response {
    let (name, version) = (env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION"));
    Json(Version { name, version, studio: studio::is_built() }).into_response()
}

/// `GET /openapi.yaml`.
pub async fn openapi(headers: HeaderMap) -> Response {
    ([(header::CONTENT_TYPE, served_as(&headers, "application/yaml").to_owned())], OPENAPI).into_response()
}
