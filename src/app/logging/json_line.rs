//! A line of the log as one JSON object: time, level and target, the fields of the spans around the event (ids of
//! request, scene and job among them), and the event's own fields. The innermost wins where names meet.

use std::fmt;

use jiff::Timestamp;
use serde_json::{Map, Value};
use tracing::field::{Field, Visit};
use tracing::{Event, Subscriber};
use tracing_subscriber::fmt::format::{JsonFields, Writer};
use tracing_subscriber::fmt::{FmtContext, FormatEvent, FormattedFields};
use tracing_subscriber::registry::LookupSpan;

/// Formats events; spans keep their fields as JSON.
pub(super) struct JsonLine;

impl<S> FormatEvent<S, JsonFields> for JsonLine
where
    S: Subscriber + for<'a> LookupSpan<'a>,
{
    fn format_event(
        &self,
        context: &FmtContext<'_, S, JsonFields>,
        mut writer: Writer<'_>,
        event: &Event<'_>,
    ) -> fmt::Result {
        let metadata = event.metadata();
        let own: [(&str, Value); 3] = [
            ("timestamp", format!("{:.6}", Timestamp::now()).into()),
            ("level", metadata.level().as_str().into()),
            ("target", metadata.target().into()),
        ];
        let mut line: Map<String, Value> =
            own.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
        let mut names = Vec::new();
        for span in context.event_scope().into_iter().flat_map(|scope| scope.from_root()) {
            names.push(span.name());
            let extensions = span.extensions();
            let Some(fields) = extensions.get::<FormattedFields<JsonFields>>() else { continue };
            let Ok(Value::Object(fields)) = serde_json::from_str(&fields.fields) else { continue };
            line.extend(fields.into_iter().filter(|(name, _)| !name.starts_with("otel.")));
        }
        event.record(&mut FieldVisitor(&mut line));
        // These names belong to the line; a field of the same name would hide the time or the level.
        line.extend(own.map(|(name, value)| (name.to_owned(), value)));
        if !names.is_empty() {
            line.insert("span".to_owned(), names.join("/").into());
        }
        writeln!(writer, "{}", Value::Object(line))
    }
}

/// Writes fields into an object.
struct FieldVisitor<'a>(&'a mut Map<String, Value>);

impl FieldVisitor<'_> {
    fn insert(&mut self, field: &Field, value: Value) {
        self.0.insert(field.name().to_owned(), value);
    }
}

impl Visit for FieldVisitor<'_> {
    fn record_f64(&mut self, field: &Field, value: f64) {
        self.insert(field, value.into());
    }

    fn record_i64(&mut self, field: &Field, value: i64) {
        self.insert(field, value.into());
    }

    fn record_u64(&mut self, field: &Field, value: u64) {
        self.insert(field, value.into());
    }

    fn record_bool(&mut self, field: &Field, value: bool) {
        self.insert(field, value.into());
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        self.insert(field, value.into());
    }

    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        self.insert(field, format!("{value:?}").into());
    }
}

#[cfg(test)]
mod tests {
    use std::io;
    use std::sync::{Arc, Mutex};

    use super::*;
    use tracing::field::Empty;
    use tracing_subscriber::layer::SubscriberExt;

    /// Standard error of a test.
    #[derive(Clone, Default)]
    struct Lines(Arc<Mutex<Vec<u8>>>);

    impl io::Write for Lines {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().expect("no test panics while it holds this lock").extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn ids_of_all_spans_stand_beside_the_message() {
        let lines = Lines::default();
        let sink = lines.clone();
        let layer =
            tracing_subscriber::fmt::layer().with_writer(move || sink.clone()).json().event_format(JsonLine);
        tracing::subscriber::with_default(tracing_subscriber::registry().with(layer), || {
            let job =
                tracing::info_span!("job", otel.kind = "consumer", job_id = "j1", epoch = 2, state = Empty);
            let _in_job = job.enter();
            let _in_stage = tracing::info_span!("stage", stage = "rotate").entered();
            job.record("state", "failed");
            tracing::warn!(code = "too_large", level = "not this", seconds = 0.5, "a \"quoted\" message");
        });
        let written = lines.0.lock().expect("no test panics while it holds this lock").clone();
        let line: Value = serde_json::from_slice(&written).expect("is one JSON object");
        for (name, value) in [
            ("job_id", Value::from("j1")),
            ("epoch", 2.into()),
            ("state", "failed".into()),
            ("stage", "rotate".into()),
            ("code", "too_large".into()),
            ("seconds", 0.5.into()),
            ("message", "a \"quoted\" message".into()),
            ("level", "WARN".into()),
            ("span", "job/stage".into()),
        ] {
            assert_eq!(line[name], value, "{name} in {line}");
        }
        assert!(line["timestamp"].as_str().is_some_and(|time| time.ends_with('Z')), "{line}");
        assert!(line.get("otel.kind").is_none(), "{line}");
        assert_eq!(written.iter().filter(|byte| **byte == b'\n').count(), 1);
    }
}
