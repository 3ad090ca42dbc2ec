//! `/scenes/{scene_id}/artifacts`: the artifacts that each stage stored for inspection.

use axum::Json;
use axum::http::{HeaderMap, Method};
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::Serialize;

use super::download::{Content, Download, respond};
use super::extract::{PathId, PathName, TenantApi};
use super::rebuild::missing_bytes;
use super::scenes::find;
use super::views::ArtifactView;
use crate::problem::Problem;
use scene::SceneId;

/// The artifacts of a scene by name.
#[derive(Serialize, JsonSchema)]
pub(super) struct ArtifactList {
    artifacts: Vec<ArtifactView>,
}

/// `GET /scenes/{scene_id}/artifacts`.
pub async fn list(api: TenantApi, PathId(scene_id): PathId<SceneId>) -> Result<Response, Problem> {
    find(&api, &scene_id).await?;
    let rows = api.store.artifacts(&api.tenant_id, &scene_id).await?;
    let artifacts = rows.into_iter().map(|row| ArtifactView::new(&scene_id, row)).collect();
    Ok(Json(ArtifactList { artifacts }).into_response())
}

/// `GET /scenes/{scene_id}/artifacts/{*name}`.
pub async fn download(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    PathName(name): PathName,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    find(&api, &scene_id).await?;
    let artifact = api.store.artifact(&api.tenant_id, &scene_id, &name).await?;
    let file = artifact.ok_or_else(|| Problem::not_found("artifact", &name))?.file;
    let what = Download {
        digest: &file.digest,
        size: file.size,
        media_type: &file.media_type,
        file_name: None,
        content: Content::Stored,
    };
    match respond(&api, &method, &headers, what).await? {
        Some(response) => Ok(response),
        None => Err(missing_bytes(&api, &scene_id).await),
    }
}
