//! Conditions of changes: `If-Match` with the `ETag` of what a client has read.

use std::convert::Infallible;

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use axum::http::{HeaderValue, header};
use axum::response::Response;
use serde_json::json;

use super::Api;
use super::contract::operation::{Describe, Operation};
use super::views::SceneView;
use store::Digest;
use store::scenes::SceneRow;

/// The `ETag` of a scene: the digest of its own fields, without its job, stages, artifacts and spending, which go on
/// while the scene stays as it is.
pub fn scene_tag(scene: &SceneRow) -> String {
    let fields = json!(SceneView::new(scene.clone(), None));
    format!("\"{}\"", Digest::of(fields.to_string().as_bytes()))
}

/// Gives a response the `ETag` of its scene. No cache keeps it, as its other parts change under the same tag.
pub fn tag(response: &mut Response, scene_tag: &str) {
    if let Ok(value) = HeaderValue::from_str(scene_tag) {
        response.headers_mut().insert(header::ETAG, value);
        response.headers_mut().insert(header::CACHE_CONTROL, HeaderValue::from_static("private, no-store"));
    }
}

/// The header `If-Match`.
pub struct IfMatch(Option<Vec<String>>);

impl IfMatch {
    /// Whether a change may be made to what has this strong tag. Weak tags match nothing (RFC 9110, section 13.1.1).
    pub fn allows(&self, tag: &str) -> bool {
        let Some(lists) = &self.0 else { return true };
        lists
            .iter()
            .flat_map(|list| list.split(','))
            .map(str::trim)
            .any(|wanted| wanted == "*" || wanted == tag)
    }
}

impl FromRequestParts<Api> for IfMatch {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &Api) -> Result<Self, Infallible> {
        let lists = parts.headers.get_all(header::IF_MATCH);
        if !parts.headers.contains_key(header::IF_MATCH) {
            return Ok(Self(None));
        }
        // A list that is no text has no tag of ours.
        Ok(Self(Some(lists.into_iter().filter_map(|list| list.to_str().ok()).map(str::to_owned).collect())))
    }
}

impl Describe for IfMatch {
    fn describe(operation: &mut Operation<'_>) {
        operation.header(
            "If-Match",
            "Changes it only if it still has this `ETag`.",
            &json!({ "type": "string" }),
        );
        operation.refuses(&[412]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_are_compared_strongly() {
        let list = |text: &str| IfMatch(Some(vec![text.to_owned()]));
        assert!(IfMatch(None).allows("\"a\""));
        for (text, is_allowed) in [
            ("*", true),
            ("\"a\"", true),
            ("\"b\", \"a\"", true),
            ("\"b\"", false),
            ("W/\"a\"", false),
            ("a", false),
            ("", false),
        ] {
            assert_eq!(list(text).allows("\"a\""), is_allowed, "{text}");
        }
        assert!(!IfMatch(Some(Vec::new())).allows("\"a\""));
    }
}
