//! Spans of requests and jobs: what every line of the log and every trace says about the work at hand, and how spans of
//! several processes make one trace.
//!
//! The trace of a job has the id of the job (both are 128 bits), so that an attempt on any machine, also after a crash,
//! belongs to the same trace without a word between the processes. A request that submits a job has the trace that its
//! client states in `traceparent`, or one of its own, and a link to that of the job. Stages and calls are children of
//! the job's span. Without a collector (`telemetry.traces_endpoint`) the spans serve the log alone.
//!
//! Spans hold ids, routes and counts; never texts of users, keys, or the queries of URLs.

use std::collections::HashMap;

use opentelemetry::Context;
use opentelemetry::propagation::TextMapPropagator;
use opentelemetry::trace::{SpanContext, SpanId, TraceContextExt, TraceFlags, TraceId, TraceState};
use opentelemetry_sdk::propagation::TraceContextPropagator;
use tracing::Span;
use tracing::field::Empty;
use tracing_opentelemetry::OpenTelemetrySpanExt;
use uuid::Uuid;

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
        scene_id = Empty,
        job_id = Empty,
    );
    if let Some(parent) = trace_parent.and_then(parent_of) {
        // Fails without a collector; the span then serves the log.
        let _ = span.set_parent(parent);
    }
    span
}

/// Notes in the present request's span which job it is about, and which scene, if any.
pub fn submitted(scene_id: Option<&SceneId>, job_id: &JobId) {
    let span = Span::current();
    span.record("scene_id", scene_id.map(SceneId::as_str)).record("job_id", job_id.as_str());
    if let Some(job) = trace_of(job_id) {
        span.add_link(job);
    }
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
    if let Some(job) = trace_of(job_id) {
        let _ = span.set_parent(Context::new().with_remote_span_context(job));
    }
    span
}

/// The trace of a job: its id, and the second half of it as the id of the span that all attempts have as their parent.
fn trace_of(job_id: &JobId) -> Option<SpanContext> {
    let id = Uuid::parse_str(job_id.as_str()).ok()?.as_u128();
    let span_id = SpanId::from(id as u64);
    let context =
        SpanContext::new(TraceId::from(id), span_id, TraceFlags::SAMPLED, true, TraceState::default());
    context.is_valid().then_some(context)
}

fn parent_of(trace_parent: &str) -> Option<Context> {
    let headers = HashMap::from([("traceparent".to_owned(), trace_parent.to_owned())]);
    let context = TraceContextPropagator::new().extract_with_context(&Context::new(), &headers);
    context.span().span_context().is_valid().then_some(context)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trace_of_a_job_has_its_id() {
        let job: JobId = "0197a4c2-7b1e-7000-8abc-0123456789ab".parse().expect("is an id");
        let context = trace_of(&job).expect("is a trace");
        assert_eq!(context.trace_id().to_string(), "0197a4c27b1e70008abc0123456789ab");
        assert_eq!(context.span_id().to_string(), "8abc0123456789ab");
        assert_eq!(trace_of(&"not_a_uuid".parse().expect("is an id")), None);
    }

    #[test]
    fn only_a_valid_trace_parent_counts() {
        let valid = parent_of("00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01").expect("is valid");
        assert_eq!(valid.span().span_context().trace_id().to_string(), "4bf92f3577b34da6a3ce929d0e0e4736");
        for invalid in ["", "00-0-0-01", "00-00000000000000000000000000000000-00f067aa0ba902b7-01", "x"] {
            assert!(parent_of(invalid).is_none(), "{invalid}");
        }
    }
}
