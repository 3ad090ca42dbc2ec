//! `/catalog` and `/robots`: what requests can name, as it is compiled in.

use std::collections::BTreeMap;
use std::sync::{LazyLock, Mutex, PoisonError};

use axum::Json;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use serde::Serialize;
use serde_json::json;

use super::download::has_tag;
use super::extract::{PathName, TenantApi};
use crate::app::catalog::{catalog, robots};
use crate::app::robot_model::robot_glb;
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
        fixed(Bytes::from_static(self.text.as_bytes()), "application/json", &self.tag, headers)
    }
}

/// Content that stays the same as long as the program runs, unless the client has it by its tag.
fn fixed(content: Bytes, media_type: &'static str, tag: &str, headers: &HeaderMap) -> Response {
    let cache = [(header::CACHE_CONTROL, "private, no-cache"), (header::ETAG, tag)];
    if has_tag(headers, header::IF_NONE_MATCH, tag) {
        return (StatusCode::NOT_MODIFIED, cache).into_response();
    }
    (cache, [(header::CONTENT_TYPE, media_type)], content).into_response()
}

/// `GET /catalog`.
pub async fn show(_: TenantApi, headers: HeaderMap) -> Response {
    static CATALOG: LazyLock<FixedDocument> = LazyLock::new(|| FixedDocument::new(&catalog()));
    CATALOG.answer(&headers)
}

/// `GET /robots/{robot}/model`.
pub async fn robot_model(
    _: TenantApi,
    PathName(name): PathName,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    /// By the name of the robot, with its tag.
    static MODELS: LazyLock<Mutex<BTreeMap<String, (Bytes, String)>>> = LazyLock::new(Mutex::default);
    let known = MODELS.lock().unwrap_or_else(PoisonError::into_inner).get(&name).cloned();
    let (model, tag) = match known {
        Some(known) => known,
        None => {
            let model = robot_glb(&name).ok_or_else(|| Problem::not_found("robot", &name))?;
            let model = Bytes::from(model);
            let made = (model.clone(), format!("\"{}\"", Digest::of(&model)));
            MODELS.lock().unwrap_or_else(PoisonError::into_inner).insert(name, made.clone());
            made
        }
    };
    Ok(fixed(model, "model/gltf-binary", &tag, &headers))
}

/// `GET /robots`.
pub async fn list_robots(_: TenantApi) -> Result<Response, Problem> {
    Ok(Json(robots()?).into_response())
}
