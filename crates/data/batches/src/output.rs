//! Results of requests, one JSON object per line.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::counts::RequestState;
use scene::request::MAX_SEED;

/// Result of one request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutputLine {
    /// `None` for a line whose name cannot be read.
    pub custom_id: Option<String>,
    pub scene_id: Option<String>,
    pub state: RequestState,
    /// `pass` or `quarantine`, once certified.
    pub verdict: Option<String>,
    /// Path of the bundle, relative to the folder of the batch.
    pub bundle: Option<String>,
    pub error: Option<OutputError>,
    /// Duration of the computation of all stages together, seconds. Stages that were found are not counted.
    pub stages_s: f64,
    /// Number of times that a worker began the request.
    pub attempts: u64,
    /// The request that asks for the same scene, for a duplicate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duplicate_of: Option<String>,
}

/// Reason why a request has no result, and the place of the cause.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "BatchResultError", description = "Reason why a request has no scene.")]
pub struct OutputError {
    /// Stable, `[a-z0-9_]+`.
    #[schemars(regex(pattern = "^[a-z0-9_]+$"))]
    pub code: String,
    /// A sentence with advice.
    pub message: String,
    /// Line of the body, or number of the request of a recipe, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = MAX_SEED))]
    pub line: Option<u64>,
    /// Column of the line in bytes, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = MAX_SEED))]
    pub column: Option<u64>,
    /// JSON pointer into the request.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pointer: Option<String>,
}

impl OutputError {
    pub fn new(code: &str, message: impl Into<String>) -> Self {
        Self { code: code.to_owned(), message: message.into(), ..Self::default() }
    }

    /// Returns the error with its line.
    pub fn on_line(self, line: u64) -> Self {
        Self { line: Some(line), ..self }
    }

    /// Returns the error with the JSON pointer of the value.
    pub fn at(self, pointer: impl Into<String>) -> Self {
        Self { pointer: Some(pointer.into()), ..self }
    }
}

impl OutputLine {
    /// A request that was not computed.
    pub fn not_computed(custom_id: Option<String>, state: RequestState, error: OutputError) -> Self {
        Self {
            custom_id,
            scene_id: None,
            state,
            verdict: None,
            bundle: None,
            error: Some(error),
            stages_s: 0.0,
            attempts: 0,
            duplicate_of: None,
        }
    }

    /// A request that asks for the same scene as an earlier one.
    pub fn duplicate(custom_id: String, first: &str, first_place: u64, place: u64) -> Self {
        let message = format!(
            "asks for the same scene as {first:?} on line {first_place}, which is made once; \
             give it another seed"
        );
        let error = OutputError::new("duplicate_request", message).on_line(place);
        Self {
            duplicate_of: Some(first.to_owned()),
            ..Self::not_computed(Some(custom_id), RequestState::Duplicate, error)
        }
    }

    /// Whether the line belongs to the file of errors: there is no bundle of the request.
    pub fn is_error(&self) -> bool {
        matches!(self.state, RequestState::Failed | RequestState::Cancelled | RequestState::Invalid)
    }

    /// The line as text, with its end.
    pub fn text(&self) -> String {
        // Neither keys that are no texts nor floats that are no numbers occur.
        let mut text = serde_json::to_string(self).unwrap_or_default();
        text.push('\n');
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_every_field_in_order() {
        let line = OutputLine {
            custom_id: Some("a".into()),
            scene_id: Some("s".into()),
            state: RequestState::Succeeded,
            verdict: Some("pass".into()),
            bundle: Some("a".into()),
            error: None,
            stages_s: 1.5,
            attempts: 1,
            duplicate_of: None,
        };
        assert_eq!(
            line.text(),
            "{\"custom_id\":\"a\",\"scene_id\":\"s\",\"state\":\"succeeded\",\"verdict\":\"pass\",\
             \"bundle\":\"a\",\"error\":null,\"stages_s\":1.5,\"attempts\":1}\n"
        );
        assert_eq!(serde_json::from_str::<OutputLine>(&line.text()).expect("reads"), line);
        assert!(!line.is_error());
    }

    #[test]
    fn an_error_states_its_place() {
        let error = OutputError::new("malformed_json", "expected value").on_line(517);
        let line = OutputLine::not_computed(None, RequestState::Invalid, error);
        assert!(line.is_error());
        assert!(
            line.text()
                .contains(r#""error":{"code":"malformed_json","message":"expected value","line":517}"#)
        );
    }

    #[test]
    fn a_duplicate_names_the_first_request_and_is_no_error() {
        let line = OutputLine::duplicate("b".into(), "a", 3, 9);
        assert!(!line.is_error());
        assert_eq!(line.duplicate_of.as_deref(), Some("a"));
        let message = line.error.expect("an error").message;
        assert!(message.contains("\"a\" on line 3"), "{message}");
    }
}
