//! `/scenes`: submit, list, count, show, change, delete.

use axum::Json;
use axum::extract::Request;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};

use super::deletion;
use super::enqueue::{SubmissionOptions, enqueue};
use super::extract::{JsonBody, JsonRequest, PathId, TenantApi};
use super::merge_patch::MergePatch;
use super::preconditions::{IfMatch, scene_tag, tag};
use super::query::{
    CategoryFilter, IdFilter, LabelFilter, NoParameters, ObjectCount, Page, PageSize, PageToken, Parameters,
    TextFilter, Time,
};
use super::scene_body::{Files, SceneBody};
use super::views::{ArtifactView, JobView, SceneView, SpendingView, StageView};
use super::{jobs, scene_body};
use crate::app::scene_labels::{LabelsPatch, change_labels, present};
use crate::problem::Problem;
use crate::schemas::in_place;
use crate::schemas::scene_request::{self, InputKind};
use crate::schemas::words::{self, Verdict};
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
    let (submission, _memory) = scene_body::check(&api, body, Files::default(), memory).await?;
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

/// Parameters that filter scenes, and others.
macro_rules! scene_filters {
    ($(#[$doc:meta])* $name:ident { $($field:ident: $kind:ty,)* }) => {
        $(#[$doc])*
        #[derive(Default, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct $name {
            /// Deleted scenes only where they are asked for.
            #[schemars(with = "Option<words::SceneState>")]
            state: Option<SceneState>,
            verdict: Option<Verdict>,
            kind: Option<InputKind>,
            /// Words of the text of the request, all of them, in upper or lower case.
            q: Option<TextFilter>,
            label: Option<LabelFilter>,
            /// A category that an object of the scene has.
            category: Option<CategoryFilter>,
            min_objects: Option<ObjectCount>,
            max_objects: Option<ObjectCount>,
            /// Only scenes made from this one.
            parent: Option<IdFilter>,
            created_after: Option<Time>,
            $($field: $kind,)*
        }

        impl $name {
            fn filter(self) -> SceneFilter {
                SceneFilter {
                    state: self.state,
                    passed: self.verdict.map(|verdict| verdict == Verdict::Pass),
                    kind: self.kind.map(InputKind::of_store),
                    label: self.label.map(|label| (label.key, label.value)),
                    category: self.category.map(CategoryFilter::name),
                    words: self.q.map(TextFilter::words).unwrap_or_default(),
                    min_objects: self.min_objects.map(ObjectCount::get),
                    max_objects: self.max_objects.map(ObjectCount::get),
                    parent: self.parent.and_then(IdFilter::id),
                    created_after_ms: self.created_after.map(Time::as_ms),
                    ..SceneFilter::default()
                }
            }
        }
    };
}

scene_filters! {
    /// Parameters of `GET /scenes`.
    ListParameters {
        sort: ListOrder,
        page_size: PageSize,
        page_token: Option<PageToken>,
    }
}

scene_filters! {
    /// Parameters of `GET /scenes/facets`.
    FacetParameters {}
}

/// Order of a list of scenes; a page token belongs to the order that it came with.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
enum ListOrder {
    #[default]
    Newest,
    Oldest,
}

/// `GET /scenes`.
pub async fn list(
    api: TenantApi,
    Parameters(parameters): Parameters<ListParameters>,
) -> Result<Response, Problem> {
    let size = parameters.page_size;
    let filter = SceneFilter {
        oldest_first: parameters.sort == ListOrder::Oldest,
        before_id: parameters.page_token.and_then(PageToken::last_id),
        limit: size.rows_to_read(),
        ..parameters.filter()
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

/// `GET /scenes/facets`.
pub async fn facets(
    api: TenantApi,
    Parameters(parameters): Parameters<FacetParameters>,
) -> Result<Response, Problem> {
    let counts = api.store.scene_counts(&api.tenant_id, parameters.filter()).await?;
    let labels = counts.labels.into_iter().map(|((key, value), scenes)| (format!("{key}={value}"), scenes));
    let facets = SceneFacets {
        total: counts.total,
        state: Counts(counts.states),
        verdict: Counts(counts.verdicts),
        kind: Counts(counts.kinds),
        category: Counts(counts.categories),
        label: Counts(labels.collect()),
    };
    Ok(Json(facets).into_response())
}

/// Numbers of scenes by their properties; of more than 100,000, the newest ones are counted.
#[derive(Serialize, JsonSchema)]
pub(super) struct SceneFacets {
    #[schemars(range(min = 0, max = 100_000))]
    total: i64,
    state: Counts,
    /// Scenes that are not certified are in none.
    verdict: Counts,
    kind: Counts,
    /// The 50 categories that the most scenes have.
    category: Counts,
    /// The 50 labels that the most scenes have, as `key=value`.
    label: Counts,
}

/// Numbers of scenes by a word, the greatest first.
struct Counts(Vec<(String, i64)>);

impl Serialize for Counts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(word, scenes)| (word, scenes)))
    }
}

in_place! {
    Counts {
        "type": "object",
        "additionalProperties": { "type": "integer", "format": "int64", "minimum": 0, "maximum": 100_000 },
    }
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
