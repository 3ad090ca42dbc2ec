//! The exporter of spans: batches by OTLP through the one client for everything outbound.

use std::fmt;
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use opentelemetry::KeyValue;
use opentelemetry::trace::TracerProvider;
use opentelemetry_http::{Bytes, HttpError, Request, Response};
use opentelemetry_otlp::{SpanExporter, WithExportConfig, WithHttpConfig};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::trace::{BatchConfigBuilder, BatchSpanProcessor, Sampler, SdkTracerProvider};
use tracing::{Level, Subscriber};
use tracing_subscriber::Layer;
use tracing_subscriber::filter::filter_fn;
use tracing_subscriber::registry::LookupSpan;

use super::TelemetryError;
use crate::config::TelemetrySettings;
use http_client::{AddressPolicy, HttpClient, HttpRequest, Method};

/// The largest answer of a collector that is read.
const MAX_ANSWER_BYTES: usize = 64 << 10;

/// The spans on their way to the collector. Dropping it sends those that wait.
pub struct Traces {
    provider: SdkTracerProvider,
}

impl Traces {
    /// Starts to send spans; `None` where no endpoint is set.
    ///
    /// # Errors
    ///
    /// The endpoint is no URL that the client accepts.
    pub fn start(settings: &TelemetrySettings) -> Result<Option<Self>, TelemetryError> {
        let endpoint = settings.traces_endpoint.trim();
        if endpoint.is_empty() {
            return Ok(None);
        }
        let unusable = |reason: String| TelemetryError::Endpoint { host: host(endpoint).to_owned(), reason };
        let timeout = Duration::from_secs(settings.timeout_secs);
        let policy = AddressPolicy::new(true, authority(endpoint));
        policy.check(endpoint).map_err(|error| unusable(error.to_string()))?;
        let client = HttpClient::new(policy, timeout).map_err(|error| unusable(error.to_string()))?;
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .thread_name("span-export")
            .enable_all()
            .build()
            .map_err(|error| unusable(error.to_string()))?;
        let sender = SpanSender { client, runtime, timeout, is_failing: AtomicBool::new(false) };
        let exporter = SpanExporter::builder()
            .with_http()
            .with_http_client(sender)
            .with_endpoint(endpoint)
            .with_timeout(timeout)
            .build()
            .map_err(|error| unusable(error.to_string()))?;
        let batches = BatchConfigBuilder::default().with_max_queue_size(settings.max_queue_spans).build();
        let processor = BatchSpanProcessor::builder(exporter).with_batch_config(batches).build();
        let resource = Resource::builder()
            .with_service_name("tabletopgen")
            .with_attribute(KeyValue::new("service.version", env!("CARGO_PKG_VERSION")))
            .build();
        let provider = SdkTracerProvider::builder()
            // By the id of the trace alone: all spans of a job are kept or none, on every machine.
            .with_sampler(Sampler::TraceIdRatioBased(settings.sample_ratio))
            .with_resource(resource)
            .with_span_processor(processor)
            .build();
        Ok(Some(Self { provider }))
    }

    /// The layer that hands this program's spans to the exporter. Events stay in the log.
    pub fn layer<S>(&self) -> impl Layer<S> + Send + Sync + use<S>
    where
        S: Subscriber + for<'a> LookupSpan<'a> + Send + Sync,
    {
        tracing_opentelemetry::layer()
            .with_tracer(self.provider.tracer("tabletopgen"))
            // A span starts when it is first needed, so that a request can learn whose child it is.
            .with_context_activation(false)
            .with_location(false)
            .with_threads(false)
            .with_target(false)
            .with_tracked_inactivity(false)
            .with_filter(filter_fn(|metadata| {
                // Spans for debugging are those of probes.
                metadata.is_span() && *metadata.level() <= Level::INFO && is_own(metadata.target())
            }))
    }
}

impl Drop for Traces {
    fn drop(&mut self) {
        // What cannot be sent has been logged.
        let _ = self.provider.shutdown();
    }
}

/// Whether a target is a module of this workspace, and not of the client that sends the spans.
fn is_own(target: &str) -> bool {
    ["tabletopgen", "remote"]
        .iter()
        .any(|own| target.strip_prefix(own).is_some_and(|rest| rest.is_empty() || rest.starts_with("::")))
}

