//! Numbers and texts that several requests or answers have.

use std::fmt;

use schemars::JsonSchema;
use serde::Serialize;

use super::in_place;

/// Name of a batch, for people.
#[derive(JsonSchema)]
pub struct BatchName(
    #[schemars(length(min = 1, max = 255), regex(pattern = r"^[^\x00-\x1F\x7F-\x9F]*$"))] pub String,
);

/// US dollars.
#[derive(JsonSchema)]
pub struct BatchBudget(#[schemars(range(min = 0.0, max = 10_000_000.0))] pub f64);

/// Description of the objects on the table; at least one letter or digit, and no control characters but tabs and line
/// ends.
#[derive(JsonSchema)]
pub struct SceneText(#[schemars(length(min = 1, max = 4000), regex(pattern = TEXT_PATTERN))] pub String);

/// Drawn and reported when absent.
#[derive(Default, JsonSchema)]
pub struct OptionalSeed(#[schemars(range(min = 0, max = MAX_INTEGER))] pub Option<u64>);

/// Orders the client's own jobs; 0 is usual, more is sooner. Waiting jobs overtake more urgent ones in the end.
#[derive(JsonSchema)]
pub struct Priority(#[schemars(range(min = -100, max = 100))] pub Option<i64>);

/// The job starts no earlier.
#[derive(JsonSchema)]
pub struct NotBefore(pub Option<Timestamp>);

/// The job fails if it has not ended by then; later than now and than `not_before`.
#[derive(JsonSchema)]
pub struct Deadline(pub Option<Timestamp>);

/// Edit also a scene whose certificate says quarantine.
#[derive(JsonSchema)]
#[schemars(extend("default" = false))]
pub struct AllowQuarantined(pub bool);

/// A file, byte for byte.
#[derive(JsonSchema)]
pub struct Bytes(#[schemars(extend("format" = "binary"))] pub String);

/// US dollars, whole millionths.
#[derive(JsonSchema)]
pub struct Usd(#[schemars(range(min = 0.0, max = 1_000_000_000.0))] pub f64);

/// Greatest integer that JavaScript numbers represent exactly.
pub const MAX_INTEGER: u64 = (1 << 53) - 1;

/// A text with a visible character and no control characters but tabs and line ends.
pub const TEXT_PATTERN: &str = r"^[^\x00-\x08\x0B\x0C\x0E-\x1F\x7F-\x9F]*[^\s\x00-\x1F\x7F-\x9F][^\x00-\x08\x0B\x0C\x0E-\x1F\x7F-\x9F]*$";

/// Id of a scene, a job, a batch, a dataset or a recording.
pub struct Id;

/// Path on this server.
pub struct Link;

/// Text in a path.
pub struct PathText;

/// Digest in hexadecimal digits.
pub struct Sha256;

/// Code of a failure.
pub struct Code;

/// Label of a scene, `key:value`.
pub struct Label;

/// Name of a tenant.
pub struct TenantName;

/// Id of a delivery to a webhook.
pub struct MessageId;

in_place! {
    Id { "type": "string", "format": "uuid" }
    Link { "type": "string", "format": "uri-reference" }
    PathText { "type": "string", "minLength": 1 }
    Sha256 { "type": "string", "pattern": "^[0-9a-f]{64}$" }
    Code { "type": "string", "pattern": "^[a-z0-9_]+$" }
    TenantName { "type": "string", "pattern": "^[A-Za-z0-9_-]{1,64}$" }
    MessageId { "type": "string", "pattern": "^msg_[0-9a-f-]{36}$" }
    Label { "type": "string", "pattern": LABEL_PATTERN }
}

/// A label, `key:value`.
pub const LABEL_PATTERN: &str = r"^[A-Za-z0-9_.-]{1,63}:[^\x00-\x1F\x7F-\x9F]{0,255}$";

/// RFC 3339 in UTC with milliseconds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(inline)]
pub struct Timestamp(#[schemars(extend("format" = "date-time"))] String);

impl Timestamp {
    /// The time so many milliseconds after the start of 1970.
    pub fn of_ms(ms: i64) -> Self {
        let time = jiff::Timestamp::from_millisecond(ms).unwrap_or_default();
        Self(time.strftime("%Y-%m-%dT%H:%M:%S%.3fZ").to_string())
    }
}

impl fmt::Display for Timestamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timestamp_formats_known_times() {
        let text = |ms| Timestamp::of_ms(ms).0;
        assert_eq!(text(0), "1970-01-01T00:00:00.000Z");
        assert_eq!(text(951_782_400_000), "2000-02-29T00:00:00.000Z");
        assert_eq!(text(1_763_722_805_042), "2025-11-21T11:00:05.042Z");
        assert_eq!(text(-1), "1969-12-31T23:59:59.999Z");
    }
}
