//! Traces: the spans of requests, jobs, stages and calls, sent by OTLP (HTTP, protobuf) to the operator's collector.
//!
//! Off unless `telemetry.traces_endpoint` is set. Spans wait in a queue of bounded length and are sent in batches by a
//! thread of their own. A collector that does not answer costs a line in the log and the spans beyond the queue, never
//! a request or a job. Batches go through the one client for everything outbound, which may reach only the endpoint.
//! `OTEL_EXPORTER_OTLP_HEADERS` (authentication) and `OTEL_RESOURCE_ATTRIBUTES` are read from the environment, as the
//! specification of OpenTelemetry says. A program that was built without the feature `otel` sends none.

#[cfg(feature = "otel")]
mod exporter;
#[cfg(not(feature = "otel"))]
mod no_exporter;

use super::logging;
use crate::config::Config;
#[cfg(feature = "otel")]
pub use exporter::Traces;
#[cfg(not(feature = "otel"))]
pub use no_exporter::Traces;

/// Reason why spans cannot be sent.
#[derive(Debug, thiserror::Error)]
pub enum TelemetryError {
    #[error(
        "telemetry.traces_endpoint (host {host:?}) cannot be used: {reason}; give a URL such as \
             http://collector:4318/v1/traces"
    )]
    Endpoint { host: String, reason: String },
    #[error(
        "telemetry.traces_endpoint names a collector of traces, and this program was built without it; build with \
         `--features otel`"
    )]
    NotBuilt,
}

/// Starts the log and the traces of a process; the result is kept to its end.
///
/// # Errors
///
/// `telemetry.traces_endpoint` is no URL that the client accepts, or the program was built without traces.
pub fn start(config: &Config) -> Result<Option<Traces>, TelemetryError> {
    let traces = Traces::start(&config.telemetry)?;
    logging::start_with_traces(&config.log, traces.as_ref());
    Ok(traces)
}
