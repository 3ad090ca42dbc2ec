//! The metrics of a process: every name with its type, labels and meaning, and the recorder that gathers them.
//!
//! Code counts where an event occurs, with the macros of the crate `metrics` and the names of this table. A test
//! holds the table, `docs/operations.md`, the dashboard and the alerts against what a server exposes. Series whose
//! labels have a few known values exist from the start with the value 0: a rate over a series that appears with its
//! first failure would miss that failure.

pub mod process;

use std::sync::OnceLock;

use metrics::Recorder;
use metrics_exporter_prometheus::{Matcher, PrometheusBuilder, PrometheusHandle};

use store::lifecycle::FailureClass;
use store::limits::Limit;

/// A metric family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Metric {
    pub name: &'static str,
    pub kind: Kind,
    /// Names of its labels, sorted.
    pub labels: &'static [&'static str],
    pub help: &'static str,
}

/// The type of a metric in the text format of Prometheus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Counter,
    Gauge,
    Histogram,
}

impl Kind {
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Counter => "counter",
            Self::Gauge => "gauge",
            Self::Histogram => "histogram",
        }
    }
}

const fn counter(name: &'static str, labels: &'static [&'static str], help: &'static str) -> Metric {
    Metric { name, kind: Kind::Counter, labels, help }
}

const fn gauge(name: &'static str, labels: &'static [&'static str], help: &'static str) -> Metric {
    Metric { name, kind: Kind::Gauge, labels, help }
}

const fn histogram(name: &'static str, labels: &'static [&'static str], help: &'static str) -> Metric {
    Metric { name, kind: Kind::Histogram, labels, help }
}

/// Every metric, in the order of the table in `docs/operations.md`.
pub const METRICS: &[Metric] = &[
    gauge("tabletopgen_jobs", &["state"], "Jobs that have not ended, of all processes of the store"),
    gauge(
        "tabletopgen_oldest_queued_job_seconds",
        &[],
        "Time for which the longest waiting queued job could have been claimed; 0 without one",
    ),
    gauge("tabletopgen_store_readable", &[], "1 if the database answered this scrape, else 0"),
    gauge("tabletopgen_store_outage", &[], "1 while the store takes no writes of this process, else 0"),
    counter(
        "tabletopgen_scenes_submitted_total",
        &[],
        "Scenes created, repeats of an idempotency key excluded; without those of batches",
    ),
    counter(
        "tabletopgen_batches_submitted_total",
        &[],
        "Batches created, repeats of an idempotency key excluded",
    ),
    counter(
        "tabletopgen_limits_refused_total",
        &["limit"],
        "Requests for work that were refused as a limit of the tenant or of the queue leaves no room",
    ),
    counter("tabletopgen_jobs_finished_total", &["class", "outcome"], "Jobs that ended, by class of failure"),
    counter(
        "tabletopgen_job_attempts_total",
        &["state"],
        "Attempts at jobs, by the state they left the job in",
    ),
    histogram(
        "tabletopgen_job_attempt_seconds",
        &["state"],
        "Duration of attempts, from claim to recorded outcome",
    ),
    counter(
        "tabletopgen_claims_total",
        &["outcome"],
        "Queries for work in the queue: claimed, empty or failed",
    ),
    counter("tabletopgen_lease_losses_total", &[], "Leases that were lost while the worker was at the job"),
    gauge("tabletopgen_worker_slots", &["kind"], "Jobs that the process works on at most at the same time"),
    gauge("tabletopgen_worker_slots_used", &["kind"], "Jobs that the process works on"),
    counter(
        "tabletopgen_stages_total",
        &["outcome", "stage"],
        "Stages of instances: computed, found or failed",
    ),
    histogram("tabletopgen_stage_seconds", &["stage"], "Duration of computed stages, per instance"),
    histogram(
        "tabletopgen_store_write_seconds",
        &[],
        "Time of write transactions, waiting for their turn included",
    ),
    counter("tabletopgen_store_write_failures_total", &[], "Write transactions that failed"),
    counter(
        "tabletopgen_store_write_repeats_total",
        &[],
        "Write transactions that PostgreSQL made repeat: they collided with those of other processes",
    ),
    counter("tabletopgen_blob_read_bytes_total", &[], "Bytes of blobs read"),
    counter("tabletopgen_blob_written_bytes_total", &[], "Bytes of blobs written"),
    counter("tabletopgen_blob_failures_total", &["operation"], "Reads and writes of blobs that failed"),
    counter(
        "tabletopgen_blobs_damaged_total",
        &[],
        "Blobs whose bytes did not match their digest; they were set aside",
    ),
    counter("tabletopgen_http_requests_total", &["method", "route", "status"], "Requests answered"),
    histogram(
        "tabletopgen_http_request_seconds",
        &["method", "route", "status"],
        "Time from the header of a request to the header of its answer",
    ),
    counter(
        "tabletopgen_requests_refused_total",
        &["reason"],
        "Requests refused by a limit, by the limit's name",
    ),
    gauge("tabletopgen_connections", &[], "Connections open"),
    counter(
        "tabletopgen_connections_closed_total",
        &["reason"],
        "Connections closed by a limit, by the limit's name",
    ),
    gauge("tabletopgen_event_streams", &[], "Event streams open"),
    gauge("tabletopgen_body_memory_bytes", &[], "Memory that request bodies use"),
    gauge("tabletopgen_body_memory_limit_bytes", &[], "Memory that request bodies may use"),
    counter(
        "tabletopgen_provider_calls_total",
        &["operation", "outcome", "provider"],
        "Calls of remote models, every try counted",
    ),
    histogram("tabletopgen_provider_call_seconds", &["operation", "provider"], "Duration of a try of a call"),
    counter(
        "tabletopgen_provider_cost_micro_usd_total",
        &["operation", "provider"],
        "Cost of calls, millionths of a US dollar; the reservation where the price is not known",
    ),
    counter(
        "tabletopgen_webhook_attempts_total",
        &["outcome"],
        "Events sent to webhooks, every attempt counted: delivered, retried or failed for good",
    ),
    gauge(
        "tabletopgen_webhook_deliveries_waiting",
        &[],
        "Events that wait to be sent to webhooks, of all processes of the store",
    ),
    counter(
        "tabletopgen_span_exports_total",
        &["outcome"],
        "Batches of spans for the collector: sent or failed",
    ),
    gauge("tabletopgen_build_info", &["version"], "1, with the version of the program"),
    counter("process_cpu_seconds_total", &[], "Processor time of the process, whole seconds"),
    gauge("process_open_fds", &[], "Open file descriptors"),
    gauge("process_max_fds", &[], "Limit of open file descriptors"),
    gauge("process_resident_memory_bytes", &[], "Resident memory"),
    gauge("process_virtual_memory_bytes", &[], "Virtual memory"),
    gauge("process_start_time_seconds", &[], "Start of the process, seconds since 1970"),
    gauge("process_threads", &[], "Threads"),
];

/// Upper bounds of the buckets of durations, seconds: from a read of a row to a stage of ten minutes.
const BUCKETS_S: &[f64] =
    &[0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0, 60.0, 180.0, 600.0];

/// The recorder of metrics, of which a process has one.
pub fn recorder() -> PrometheusHandle {
    static RECORDER: OnceLock<PrometheusHandle> = OnceLock::new();
    RECORDER.get_or_init(install).clone()
}

fn install() -> PrometheusHandle {
    let builder = PrometheusBuilder::new();
    // Fails for no buckets, and there are some.
    let builder = builder
        .set_buckets_for_metric(Matcher::Suffix("_seconds".to_owned()), BUCKETS_S)
        .unwrap_or_else(|_| PrometheusBuilder::new());
    let recorder = builder.build_recorder();
    for metric in METRICS {
        let (name, help) = (metric.name.into(), metric.help.into());
        match metric.kind {
            Kind::Counter => recorder.describe_counter(name, None, help),
            Kind::Gauge => recorder.describe_gauge(name, None, help),
            Kind::Histogram => recorder.describe_histogram(name, None, help),
        }
    }
    let handle = recorder.handle();
    // A recorder that is installed already stays; `/metrics` is then empty.
    let _ = metrics::set_global_recorder(recorder);
    start_at_zero();
    process::collect();
    handle
}

/// Creates the series that should exist before anything happens.
fn start_at_zero() {
    for metric in METRICS.iter().filter(|metric| metric.labels.is_empty()) {
        match metric.kind {
            Kind::Counter if metric.name.starts_with("tabletopgen_") => {
                metrics::counter!(metric.name).increment(0);
            }
            Kind::Gauge if metric.name.starts_with("tabletopgen_") => {
                metrics::gauge!(metric.name).increment(0.0);
            }
            // The process is read when it is asked about; a histogram shows with its first value.
            _ => {}
        }
    }
    metrics::gauge!("tabletopgen_build_info", "version" => env!("CARGO_PKG_VERSION")).set(1.0);
    let finished = |outcome: &'static str, class: &'static str| {
        metrics::counter!("tabletopgen_jobs_finished_total", "outcome" => outcome, "class" => class)
            .increment(0);
    };
    finished("succeeded", "");
    finished("cancelled", "");
    for class in FailureClass::ALL {
        finished("failed", class.as_str());
    }
    for outcome in ["claimed", "empty", "failed"] {
        metrics::counter!("tabletopgen_claims_total", "outcome" => outcome).increment(0);
    }
    for reason in ["header_timeout", "keep_alive_timeout", "slow_reader", "gave_way"] {
        metrics::counter!("tabletopgen_connections_closed_total", "reason" => reason).increment(0);
    }
    for reason in [
        "overloaded",
        "host",
        "cross_site",
        "slow_body",
        "connections",
        "connections_per_address",
        "event_streams",
        "event_streams_per_address",
        "credential",
        "scope",
        "logins",
    ] {
        metrics::counter!("tabletopgen_requests_refused_total", "reason" => reason).increment(0);
    }
    for limit in Limit::OF_TENANT.into_iter().chain([Limit::AllWaitingScenes]) {
        metrics::counter!("tabletopgen_limits_refused_total", "limit" => limit.as_str()).increment(0);
    }
    for operation in ["read", "write"] {
        metrics::counter!("tabletopgen_blob_failures_total", "operation" => operation).increment(0);
    }
    for outcome in ["delivered", "retried", "failed"] {
        metrics::counter!("tabletopgen_webhook_attempts_total", "outcome" => outcome).increment(0);
    }
    for outcome in ["sent", "failed"] {
        metrics::counter!("tabletopgen_span_exports_total", "outcome" => outcome).increment(0);
    }
}

#[cfg(test)]
mod tests;
