//! `/scenes/{scene_id}/lineage`: what a scene was made from, by which operations, and what was made from it.

use axum::Json;
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::extract::{PathId, TenantApi};
use super::scenes::{find, latest_job};
use super::views::StageView;
use crate::problem::Problem;
use crate::schemas::edits::EditOperations;
use crate::schemas::values::{Id, Timestamp};
use crate::schemas::words::{SceneState, Verdict};
use scene::{Randomize, SceneId};
use store::scenes::{SceneFilter, SceneRow};

/// Largest number of ancestors that are listed, the nearest ones.
const MAX_ANCESTORS: u32 = 1000;

/// Largest number of children that are listed; `GET /scenes?parent=` has pages of all.
const MAX_CHILDREN: u32 = 200;

/// A scene between those that it was made from and those that were made from it.
#[derive(Serialize, JsonSchema)]
pub(super) struct Lineage {
    /// Oldest first, deleted scenes too; of a longer chain the nearest 1,000.
    ancestors: Vec<LineageEntry>,
    scene: LineageEntry,
    /// Newest first, at most 200; `GET /scenes` with `parent` has pages of all.
    children: Vec<LineageEntry>,
}

/// A scene and what made it.
#[derive(Serialize, JsonSchema)]
pub(super) struct LineageEntry {
    #[schemars(with = "Id")]
    id: SceneId,
    #[schemars(with = "Option<Id>")]
    parent: Option<SceneId>,
    #[schemars(with = "SceneState")]
    state: &'static str,
    #[schemars(with = "Option<Verdict>")]
    verdict: Option<String>,
    /// Of an edit; null for other scenes.
    #[schemars(with = "Option<EditOperations>")]
    operations: Option<Value>,
    /// Of a variant; null for other scenes.
    #[schemars(with = "Option<Randomize>")]
    randomize: Option<Value>,
    /// The instruction of an edit, or the text of the scene.
    text: Option<String>,
    created_at: Timestamp,
    /// Of the newest job of the scene that was asked for; `cached` says that a result was found.
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
            created_at: Timestamp::of_ms(scene.created_at_ms),
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
