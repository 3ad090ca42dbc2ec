//! Spans of requests and jobs: what every line of the log and every trace says about the work at hand, and how spans of
//! several processes make one trace.
//!
//! The trace of a job has the id of the job (both are 128 bits), so that an attempt on any machine, also after a crash,
//! belongs to the same trace without a word between the processes. A request that submits a job has the trace that its
//! client states in `traceparent`, or one of its own, and a link to that of the job. Stages and calls are children of
//! the job's span. Without a collector (`telemetry.traces_endpoint`) the spans serve the log alone.
//!
//! A program that was built without the feature `otel` has the same spans, and they serve the log alone.
//!
//! Spans hold ids, routes and counts; never texts of users, keys, or the queries of URLs.

#[cfg(feature = "otel")]
mod traces;
#[cfg(not(feature = "otel"))]
mod no_traces;

use tracing::Span;
use tracing::field::Empty;

#[cfg(not(feature = "otel"))]
use no_traces as traces;
use scene::{JobId, SceneId};
use store::queue::{Claim, ClaimedWork};

/// Routes of orchestrators and scrapers: asked every few seconds, and worth a line or a span only to those who debug.
const PROBES: [&str; 4] = ["/healthz", "/readyz", "/metrics", "/version"];

/// Whether a path is that of a probe.
pub fn is_probe(path: &str) -> bool {
    PROBES.contains(&path)
}

/// The span of a request; `trace_parent` is the header `traceparent` of the client.
pub fn request(id: &str, method: &str, path: &str, trace_parent: Option<&str>) -> Span {
    if is_probe(path) {
        return tracing::debug_span!("request", request_id = id, method, path, route = Empty, status = Empty);
    }
    let span = tracing::info_span!(
        "request",
        otel.kind = "server",
        request_id = id,
        method,
        path,
        route = Empty,
        status = Empty,
        principal = Empty,
        tenant = Empty,
        scene_id = Empty,
        job_id = Empty,
    );
    if let Some(trace_parent) = trace_parent {
        traces::continue_trace(&span, trace_parent);
    }
    span
}

/// Notes in the present request's span which job it is about, and which scene, if any.
pub fn submitted(scene_id: Option<&SceneId>, job_id: &JobId) {
    let span = Span::current();
    span.record("scene_id", scene_id.map(SceneId::as_str)).record("job_id", job_id.as_str());
    traces::link_to_job(&span, job_id);
}

/// The span of an attempt at a job.
pub fn job(claim: &Claim) -> Span {
    let job_id = &claim.lease.job_id;
    let span = tracing::info_span!(
        parent: None,
        "job",
        otel.kind = "consumer",
        job_id = job_id.as_str(),
        scene_id = Empty,
        dataset_id = Empty,
        recording_id = Empty,
        epoch = claim.lease.epoch,
        attempt = claim.attempt,
        state = Empty,
    );
    match &claim.work {
        ClaimedWork::BuildScene(scene) => span.record("scene_id", scene.scene_id.as_str()),
        ClaimedWork::FreezeDataset(dataset) | ClaimedWork::VerifyDataset(dataset) => {
            span.record("dataset_id", dataset.id.as_str())
        }
        ClaimedWork::RecordAttempt(attempt) => span.record("recording_id", attempt.recording.id.as_str()),
        ClaimedWork::ExecuteTask(execution) => span.record("scene_id", execution.scene_id.as_str()),
        ClaimedWork::AssembleRecording(recording) => span.record("recording_id", recording.id.as_str()),
    };
    traces::join_trace_of_job(&span, job_id);
    span
}
