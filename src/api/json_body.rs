//! JSON bodies as types: outlined first, then read straight into their type, large ones apart from the runtime.

use axum::http::{HeaderMap, header};
use serde::de::DeserializeOwned;

use super::body::ReceivedBody;
use super::body_memory::Reservation;
use super::{Api, json_outline};
use crate::app::json_error::field_error;
use crate::problem::{Problem, ProblemType};
use scene::TenantId;

/// Largest body of a request that names a few values.
pub const MAX_SMALL_BODY_BYTES: usize = 64 << 10;

/// JSON up to this size is parsed where it arrives: that takes less than handing it to another thread.
const MAX_PARSED_IN_PLACE_BYTES: usize = 16 << 10;

/// The media type without parameters, in lower case.
pub fn media_type(headers: &HeaderMap) -> String {
    let text = headers.get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok()).unwrap_or_default();
    text.split(';').next().unwrap_or_default().trim().to_ascii_lowercase()
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

/// [`parse`] on a thread that may block, where the body is large. The reservation covers the value.
///
/// # Errors
///
/// As [`parse`], and where memory is short.
pub async fn parse_apart<T: DeserializeOwned + Send + 'static>(
    api: &Api,
    tenant_id: &TenantId,
    body: ReceivedBody,
) -> Result<(T, Reservation), Problem> {
    let ReceivedBody { bytes, mut memory } = body;
    if bytes.len() <= MAX_PARSED_IN_PLACE_BYTES {
        return Ok((parse(&bytes)?, memory));
    }
    let size = bytes.len();
    memory.grow_to(2 * size)?;
    let permit = api.decoders.of(tenant_id).await;
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

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::super::scene_body::SceneBody;
    use super::*;

    /// Every field of the body with a value of every JSON type.
    #[test]
    fn no_detail_of_a_refused_body_names_a_rust_type() {
        let values = [
            json!(null),
            json!(true),
            json!(-1),
            json!(1.5),
            json!(1e300),
            json!(u64::MAX),
            json!("x"),
            json!([]),
            json!([1, "a"]),
            json!([1, 2, 3, 4]),
            json!({}),
            json!({ "a": 1 }),
        ];
        let pointers = [
            "",
            "/text",
            "/image",
            "/image/base64",
            "/image/url",
            "/seed",
            "/labels",
            "/labels/k",
            "/options",
            "/options/table",
            "/options/table/shape",
            "/options/table/size_m",
            "/options/table/size_m/0",
            "/options/table/material",
            "/options/table/color",
            "/options/table/model",
            "/options/metric_anchor",
            "/options/metric_anchor/object",
            "/options/metric_anchor/width_m",
            "/options/max_objects",
            "/options/budget_usd",
            "/options/robot",
            "/options/clutter",
            "/options/clutter/density",
            "/options/set",
            "/options/set/k",
            "/unknown",
            "/options/unknown",
        ];
        let mut refused = 0;
        for pointer in pointers {
            for value in &values {
                let body = placed(pointer, value);
                let Err(problem) = parse::<SceneBody>(body.to_string().as_bytes()) else { continue };
                for error in problem.errors {
                    refused += 1;
                    let words: Vec<&str> =
                        error.detail.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').collect();
                    for rust in [
                        "u8", "u16", "u32", "u64", "usize", "i32", "i64", "f32", "f64", "struct", "enum",
                        "tuple", "variant", "map", "sequence", "unit", "array", "invalid", "DVec3",
                        "integer", "floating",
                    ] {
                        assert!(!words.contains(&rust), "{body}: {:?}", error.detail);
                    }
                    assert!(
                        error.detail.starts_with("must ") || error.detail.starts_with("is "),
                        "{body}: {}",
                        error.detail
                    );
                }
            }
        }
        assert!(refused > 100, "{refused}");
    }

    /// A body that is valid but for `value` at `pointer`.
    fn placed(pointer: &str, value: &Value) -> Value {
        let mut names: Vec<&str> = pointer.split('/').skip(1).collect();
        let mut value = value.clone();
        while let Some(name) = names.pop() {
            value = match name {
                "0" => json!([value, 1.0, 0.7]),
                "object" => json!({ "object": value, "width_m": 0.1 }),
                "width_m" => json!({ "object": "mug", "width_m": value }),
                _ => json!({ name: value }),
            };
        }
        value
    }
}
