//! `/catalog` and `/robots`: what requests can name, as it is compiled in.

use std::sync::LazyLock;

use axum::Json;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde_json::json;

use super::download::has_tag;
use super::extract::TenantApi;
use crate::app::catalog::{catalog, robots};
use crate::problem::Problem;
use store::Digest;

/// A document that stays the same as long as the program runs, and its tag.
struct FixedDocument {
    text: String,
    tag: String,
}

impl FixedDocument {
    fn new(document: &impl Serialize) -> Self {
        let text = json!(document).to_string();
        let tag = format!("\"{}\"", Digest::of(text.as_bytes()));
        Self { text, tag }
    }

    fn answer(&'static self, headers: &HeaderMap) -> Response {
        let mut fields = HeaderMap::new();
        fields.insert(header::CACHE_CONTROL, HeaderValue::from_static("private, no-cache"));
        fields.insert(header::ETAG, HeaderValue::from_static(&self.tag));
        if has_tag(headers, header::IF_NONE_MATCH, &self.tag) {
            return (StatusCode::NOT_MODIFIED, fields).into_response();
        }
        fields.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
        (fields, self.text.as_str()).into_response()
    }
}

/// `GET /catalog`.
pub async fn show(_: TenantApi, headers: HeaderMap) -> Response {
    static CATALOG: LazyLock<FixedDocument> = LazyLock::new(|| FixedDocument::new(&catalog()));
    CATALOG.answer(&headers)
}

/// `GET /robots`.
pub async fn list_robots(_: TenantApi) -> Result<Response, Problem> {
    Ok(Json(robots()?).into_response())
}
