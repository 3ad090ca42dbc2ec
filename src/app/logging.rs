//! The log: `tracing` events on standard error, as text or as JSON lines; panics are among them. Spans go to the
//! collector of traces where there is one ([`super::telemetry`]).

mod json_line;

use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{EnvFilter, Layer, Registry};

use super::telemetry::Traces;
use crate::config::{LogFormat, LogSettings};
use json_line::JsonLine;

/// The target of the lines of the access log, which `log.access` turns off.
pub const ACCESS: &str = "tabletopgen::access";

/// Starts the log of this process. A second start changes nothing.
pub fn start(settings: &LogSettings) {
    start_with_traces(settings, None);
}

/// The same, with spans for the collector.
pub fn start_with_traces(settings: &LogSettings, traces: Option<&Traces>) {
    let filter = EnvFilter::try_new(directives(settings)).unwrap_or_else(|_| EnvFilter::new("info"));
    let lines = tracing_subscriber::fmt::layer().with_writer(std::io::stderr);
    let lines: Box<dyn Layer<_> + Send + Sync> = match settings.format {
        LogFormat::Text => {
            lines.with_ansi(std::io::IsTerminal::is_terminal(&std::io::stderr())).with_filter(filter).boxed()
        }
        LogFormat::Json => lines.json().event_format(JsonLine).with_filter(filter).boxed(),
    };
    // The exporter lies on the registry itself: its spans carry its data by that type.
    let spans = traces.map(Traces::layer::<Registry>);
    // An error means that the log runs already.
    let _ = tracing_subscriber::registry().with(spans).with(lines).try_init();
    std::panic::set_hook(Box::new(|panic| {
        let at = panic.location().map(ToString::to_string).unwrap_or_default();
        let message = panic.payload_as_str().unwrap_or("no message");
        tracing::error!(at, message, "a panic; this is a bug");
    }));
}

/// The filter's directives. Those of `log.filter` for the access log win, as they come last.
fn directives(settings: &LogSettings) -> String {
    let access = if settings.access { "info" } else { "off" };
    match settings.filter.trim() {
        "" => format!("{ACCESS}={access}"),
        filter if settings.access => filter.to_owned(),
        filter => format!("{filter},{ACCESS}={access}"),
    }
}
