//! JSON bodies as types: outlined first, then read straight into their type, large ones apart from the runtime.

use axum::body::Body;
use axum::http::{HeaderMap, header};
use serde::de::DeserializeOwned;
use serde_path_to_error::Segment;

use super::body::{BodyReader, ReceivedBody};
use super::body_memory::Reservation;
use super::error::{FieldError, Problem, ProblemType};
use super::json_detail::json_detail;
use super::{Api, json_outline};

/// Largest body of a request that names a few values.
const MAX_SMALL_BODY_BYTES: usize = 64 << 10;

/// JSON up to this size is parsed where it arrives: that takes less than handing it to another thread.
const MAX_PARSED_IN_PLACE_BYTES: usize = 16 << 10;

/// The media type without parameters, in lower case.
pub fn media_type(headers: &HeaderMap) -> String {
    let text = headers.get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok()).unwrap_or_default();
    text.split(';').next().unwrap_or_default().trim().to_ascii_lowercase()
}

/// The body of a request that names a few values.
///
/// # Errors
///
/// A [`Problem`] where it does not arrive within the limits.
pub async fn json_bytes(api: &Api, body: Body) -> Result<ReceivedBody, Problem> {
    BodyReader::of(api, body, MAX_SMALL_BODY_BYTES.min(api.settings.max_body_bytes)).collect().await
}

/// A typed value out of JSON.
///
/// # Errors
///
/// A [`Problem`] with the place where the bytes stop being JSON, or the value stops being a `T`.
pub fn parse<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Problem> {
    json_outline::check(bytes)?;
    serde_path_to_error::deserialize(&mut serde_json::Deserializer::from_slice(bytes))
        .map_err(|error| Problem::invalid(vec![field_error(&error)]))
}

/// Place at which a value stops being of its type, and the reason.
pub(super) fn field_error(error: &serde_path_to_error::Error<serde_json::Error>) -> FieldError {
    let mut pointer = String::new();
    for segment in error.path() {
        match segment {
            Segment::Seq { index } => pointer.push_str(&format!("/{index}")),
            Segment::Map { key } => pointer.push_str(&pointer_segment(key)),
            Segment::Enum { .. } | Segment::Unknown => {}
        }
    }
    FieldError::new(pointer, detail_of(error.inner()))
}

/// A name as a segment of a JSON pointer.
pub(super) fn pointer_segment(name: &str) -> String {
    let name: String = name.chars().take(200).collect();
    format!("/{}", name.replace('~', "~0").replace('/', "~1"))
}

/// The detail of an error of serde, of bounded length.
pub(super) fn detail_of(error: &serde_json::Error) -> String {
    json_detail(&error.to_string()).chars().take(300).collect()
}

/// [`parse`] on a thread that may block, where the body is large. The reservation covers the value.
///
/// # Errors
///
/// As [`parse`], and where memory is short.
pub async fn parse_apart<T: DeserializeOwned + Send + 'static>(
    api: &Api,
    body: ReceivedBody,
) -> Result<(T, Reservation), Problem> {
    let ReceivedBody { bytes, mut memory } = body;
    if bytes.len() <= MAX_PARSED_IN_PLACE_BYTES {
        return Ok((parse(&bytes)?, memory));
    }
    let size = bytes.len();
    memory.grow_to(2 * size)?;
    let permit = api.decoders.clone().acquire_owned().await.ok();
    let parsed = tokio::task::spawn_blocking(move || {
        let _permit = permit;
        parse(&bytes)
    });
    let parsed = parsed.await.unwrap_or_else(|_| {
        let detail = "a bug stopped the parser of the body; the log has the details under this request id";
        Err(Problem::new(ProblemType::Internal, "internal_error", detail))
    });
    memory.shrink_to(size);
    Ok((parsed?, memory))
}
