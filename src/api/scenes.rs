//! `/scenes`: submit, list, show, change, delete.

use axum::Json;
use axum::extract::Request;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::deletion;
use super::enqueue::{SubmissionOptions, enqueue};
use super::extract::{JsonBody, JsonRequest, PathId, TenantApi};
use super::merge_patch::MergePatch;
use super::preconditions::{IfMatch, scene_tag, tag};
use super::query::{IdFilter, LabelFilter, NoParameters, Page, PageSize, PageToken, Parameters, Time};
use super::scene_body::SceneBody;
use super::views::{ArtifactView, JobView, SceneView, SpendingView, StageView};
use super::{jobs, scene_body};
use crate::app::scene_labels::{LabelsPatch, change_labels, present};
use crate::problem::Problem;
use crate::schemas::scene_request;
use crate::schemas::words;
use scene::text_account::TextAccount;
use scene::{SceneId, SceneRequest};
use store::lifecycle::SceneState;
use store::scenes::{SceneFilter, SceneRow};

/// `POST /scenes`.
pub async fn submit(
    api: TenantApi,
    _: Parameters<NoParameters>,
    options: SubmissionOptions,
    request: Request,
) -> Result<Response, Problem> {
    let (submission, _memory) = scene_body::receive(&api, request).await?;
    enqueue(&api, submission, options).await
}

/// `POST /scenes/validate`. JSON alone: clients in Python that openapi-python-client generates (0.29, its issue 1451)
/// do not load where an operation has bodies of two media types and no parameter.
pub async fn validate(
    api: TenantApi,
    _: Parameters<NoParameters>,
    JsonBody { value: body, memory }: JsonBody<SceneBody>,
) -> Result<Response, Problem> {
    let (submission, _memory) = scene_body::check(&api, body, None, memory).await?;
    let text = api.app.account(&submission.request).map_err(|error| Problem::invalid(vec![error]))?;
    Ok(Json(Validated { valid: true, request: submission.request, text }).into_response())
}

/// The request as it is understood.
#[derive(Serialize, JsonSchema)]
pub(super) struct Validated {
    #[schemars(extend("const" = true))]
    valid: bool,
    request: SceneRequest,
    /// The account of the text; null without a text, and where a remote model reads texts. Beside an image it is an
    /// account before the image is recognized.
    text: Option<TextAccount>,
}

/// Parameters of `GET /scenes`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ListParameters {
    /// Deleted scenes are listed only when asked for.
    #[schemars(with = "Option<words::SceneState>")]
    state: Option<SceneState>,
    label: Option<LabelFilter>,
    /// Only scenes made from this one.
    parent: Option<IdFilter>,
    created_after: Option<Time>,
    page_size: PageSize,
    page_token: Option<PageToken>,
}

/// `GET /scenes`.
pub async fn list(
    api: TenantApi,
    Parameters(parameters): Parameters<ListParameters>,
) -> Result<Response, Problem> {
    let size = parameters.page_size;
    let filter = SceneFilter {
        state: parameters.state,
        label: parameters.label.map(|label| (label.key, label.value)),
        parent: parameters.parent.and_then(IdFilter::id),
        created_after_ms: parameters.created_after.map(Time::as_ms),
        before_id: parameters.page_token.and_then(PageToken::last_id),
        limit: size.rows_to_read(),
    };
    let rows = api.store.scenes(&api.tenant_id, filter).await?;
    let Page { rows, next_page_token } = size.page_of(rows, |(scene, _)| PageToken::after(scene.id.as_str()));
    let (scenes, jobs): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
    let jobs = jobs::views(&api, jobs).await?;
    let page = ScenePage {
        scenes: scenes.into_iter().zip(jobs).map(|(scene, job)| SceneView::new(scene, job)).collect(),
        next_page_token,
    };
    Ok(Json(page).into_response())
}

/// A page of scenes.
#[derive(Serialize, JsonSchema)]
pub(super) struct ScenePage {
    scenes: Vec<SceneView>,
    /// Null on the last page.
    next_page_token: Option<String>,
}

/// `GET /scenes/{scene_id}`.
pub async fn show(api: TenantApi, PathId(scene_id): PathId<SceneId>) -> Result<Response, Problem> {
    let scene = find(&api, &scene_id).await?;
    whole(&api, scene).await
}

/// The body of a change.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ScenePatch {
    /// Labels to set, and with null labels to remove; null in place of all removes all.
    #[schemars(with = "Option<scene_request::LabelsPatch>")]
    labels: LabelsPatch,
}

impl JsonRequest for ScenePatch {
    type Schema = Self;
    const EXAMPLE: &str = r#"{"labels": {"split": "train", "draft": null}}"#;
}

/// `PATCH /scenes/{scene_id}`.
pub async fn change(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    if_match: IfMatch,
    MergePatch(patch): MergePatch<ScenePatch>,
) -> Result<Response, Problem> {
    let is_expected = |scene: &SceneRow| if_match.allows(&scene_tag(scene));
    let scene = change_labels(&api.store, &api.tenant_id, &scene_id, &patch.labels, is_expected).await?;
    whole(&api, scene).await
}

/// The answer with all about a scene, and its tag.
async fn whole(api: &TenantApi, scene: SceneRow) -> Result<Response, Problem> {
    let (scene_id, scene_tag) = (scene.id.clone(), scene_tag(&scene));
    let job = latest_job(api, &scene_id).await?;
    let stages = match &job {
        Some(job) => api.store.stages(&api.tenant_id, &job.id).await?,
        None => Vec::new(),
    };
    let artifacts = api.store.artifacts(&api.tenant_id, &scene_id).await?;
    let mut view = SceneView::new(scene, job);
    view.stages = Some(stages.into_iter().map(StageView::new).collect());
    let spending = api.store.spending(&api.tenant_id, &scene_id).await?;
    let calls = api.store.calls(&api.tenant_id, &scene_id).await?;
    view.spending = Some(SpendingView::new(spending, calls));
    view.artifacts = Some(artifacts.into_iter().map(|row| ArtifactView::new(&scene_id, row)).collect());
    let mut response = Json(view).into_response();
    tag(&mut response, &scene_tag);
    Ok(response)
}

/// `DELETE /scenes/{scene_id}`.
pub async fn remove(api: TenantApi, PathId(scene_id): PathId<SceneId>) -> Result<StatusCode, Problem> {
    deletion::answer(api.store.delete_scene(&api.tenant_id, &scene_id).await?, &scene_id)
}

/// A scene that is there.
pub(super) async fn find(api: &TenantApi, scene_id: &SceneId) -> Result<SceneRow, Problem> {
    present(&api.store, &api.tenant_id, scene_id).await
}

/// The newest job of a scene, as clients see it.
pub(super) async fn latest_job(api: &TenantApi, scene_id: &SceneId) -> Result<Option<JobView>, Problem> {
    let job = api.store.latest_job(&api.tenant_id, scene_id).await?;
    Ok(jobs::views(api, vec![job]).await?.pop().flatten())
}
