//! `/scenes/{scene_id}/preview`: a small image of a finished scene, for lists of scenes.
//!
//! It is made from the render of the bundle when it is first asked for, and kept beside the archives of the bundle, as
//! those of one format are: it goes with them, and a scene that is built again gets another.

use std::borrow::Cow;

use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::response::Response;
use bytes::Bytes;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;

use super::bundle::{Archive, keep, kept, unreadable};
use super::download::{Content, Download, respond};
use super::extract::{PathId, TenantApi};
use super::files;
use super::query::Parameters;
use super::scenes::find;
use crate::problem::Problem;
use imaging::codec::{decode_png, encode_thumbnail};
use scene::SceneId;

/// The render that a preview is made from.
const SOURCE: &str = "preview/hero.png";

/// Browsers show a preview this long without asking: bytes of a finished scene change only if it is built again.
const LIFETIME: &str = "private, max-age=600";

/// Parameters of `GET /scenes/{scene_id}/preview`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PreviewParameters {
    width: PreviewWidth,
}

/// Width of a preview, pixels.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(try_from = "String")]
struct PreviewWidth(u32);

impl Default for PreviewWidth {
    fn default() -> Self {
        Self(320)
    }
}

impl TryFrom<String> for PreviewWidth {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let width = text.parse().ok().filter(|width| [160, 320, 640].contains(width));
        width.map(Self).ok_or("must be 160, 320 or 640")
    }
}

impl JsonSchema for PreviewWidth {
    fn schema_name() -> Cow<'static, str> {
        "PreviewWidth".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Width of an image, pixels; the height follows.",
            "type": "integer",
            "enum": [160, 320, 640],
            "minimum": 160,
            "maximum": 640,
            "default": 320,
        })
    }
}

/// `GET /scenes/{scene_id}/preview`.
pub async fn show(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    Parameters(PreviewParameters { width: PreviewWidth(width) }): Parameters<PreviewParameters>,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    find(&api, &scene_id).await?;
    let form = format!("preview-{width}");
    // A damaged preview is gone once it was found damaged; the second time it is made again.
    for _ in 0..2 {
        let Archive { row, unstored } = match kept(&api, &scene_id, &form).await? {
            Some(archive) => archive,
            None => keep(&api, &scene_id, &form, made(&api, &scene_id, width).await?).await?,
        };
        let what = Download {
            digest: &row.digest,
            size: row.size,
            media_type: "image/jpeg",
            file_name: None,
            content: unstored.map_or(Content::Stored, Content::Memory),
        };
        if let Some(mut response) = respond(&api, &method, &headers, what).await? {
            // An address of the bucket does not last as long.
            if response.status() == StatusCode::TEMPORARY_REDIRECT {
                return Ok(response);
            }
            let lifetime = HeaderValue::from_static(LIFETIME);
            response.headers_mut().insert(header::CACHE_CONTROL, lifetime);
            return Ok(response);
        }
    }
    Err(unreadable())
}

/// A preview out of the bundle.
async fn made(api: &TenantApi, scene_id: &SceneId, width_px: u32) -> Result<Bytes, Problem> {
    let rows = api.store.bundle_files(&api.tenant_id, scene_id).await?;
    let source = rows.into_iter().find(|file| file.name == SOURCE);
    let source = source.ok_or_else(|| Problem::not_found("preview of the scene", scene_id.as_str()))?;
    let render = files::bytes_of(api, scene_id, &source).await?;
    let small = tokio::task::spawn_blocking(move || {
        decode_png(&render).map(|image| Bytes::from(encode_thumbnail(&image, width_px)))
    });
    small.await.ok().and_then(Result::ok).ok_or_else(unreadable)
}
