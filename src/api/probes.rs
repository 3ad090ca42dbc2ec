//! Probes, metrics, version, contract.

use axum::Json;
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use serde_json::json;

use super::Api;
use super::error::{Problem, ProblemType};
use store::Outage;

/// The contract, as it lies in the repository.
pub const OPENAPI: &str = include_str!("../../openapi.yaml");

/// `GET /healthz`: the process answers.
pub async fn healthz() -> Response {
    Json(json!({ "status": "ok" })).into_response()
}

/// `GET /readyz`: it takes new work.
pub async fn readyz(State(api): State<Api>) -> Result<Response, Problem> {
    if api.shutdown.is_cancelled() {
        return Err(Problem::new(ProblemType::Unavailable, "shutting_down", "the process is shutting down"));
    }
    api.store.is_healthy().await?;
    match *api.store.outage().borrow() {
        None => {}
        Some(Outage::Full) => return Err(Problem::storage_full()),
        Some(Outage::Other) => {
            let detail = "the data directory cannot be written; the log says why";
            return Err(Problem::new(ProblemType::Unavailable, "store_unavailable", detail));
        }
    }
    Ok(Json(json!({ "status": "ready" })).into_response())
}

/// `GET /metrics`: Prometheus text.
pub async fn metrics(State(api): State<Api>) -> Result<Response, Problem> {
    for (state, count) in api.store.job_counts().await? {
        metrics::gauge!("tabletopgen_jobs", "state" => state.as_str()).set(count as f64);
    }
    api.metrics.run_upkeep();
    let kind = [(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")];
    Ok((kind, api.metrics.render()).into_response())
}

/// `GET /version`.
pub async fn version() -> Response {
    Json(json!({ "name": env!("CARGO_PKG_NAME"), "version": env!("CARGO_PKG_VERSION") })).into_response()
}

/// `GET /openapi.yaml`.
pub async fn openapi() -> Response {
    ([(header::CONTENT_TYPE, "application/yaml")], OPENAPI).into_response()
}
