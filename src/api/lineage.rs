//! `/scenes/{scene_id}/lineage`: what a scene was made from, by which operations, and what was made from it.

use axum::Json;
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde_json::Value;

use super::extract::{PathId, TenantApi};
use super::scenes::{find, latest_job};
use super::views::{StageView, timestamp};
use crate::problem::Problem;
use scene::SceneId;
use store::scenes::{SceneFilter, SceneRow};

/// Largest number of ancestors that are listed, the nearest ones.
const MAX_ANCESTORS: u32 = 1000;

/// Largest number of children that are listed; `GET /scenes?parent=` has pages of all.
const MAX_CHILDREN: u32 = 200;

/// The lineage of a scene.
#[derive(Serialize)]
struct Lineage {
    /// Oldest first.
    ancestors: Vec<LineageEntry>,
    scene: LineageEntry,
    /// Newest first.
    children: Vec<LineageEntry>,
}

/// A scene and what made it.
#[derive(Serialize)]
struct LineageEntry {
    id: SceneId,
    parent: Option<SceneId>,
    state: &'static str,
    verdict: Option<String>,
    /// Of an edit.
    operations: Option<Value>,
    /// Of a variant.
    randomize: Option<Value>,
    /// The instruction of an edit, or what describes the scene.
    text: Option<String>,
    created_at: String,
    /// Of its newest job, with which of them were found; only of the scene that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    stages: Option<Vec<StageView>>,
}

impl LineageEntry {
    fn new(scene: SceneRow) -> Self {
        let input = &scene.request["input"];
        Self {
            operations: input.get("operations").cloned(),
            randomize: input.get("randomize").cloned(),
            text: input["text"].as_str().map(str::to_owned),
            id: scene.id,
            parent: scene.parent_id,
            state: scene.state.as_str(),
            verdict: scene.verdict,
            created_at: timestamp(scene.created_at_ms),
            stages: None,
        }
    }
}

/// `GET /scenes/{scene_id}/lineage`.
pub async fn show(api: TenantApi, PathId(scene_id): PathId<SceneId>) -> Result<Response, Problem> {
    let scene = find(&api, &scene_id).await?;
    let ancestors = api.store.ancestors(&api.tenant_id, &scene_id, MAX_ANCESTORS).await?;
    let children =
        SceneFilter { parent: Some(scene_id.clone()), limit: MAX_CHILDREN, ..SceneFilter::default() };
    let children = api.store.scenes(&api.tenant_id, children).await?;
    let stages = match latest_job(&api, &scene_id).await? {
        Some(job) => api.store.stages(&api.tenant_id, &job.id).await?,
        None => Vec::new(),
    };
    let stages = Some(stages.into_iter().map(StageView::new).collect());
    let lineage = Lineage {
        ancestors: ancestors.into_iter().map(LineageEntry::new).collect(),
        scene: LineageEntry { stages, ..LineageEntry::new(scene) },
        children: children.into_iter().map(|(scene, _)| LineageEntry::new(scene)).collect(),
    };
    Ok(Json(lineage).into_response())
}
