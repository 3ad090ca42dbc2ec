//! `/scenes`: submit, list, show, delete.

use std::time::Duration;

use axum::Json;
use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::error::{Problem, ProblemType};
use super::query::{IdFilter, LabelFilter, PageSize, PageToken, Parameters, Time};
use super::views::{ArtifactView, JobView, SceneView, SpendingView, StageView};
use super::{Api, jobs, submission};
use crate::spans;
use scene::SceneId;
use scene::job::SceneState;
use store::DEFAULT_TENANT;
use store::queue::QueueFull;
use store::retention::QuotaOutcome;
use store::scenes::{DeleteOutcome, SceneFilter, SceneRow, SubmitOutcome};

/// Parameters of `POST /scenes`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SubmitParameters {
    /// Whether the request is validated only.
    validate_only: bool,
}

/// `POST /scenes`.
pub async fn submit(
    State(api): State<Api>,
    Parameters(SubmitParameters { validate_only }): Parameters<SubmitParameters>,
    request: Request,
) -> Result<Response, Problem> {
    let key = idempotency_key(request.headers())?;
    let wait = preferred_wait(request.headers(), api.settings.max_wait_secs);
    let submission = submission::receive(&api, request).await?;
    if validate_only {
        let text = (api.understand)(&submission.request).map_err(|error| Problem::invalid(vec![error]))?;
        let document = json!({ "valid": true, "request": submission.request, "text": text });
        return Ok(Json(document).into_response());
    }
    if let QuotaOutcome::Exceeded { used_bytes, quota_bytes } = api.store.quota(&DEFAULT_TENANT).await? {
        return Err(Problem::quota_exceeded(used_bytes, quota_bytes));
    }
    let budget_usd = api.settings.usual_budget_usd;
    let schedule = submission.schedule(&api.queue);
    let new = submission.into_row(&api.store, DEFAULT_TENANT.clone(), budget_usd, key).await?;
    let scene_id = match api.store.submit_scheduled(new, schedule).await? {
        SubmitOutcome::Created { scene_id, job_id } => {
            metrics::counter!("tabletopgen_scenes_submitted_total").increment(1);
            spans::submitted(&scene_id, &job_id);
            scene_id
        }
        SubmitOutcome::Replayed { scene_id, job_id } => {
            spans::submitted(&scene_id, &job_id);
            scene_id
        }
        SubmitOutcome::QueueFull(full) => return Ok(queue_full(full)),
        SubmitOutcome::KeyReused => {
            return Err(Problem::new(
                ProblemType::InvalidRequest,
                "idempotency_key_reused",
                "this Idempotency-Key came with another body before; use a new key for a new scene",
            ));
        }
    };
    if let Some(wait) = wait {
        wait_for(&api, &scene_id, wait).await?;
    }
    let scene = find(&api, &scene_id).await?;
    let status = if scene.state == SceneState::Pending { StatusCode::ACCEPTED } else { StatusCode::OK };
    // Without `Prefer` the answer is always 202: the same request gets the same answer.
    let status = if wait.is_some() { status } else { StatusCode::ACCEPTED };
    let location = format!("/scenes/{scene_id}");
    let job = latest_job(&api, &scene_id).await?;
    let mut response = (status, Json(SceneView::new(scene, job))).into_response();
    if let Ok(location) = HeaderValue::from_str(&location) {
        response.headers_mut().insert(header::LOCATION, location);
    }
    if let Some(wait) = wait
        && let Ok(applied) = HeaderValue::from_str(&format!("wait={}", wait.as_secs()))
    {
        response.headers_mut().insert("preference-applied", applied);
    }
    Ok(response)
}

/// 429 with the time after which there may be room.
fn queue_full(full: QueueFull) -> Response {
    let detail = format!(
        "{} jobs wait in the queue, and no more may; send the request again in {} seconds",
        full.limit, full.retry_after_secs
    );
    let mut response = Problem::new(ProblemType::TooManyRequests, "queue_full", detail).into_response();
    response.headers_mut().insert(header::RETRY_AFTER, HeaderValue::from(full.retry_after_secs));
    response
}

/// Parameters of `GET /scenes`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ListParameters {
    state: Option<SceneState>,
    label: Option<LabelFilter>,
    parent: Option<IdFilter>,
    created_after: Option<Time>,
    page_size: PageSize,
    page_token: Option<PageToken>,
}

/// `GET /scenes`.
pub async fn list(
    State(api): State<Api>,
    Parameters(parameters): Parameters<ListParameters>,
) -> Result<Response, Problem> {
    let size = parameters.page_size.get();
    let filter = SceneFilter {
        state: parameters.state,
        label: parameters.label.map(|label| (label.key, label.value)),
        parent: parameters.parent.and_then(IdFilter::id),
        created_after_ms: parameters.created_after.map(Time::as_ms),
        before_id: parameters.page_token.and_then(PageToken::last_id),
        limit: size + 1,
    };
    let mut rows = api.store.scenes(&DEFAULT_TENANT, filter).await?;
    let more = rows.len() > size as usize;
    rows.truncate(size as usize);
    let next = rows.last().filter(|_| more).and_then(|(scene, _)| PageToken::after(scene.id.as_str()));
    let (scenes, jobs): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
    let jobs = jobs::views(&api, jobs).await?;
    let page = ScenePage {
        scenes: scenes.into_iter().zip(jobs).map(|(scene, job)| SceneView::new(scene, job)).collect(),
        next_page_token: next.map(|token| token.to_string()),
    };
    Ok(Json(page).into_response())
}

