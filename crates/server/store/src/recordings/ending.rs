//! The end of a recording: with a dataset, with a failure, or cancelled. Its attempts and its other jobs are dropped;
//! its events stay.

use serde_json::{Map, Value, json};
use sqlx::AnyConnection;

use super::attempts::drop_attempts;
use super::dataset::drop_dataset;
use super::events::append;
use super::schedule::{Locked, drop_jobs, lock, lock_recording};
use super::{RecordingEventKind, RecordingState};
use crate::{StoreError, webhooks};
use scene::{JobId, RecordingId};

/// Ends the recording of an assembling job that has succeeded, with a summary as JSON.
pub(crate) async fn finish(
    connection: &mut AnyConnection,
    job_id: &JobId,
    summary: &Value,
    now_ms: i64,
) -> Result<(), StoreError> {
    let Locked { recording, .. } = lock(connection, job_id).await?;
    drop_jobs(connection, &recording.id, Some(job_id)).await?;
    drop_attempts(connection, &recording.id).await?;
    sqlx::query("UPDATE recordings SET state = 'finished', summary = $1, finished_at = $2 WHERE id = $3")
        .bind(summary.to_string())
        .bind(now_ms)
        .bind(recording.id.as_str())
        .execute(&mut *connection)
        .await?;
    tell(connection, &recording.id, now_ms, RecordingEventKind::Finished, Map::new()).await
}

/// Ends the recording of a job that failed, without a dataset.
pub(crate) async fn fail(
    connection: &mut AnyConnection,
    job_id: &JobId,
    code: &str,
    message: &str,
    now_ms: i64,
) -> Result<(), StoreError> {
    let Locked { recording, .. } = lock(connection, job_id).await?;
    if recording.state.is_final() {
        return Ok(());
    }
    sqlx::query("UPDATE recordings SET failure_code = $1, failure_message = $2 WHERE id = $3")
        .bind(code)
        .bind(message)
        .bind(recording.id.as_str())
        .execute(&mut *connection)
        .await?;
    end(connection, &recording.id, RecordingState::Failed, Some(job_id), now_ms).await?;
    let failure = json!({ "code": code, "message": message });
    let fields = Map::from_iter([("failure".to_owned(), failure)]);
    tell(connection, &recording.id, now_ms, RecordingEventKind::Failed, fields).await
}

/// Ends the recording of a job that was cancelled.
pub(crate) async fn cancel_by_job(
    connection: &mut AnyConnection,
    job_id: &JobId,
    now_ms: i64,
) -> Result<(), StoreError> {
    let Locked { recording, .. } = lock(connection, job_id).await?;
    if recording.state.is_final() {
        return Ok(());
    }
    cancel(connection, &recording.id, Some(job_id), now_ms).await
}

/// Cancels a recording that has not ended. All its jobs are dropped but one.
pub(super) async fn cancel(
    connection: &mut AnyConnection,
    id: &RecordingId,
    but: Option<&JobId>,
    now_ms: i64,
) -> Result<(), StoreError> {
    lock_recording(connection, id).await?;
    end(connection, id, RecordingState::Cancelled, but, now_ms).await?;
    tell(connection, id, now_ms, RecordingEventKind::Cancelled, Map::new()).await
}

/// The event of an end, and what webhooks are sent.
async fn tell(
    connection: &mut AnyConnection,
    id: &RecordingId,
    now_ms: i64,
    kind: RecordingEventKind,
    fields: Map<String, Value>,
) -> Result<(), StoreError> {
    append(connection, id, now_ms, kind, fields).await?;
    webhooks::recording_ended(connection, id, now_ms).await
}

async fn end(
    connection: &mut AnyConnection,
    id: &RecordingId,
    state: RecordingState,
    but: Option<&JobId>,
    now_ms: i64,
) -> Result<(), StoreError> {
    drop_jobs(connection, id, but).await?;
    let outcomes = drop_attempts(connection, id).await?;
    sqlx::query("UPDATE recordings SET state = $1, summary = $2, finished_at = $3 WHERE id = $4")
        .bind(state.as_str())
        .bind(json!({ "attempts": outcomes }).to_string())
        .bind(now_ms)
        .bind(id.as_str())
        .execute(&mut *connection)
        .await?;
    drop_dataset(connection, id).await
}
