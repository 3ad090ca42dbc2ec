//! `/scenes`: submit, list, show, delete.

use std::time::Duration;

use axum::Json;
use axum::extract::{Path, RawQuery, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::json;

use super::error::{Problem, ProblemType};
use super::wire::{
    ArtifactView, SceneView, SpendingView, StageView, page_size, page_token, parameter, parse_page_token,
    parse_timestamp, query,
};
use super::{Api, submission};
use scene::SceneId;
use scene::job::SceneState;
use store::DEFAULT_TENANT;
use store::scenes::{DeleteOutcome, NewScene, SceneFilter, SceneRow, SubmitOutcome};

/// `POST /scenes`.
pub async fn submit(
    State(api): State<Api>,
    RawQuery(raw_query): RawQuery,
    request: Request,
) -> Result<Response, Problem> {
    let parameters = query(raw_query.as_deref(), &["validate_only"])?;
    let validate_only = match parameters.get("validate_only").map(String::as_str) {
        None | Some("false") => false,
        Some("true") => true,
        Some(_) => return Err(parameter("validate_only", "must be `true` or `false`")),
    };
    let key = idempotency_key(request.headers())?;
    let wait = preferred_wait(request.headers(), api.settings.max_wait_secs);
    let submission = submission::read(&api, request).await?;
    if validate_only {
        return Ok(Json(json!({ "valid": true, "request": submission.request })).into_response());
    }
    if let Some(image) = &submission.image {
        api.store.blobs().put(image.bytes.clone()).await?;
    }
    let new = NewScene {
        tenant_id: DEFAULT_TENANT.clone(),
        request: json!(submission.request),
        labels: submission.labels,
        budget_micro_usd: submission.request.options.budget(api.settings.usual_budget_usd).0,
        idempotency: key.map(|key| (key, submission.body_digest.to_string())),
    };
    let scene_id = match api.store.submit(new).await? {
        SubmitOutcome::Created { scene_id, .. } => {
            metrics::counter!("tabletopgen_scenes_submitted_total").increment(1);
            scene_id
        }
        SubmitOutcome::Replayed { scene_id, .. } => scene_id,
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
    let job = api.store.latest_job(&DEFAULT_TENANT, &scene_id).await?;
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

/// `GET /scenes`.
pub async fn list(State(api): State<Api>, RawQuery(raw_query): RawQuery) -> Result<Response, Problem> {
    let known = ["state", "label", "parent", "created_after", "page_size", "page_token"];
    let parameters = query(raw_query.as_deref(), &known)?;
    let get = |name: &str| parameters.get(name).map(String::as_str);
    let size = page_size(get("page_size"))?;
    let state = get("state")
        .map(|text| {
            let advice = "must be pending, ready, failed or deleted";
            SceneState::parse(text).ok_or_else(|| parameter("state", advice))
        })
        .transpose()?;
    let label = get("label")
        .map(|text| {
            let pair = text.split_once(':').ok_or_else(|| parameter("label", "must be `key:value`"))?;
            Ok::<_, Problem>((pair.0.to_owned(), pair.1.to_owned()))
        })
        .transpose()?;
    let created_after_ms = get("created_after")
        .map(|text| {
            let advice = "must be a time such as 2026-01-31T12:00:00Z";
            parse_timestamp(text).ok_or_else(|| parameter("created_after", advice))
        })
        .transpose()?;
    let filter = SceneFilter {
        state,
        label,
        parent: get("parent").map(parent_id).transpose()?,
        created_after_ms,
        before_id: get("page_token").map(parse_page_token).transpose()?,
        limit: size + 1,
    };
    let mut rows = api.store.scenes(&DEFAULT_TENANT, filter).await?;
    let more = rows.len() > size as usize;
    rows.truncate(size as usize);
    let next = rows.last().filter(|_| more).map(|scene| page_token(&scene.id));
    let mut scenes = Vec::with_capacity(rows.len());
    for scene in rows {
        let job = api.store.latest_job(&DEFAULT_TENANT, &scene.id).await?;
        scenes.push(SceneView::new(scene, job));
    }
    Ok(Json(json!({ "scenes": scenes, "next_page_token": next })).into_response())
}

/// `GET /scenes/{scene_id}`.
pub async fn show(State(api): State<Api>, Path(scene_id): Path<String>) -> Result<Response, Problem> {
    let scene_id = parse_id(&scene_id)?;
    let scene = find(&api, &scene_id).await?;
    let job = api.store.latest_job(&DEFAULT_TENANT, &scene_id).await?;
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

fn parent_id(text: &str) -> Result<SceneId, Problem> {
    text.parse().map_err(|_| parameter("parent", "must be the id of a scene"))
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
