//! `/scenes/{scene_id}/episodes` and `/episodes`: record demonstrations of tasks in a finished scene as a dataset;
//! list, show, cancel, delete, download.
//!
//! They are recorded in the background (see `recorder`). A dataset never changes; its files and the archives of its
//! formats have strong `ETag`s, their SHA-256, and are sent in ranges.

mod content;
pub(super) mod download;
mod request;
pub(super) mod views;

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::accepted::accepted_at;
use super::admission::overloaded;
use super::deletion::{self, gone};
use super::extract::{JsonBody, JsonRequest, PathId, TenantApi};
use super::idempotency::{IdempotencyKey, KeyScope, scoped};
use super::instructions::read_tasks;
use super::limits::{check_bytes, refused};
use super::parent;
use super::query::{IdFilter, Page, PageSize, PageToken, Parameters};
use crate::app::episodes::draft::EpisodesDraft;
use crate::app::episodes::ordered;
use crate::problem::{Problem, ProblemType};
use crate::schemas::words;
use scene::{RecordingId, SceneId};
use store::Digest;
use store::recordings::{
    CancelRecordingOutcome, NewRecording, RecordingFilter, RecordingRow, SubmitRecordingOutcome,
};

pub use download::{archive, download, files};
use request::StateFilter;
use views::RecordingView;

impl JsonRequest for EpisodesDraft {
    type Schema = Self;
    const EXAMPLE: &str = r#"{"task": "put the apple in the bowl", "count": 50}"#;
}

/// `POST /scenes/{scene_id}/episodes`.
pub async fn submit(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    IdempotencyKey(idempotency_key): IdempotencyKey,
    JsonBody { value: draft, memory: _memory }: JsonBody<EpisodesDraft>,
) -> Result<Response, Problem> {
    draft.check_texts(api.settings.max_text_chars)?;
    let mut order = ordered(&draft)?;
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let bundle = parent::bundle_of(&api, &scene_id, true).await?;
    check_bytes(&api).await?;
    let robot = order.robot.clone();
    read_tasks(&api, &scene_id, &bundle, order.tasks.iter_mut(), &robot).await?;
    let request = order.stored();
    let new = NewRecording {
        tenant_id: api.tenant_id.clone(),
        body_digest: Digest::of(format!("{scene_id} {request}").as_bytes()),
        scene_id,
        request,
        bundle: bundle.digest,
        wanted: order.count,
        max_attempts: order.max_attempts,
        idempotency_key: scoped(&api, KeyScope::Recording, idempotency_key.as_deref()),
    };
    match api.store.submit_recording(new).await? {
        SubmitRecordingOutcome::Created(id) | SubmitRecordingOutcome::Replayed(id) => {
            accepted(&api, &id).await
        }
        SubmitRecordingOutcome::KeyReused => Err(Problem::key_reused("recording of episodes")),
        SubmitRecordingOutcome::Refused(reached) => Err(refused(reached)),
    }
}

/// Parameters of `GET /episodes`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ListParameters {
    scene: Option<IdFilter>,
    #[schemars(with = "Option<words::RecordingState>")]
    state: Option<StateFilter>,
    page_size: PageSize,
    page_token: Option<PageToken>,
}

/// A page of recordings.
#[derive(Serialize, JsonSchema)]
pub(super) struct RecordingPage {
    recordings: Vec<RecordingView>,
    /// Null on the last page.
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
    find(&api, &recording_id).await?;
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

/// `DELETE /episodes/{recording_id}`.
pub async fn remove(
    api: TenantApi,
    PathId(recording_id): PathId<RecordingId>,
) -> Result<StatusCode, Problem> {
    deletion::answer(api.store.delete_recording(&api.tenant_id, &recording_id).await?, &recording_id)
}

/// 202 with the recording and its address.
async fn accepted(api: &TenantApi, recording_id: &RecordingId) -> Result<Response, Problem> {
    let view = RecordingView::of(api, find(api, recording_id).await?).await?;
    Ok(accepted_at(&view.links.this, &view))
}

/// A recording that is there.
pub(super) async fn find(api: &TenantApi, recording_id: &RecordingId) -> Result<RecordingRow, Problem> {
    match api.store.recording(&api.tenant_id, recording_id).await? {
        Some(row) if row.is_deleted => {
            Err(gone("episodes_deleted", "recording of episodes", "order the episodes again"))
        }
        Some(row) => Ok(row),
        None => Err(Problem::not_found("recording of episodes", recording_id.as_str())),
    }
}