/// A page of scenes.
#[derive(Serialize)]
struct ScenePage {
    scenes: Vec<SceneView>,
    next_page_token: Option<String>,
}

/// `GET /scenes/{scene_id}`.
pub async fn show(State(api): State<Api>, Path(scene_id): Path<String>) -> Result<Response, Problem> {
    let scene_id = parse_id(&scene_id)?;
    let scene = find(&api, &scene_id).await?;
    let job = latest_job(&api, &scene_id).await?;
    let stages = match &job {
        Some(job) => api.store.stages(&DEFAULT_TENANT, &job.id).await?,
        None => Vec::new(),
    };
    let artifacts = api.store.artifacts(&DEFAULT_TENANT, &scene_id).await?;
    let mut view = SceneView::new(scene, job);
    view.stages = Some(stages.into_iter().map(StageView::new).collect());
    let spending = api.store.spending(&DEFAULT_TENANT, &scene_id).await?;
    let calls = api.store.calls(&DEFAULT_TENANT, &scene_id).await?;
    view.spending = Some(SpendingView::new(spending, calls));
    view.artifacts = Some(artifacts.into_iter().map(|row| ArtifactView::new(&scene_id, row)).collect());
    Ok(Json(view).into_response())
}

/// `DELETE /scenes/{scene_id}`.
pub async fn remove(State(api): State<Api>, Path(scene_id): Path<String>) -> Result<StatusCode, Problem> {
    let scene_id = parse_id(&scene_id)?;
    match api.store.delete_scene(&DEFAULT_TENANT, &scene_id).await? {
        DeleteOutcome::Done => Ok(StatusCode::NO_CONTENT),
        DeleteOutcome::NotFound => Err(Problem::not_found("scene", scene_id.as_str())),
    }
}

/// The scene id in a path. A text that is no id names no scene.
pub(super) fn parse_id(text: &str) -> Result<SceneId, Problem> {
    text.parse().map_err(|_| Problem::not_found("scene", text))
}

/// A scene that is there.
pub(super) async fn find(api: &Api, scene_id: &SceneId) -> Result<SceneRow, Problem> {
    match api.store.scene(&DEFAULT_TENANT, scene_id).await? {
        Some(scene) if scene.state == SceneState::Deleted => {
            Err(Problem::new(ProblemType::Gone, "scene_deleted", "this scene was deleted; submit it again"))
        }
        Some(scene) => Ok(scene),
        None => Err(Problem::not_found("scene", scene_id.as_str())),
    }
}

/// The newest job of a scene, as clients see it.
async fn latest_job(api: &Api, scene_id: &SceneId) -> Result<Option<JobView>, Problem> {
    let job = api.store.latest_job(&DEFAULT_TENANT, scene_id).await?;
    Ok(jobs::views(api, vec![job]).await?.pop().flatten())
}

fn idempotency_key(headers: &HeaderMap) -> Result<Option<String>, Problem> {
    let Some(key) = headers.get("idempotency-key") else { return Ok(None) };
    let key = key.to_str().ok().filter(|key| {
        (1..=255).contains(&key.len()) && key.bytes().all(|byte| (0x21..=0x7e).contains(&byte))
    });
    key.map(|key| Some(key.to_owned())).ok_or_else(|| {
        Problem::new(
            ProblemType::MalformedRequest,
            "invalid_idempotency_key",
            "Idempotency-Key has 1 to 255 visible ASCII characters, such as a UUID",
        )
    })
}

/// `Prefer: wait=N`; what cannot be understood is ignored, as preferences are.
fn preferred_wait(headers: &HeaderMap, max_secs: u64) -> Option<Duration> {
    let preferences = headers.get_all("prefer").into_iter().filter_map(|value| value.to_str().ok());
    preferences
        .flat_map(|value| value.split(','))
        .find_map(|preference| preference.trim().strip_prefix("wait=")?.trim().parse::<u64>().ok())
        .map(|seconds| Duration::from_secs(seconds.min(max_secs)))
}

/// Returns when the scene is no longer pending, or after `wait`, or when the process is to end.
async fn wait_for(api: &Api, scene_id: &SceneId, wait: Duration) -> Result<(), Problem> {
    let deadline = tokio::time::Instant::now() + wait;
    let mut changes = api.store.changes();
    loop {
        let scene = api.store.scene(&DEFAULT_TENANT, scene_id).await?;
        if scene.is_none_or(|scene| scene.state != SceneState::Pending) {
            return Ok(());
        }
        tokio::select! {
            () = tokio::time::sleep_until(deadline) => return Ok(()),
            () = api.shutdown.cancelled() => return Ok(()),
            _ = changes.changed() => {}
        }
    }
}
