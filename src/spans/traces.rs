//! Parents and links of spans, so that those of several processes make one trace.

use std::collections::HashMap;

use opentelemetry::Context;
use opentelemetry::propagation::TextMapPropagator;
use opentelemetry::trace::{SpanContext, SpanId, TraceContextExt, TraceFlags, TraceId, TraceState};
use opentelemetry_sdk::propagation::TraceContextPropagator;
use tracing::Span;
use tracing_opentelemetry::OpenTelemetrySpanExt;
use uuid::Uuid;

use scene::JobId;

/// Makes a span a child of the one that a header `traceparent` states.
pub(super) fn continue_trace(span: &Span, trace_parent: &str) {
    if let Some(parent) = parent_of(trace_parent) {
        // Fails without a collector; the span then serves the log.
        let _ = span.set_parent(parent);
    }
}

/// Makes a span part of the trace of a job.
pub(super) fn join_trace_of_job(span: &Span, job_id: &JobId) {
    if let Some(job) = trace_of(job_id) {
        let _ = span.set_parent(Context::new().with_remote_span_context(job));
    }
}

/// Links a span to the trace of a job.
pub(super) fn link_to_job(span: &Span, job_id: &JobId) {
    if let Some(job) = trace_of(job_id) {
        span.add_link(job);
    }
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
