//! In place of traces in a program that was built without the feature `otel`: spans serve the log alone.

use tracing::Span;

use scene::JobId;

pub(super) fn continue_trace(_: &Span, _: &str) {}

pub(super) fn join_trace_of_job(_: &Span, _: &JobId) {}

pub(super) fn link_to_job(_: &Span, _: &JobId) {}
