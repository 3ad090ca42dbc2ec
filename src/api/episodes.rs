//! `/scenes/{scene_id}/episodes` and `/episodes`: record demonstrations of tasks in a finished scene as a dataset;
//! list, show, cancel, download.
//!
//! They are recorded in the background (see `recorder`). A dataset never changes; its files and the archives of its
//! formats have strong `ETag`s, their SHA-256, and are sent in ranges.

mod content;
mod request;
mod views;

use axum::Json;
use axum::http::{HeaderMap, Method};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::accepted::accepted_at;
use super::admission::overloaded;
use super::download::{Download, respond};
use super::enqueue::Delivery;
use super::extract::{JsonBody, JsonRequest, PathId, PathName, TenantApi};
use super::query::{IdFilter, Page, PageSize, PageToken, Parameters};
use super::{parent, scenes};
use crate::app::episodes::draft::EpisodesDraft;
use crate::app::episodes::ordered;
use crate::problem::{Problem, ProblemType};
use scene::{RecordingId, SceneId};
use store::Digest;
use store::recordings::{
    CancelRecordingOutcome, NewRecording, RecordingArchive, RecordingFilter, RecordingRow, RecordingState,
    SubmitRecordingOutcome,
};

use content::{file_content, media_type_of, whole};
use request::StateFilter;
use views::{RecordingFileView, RecordingView};

impl JsonRequest for EpisodesDraft {
    const EXAMPLE: &str = r#"{"task": "put the apple in the bowl", "count": 50}"#;
}

/// `POST /scenes/{scene_id}/episodes`.
pub async fn submit(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    Delivery { idempotency_key, .. }: Delivery,
    JsonBody { value: draft, memory: _memory }: JsonBody<EpisodesDraft>,
) -> Result<Response, Problem> {
    draft.check_texts(api.settings.max_text_chars)?;
    let order = ordered(&draft)?;
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let scene = scenes::find(&api, &scene_id).await?;
    let bundle = parent::bundle_of(&api, &scene, true).await?;
    let request = order.stored();
    let new = NewRecording {
        tenant_id: api.tenant_id.clone(),
        body_digest: Digest::of(format!("{scene_id} {request}").as_bytes()),
        scene_id,
        request,
        bundle: bundle.digest,
        wanted: order.count,
        max_attempts: order.max_attempts,
        idempotency_key,
    };
    match api.store.submit_recording(new).await? {
        SubmitRecordingOutcome::Created(id) | SubmitRecordingOutcome::Replayed(id) => {
            accepted(&api, &id).await
        }
        SubmitRecordingOutcome::KeyReused => Err(Problem::key_reused("recording of episodes")),
    }
}

/// Parameters of `GET /episodes`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ListParameters {
    scene: Option<IdFilter>,
    state: Option<StateFilter>,
    page_size: PageSize,
    page_token: Option<PageToken>,
}

/// A page of recordings.
#[derive(Serialize)]
struct RecordingPage {
    recordings: Vec<RecordingView>,
    next_page_token: Option<String>,
}

/// `GET /episodes`.
pub async fn list(
    api: TenantApi,
    Parameters(parameters): Parameters<ListParameters>,
) -> Result<Response, Problem> {
    let size = parameters.page_size;
    let filter = RecordingFilter {
        scene_id: parameters.scene.and_then(IdFilter::id),
        state: parameters.state.map(|state| state.0),
        before_id: parameters.page_token.and_then(PageToken::last_id),
        limit: size.rows_to_read(),
    };
    let rows = api.store.recordings(&api.tenant_id, filter).await?;
    let Page { rows, next_page_token } = size.page_of(rows, |row| PageToken::after(row.id.as_str()));
    let mut recordings = Vec::with_capacity(rows.len());
    for row in rows {
        recordings.push(RecordingView::of(&api, row).await?);
    }
    let page = RecordingPage { recordings, next_page_token };
    Ok(Json(page).into_response())
}

/// `GET /episodes/{recording_id}`.
pub async fn show(api: TenantApi, PathId(recording_id): PathId<RecordingId>) -> Result<Response, Problem> {
    let row = find(&api, &recording_id).await?;
    Ok(Json(RecordingView::of(&api, row).await?).into_response())
}

/// `POST /episodes/{recording_id}/cancel`.
pub async fn cancel(api: TenantApi, PathId(recording_id): PathId<RecordingId>) -> Result<Response, Problem> {
    match api.store.cancel_recording(&api.tenant_id, &recording_id).await? {
        CancelRecordingOutcome::Accepted => accepted(&api, &recording_id).await,
        CancelRecordingOutcome::TooLate(state) => Err(Problem::new(
            ProblemType::Conflict,
            "episodes_already_ended",
            format!("this recording is {} already; there is nothing to cancel", state.as_str()),
        )),
        CancelRecordingOutcome::NotFound => {
            Err(Problem::not_found("recording of episodes", recording_id.as_str()))
        }
    }
}