/// Sends batches through the outbound client, from the thread of the exporter.
struct SpanSender {
    client: HttpClient,
    runtime: tokio::runtime::Runtime,
    timeout: Duration,
    is_failing: AtomicBool,
}

impl fmt::Debug for SpanSender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("SpanSender")
    }
}

/// The future that [`opentelemetry_http::HttpClient`] wants.
type SendFuture<'a> = Pin<Box<dyn Future<Output = Result<Response<Bytes>, HttpError>> + Send + 'a>>;

impl opentelemetry_http::HttpClient for SpanSender {
    fn send_bytes<'own, 'sent>(&'own self, request: Request<Bytes>) -> SendFuture<'sent>
    where
        'own: 'sent,
        Self: 'sent,
    {
        Box::pin(async move {
            let sent = self.send(request);
            let failure = match &sent {
                Ok(answer) if answer.status().is_success() => None,
                Ok(answer) => Some(format!("it answered with status {}", answer.status())),
                Err(error) => Some(error.to_string()),
            };
            let outcome = if failure.is_some() { "failed" } else { "sent" };
            metrics::counter!("tabletopgen_span_exports_total", "outcome" => outcome).increment(1);
            let was_failing = self.is_failing.swap(failure.is_some(), Ordering::Relaxed);
            match failure {
                Some(reason) if !was_failing => {
                    tracing::warn!(
                        reason,
                        "the collector of traces takes no spans; those that do not fit are dropped"
                    );
                }
                None if was_failing => tracing::info!("the collector of traces takes spans again"),
                _ => {}
            }
            sent
        })
    }
}

impl SpanSender {
    /// Blocks; the thread of the exporter has nothing else to do.
    fn send(&self, request: Request<Bytes>) -> Result<Response<Bytes>, HttpError> {
        let (parts, body) = request.into_parts();
        let header = |name: &str| parts.headers.get(name).and_then(|value| value.to_str().ok());
        let content_type = header("content-type").unwrap_or("application/x-protobuf").to_owned();
        let headers = parts.headers.iter().filter(|(name, _)| name.as_str() != "content-type");
        let headers =
            headers.filter_map(|(name, value)| Some((name.to_string(), value.to_str().ok()?.to_owned())));
        let outgoing = HttpRequest {
            method: Method::POST,
            url: parts.uri.to_string(),
            headers: Vec::new(),
            transient_headers: headers.collect(),
            bearer: None,
            content_type: content_type.into(),
            body,
        };
        let sending = self.client.send(&outgoing, MAX_ANSWER_BYTES);
        let answer = self.runtime.block_on(async { tokio::time::timeout(self.timeout, sending).await })??;
        Ok(Response::builder().status(answer.status).body(answer.body)?)
    }
}

/// `host:port` of a URL, as far as it is there.
fn authority(url: &str) -> &str {
    url.split_once("://").map_or("", |(_, rest)| rest.split(['/', '?', '#']).next().unwrap_or(""))
}

/// The part of a URL that holds no secret.
fn host(url: &str) -> &str {
    authority(url).rsplit('@').next().unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endpoint_is_checked_at_start_and_its_secrets_are_not_repeated() {
        let mut settings = TelemetrySettings {
            traces_endpoint: String::new(),
            sample_ratio: 1.0,
            max_queue_spans: 16,
            timeout_secs: 1,
        };
        assert!(Traces::start(&settings).expect("is off").is_none());
        for unusable in
            ["collector:4318", "ftp://collector/v1/traces?token=s3cret", "https://me:s3cret@collector/"]
        {
            settings.traces_endpoint = unusable.to_owned();
            let Err(error) = Traces::start(&settings) else { panic!("{unusable} is accepted") };
            let error = error.to_string();
            assert!(error.contains("telemetry.traces_endpoint"), "{error}");
            assert!(!error.contains("s3cret"), "{error}");
        }
    }

    #[test]
    fn only_spans_of_this_program_are_sent() {
        for (target, own) in [
            ("tabletopgen::spans", true),
            ("remote::endpoint", true),
            ("remote", true),
            ("remotely", false),
            ("hyper::client", false),
            ("opentelemetry_sdk", false),
        ] {
            assert_eq!(is_own(target), own, "{target}");
        }
    }
}