/// Parameters of `GET /episodes/{recording_id}/files`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FileParameters {
    page_size: PageSize,
    page_token: Option<PageToken>,
}

/// `GET /episodes/{recording_id}/files`.
pub async fn files(
    api: TenantApi,
    PathId(recording_id): PathId<RecordingId>,
    Parameters(parameters): Parameters<FileParameters>,
) -> Result<Response, Problem> {
    let row = finished(&api, &recording_id).await?;
    let size = parameters.page_size;
    let after = parameters.page_token.and_then(content::place_of);
    let files = api.store.recording_files(&row.id, after, size.rows_to_read()).await?;
    let page = size.page_of(files, |(place, _)| content::token_after(*place));
    let files: Vec<RecordingFileView> =
        page.rows.into_iter().map(|(_, file)| RecordingFileView::new(&row.id, file)).collect();
    Ok(Json(json!({ "files": files, "next_page_token": page.next_page_token })).into_response())
}

/// `GET /episodes/{recording_id}/files/{name}`.
pub async fn download(
    api: TenantApi,
    PathId(recording_id): PathId<RecordingId>,
    PathName(path): PathName,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let row = finished(&api, &recording_id).await?;
    let file = api.store.recording_file(&row.id, &path).await?;
    let file = file.ok_or_else(|| Problem::not_found("file of the episodes", &path))?;
    let format = path.split('/').next().unwrap_or_default();
    let archive = archive_of(&api, &row, format).await?;
    let kind = media_type_of(&path);
    let name = path.rsplit('/').next().unwrap_or_default().to_owned();
    let what = Download {
        digest: &file.digest,
        size: file.size,
        media_type: kind,
        // Documents are shown in place.
        file_name: (kind == "application/octet-stream").then_some(name),
        content: file_content(&archive, &file),
    };
    respond(&api, &method, &headers, what).await?.ok_or_else(damaged)
}

/// `GET /episodes/{recording_id}/archives/{format}`.
pub async fn archive(
    api: TenantApi,
    PathId(recording_id): PathId<RecordingId>,
    PathName(format): PathName,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let row = finished(&api, &recording_id).await?;
    let archive = archive_of(&api, &row, &format).await?;
    let digest = archive.digest.clone().ok_or_else(damaged)?;
    let what = Download {
        digest: &digest,
        size: archive.size,
        media_type: "application/x-tar",
        file_name: Some(format!("{}-{}.tar", row.id, archive.format)),
        content: whole(&archive),
    };
    respond(&api, &method, &headers, what).await?.ok_or_else(damaged)
}

async fn archive_of(api: &TenantApi, row: &RecordingRow, format: &str) -> Result<RecordingArchive, Problem> {
    let archives = api.store.recording_archives(&row.id).await?;
    let found = archives.into_iter().find(|archive| archive.format == format);
    found.ok_or_else(|| Problem::not_found("format of the episodes", format))
}

fn damaged() -> Problem {
    Problem::new(
        ProblemType::Gone,
        "episodes_damaged",
        "the bytes of this file are lost or damaged; order the same episodes again",
    )
}

/// 202 with the recording and its address.
async fn accepted(api: &TenantApi, recording_id: &RecordingId) -> Result<Response, Problem> {
    let view = RecordingView::of(api, find(api, recording_id).await?).await?;
    Ok(accepted_at(&view.links.this, &view))
}

/// A recording that is there.
pub(super) async fn find(api: &TenantApi, recording_id: &RecordingId) -> Result<RecordingRow, Problem> {
    let row = api.store.recording(&api.tenant_id, recording_id).await?;
    row.ok_or_else(|| Problem::not_found("recording of episodes", recording_id.as_str()))
}

/// A recording with a dataset.
async fn finished(api: &TenantApi, recording_id: &RecordingId) -> Result<RecordingRow, Problem> {
    let row = find(api, recording_id).await?;
    let (code, detail) = match row.state {
        RecordingState::Finished => return Ok(row),
        RecordingState::Failed => ("episodes_failed", "these episodes have no files; see the failure"),
        RecordingState::Cancelled => {
            ("episodes_cancelled", "these episodes were cancelled; order them again")
        }
        RecordingState::Queued | RecordingState::Running => (
            "episodes_not_ready",
            "these episodes are not recorded yet; ask for their state until it is finished",
        ),
    };
    Err(Problem::new(ProblemType::Conflict, code, detail))
}
