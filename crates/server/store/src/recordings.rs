//! Recordings: demonstrations of tasks in a finished scene, recorded in the background as a dataset.
//!
//! A row is one order with its request, which the store does not interpret. Its attempts are numbered, and each is a
//! job (see [`crate::queue`]) whose result is kept ([`attempts`]), so that any number of processes work on one
//! recording and none loses more than the attempts that it was making. When enough have succeeded, or no more are
//! allowed, and none is being made, one more job assembles the dataset ([`dataset`]). Which jobs there are is decided
//! in [`schedule`]; they are dropped with the attempts when the recording ends. Events state what happens ([`events`]),
//! and stay.

mod attempts;
mod deletion;
mod schedule;
mod dataset;
mod ending;
mod events;
mod files;
mod progress;
mod requests;

use serde_json::Value;
use sqlx::Row;
use sqlx::any::AnyRow;

use super::list_query::ListQuery;
use super::{Digest, Store, StoreError, database};
use crate::boxed;
use scene::{RecordingId, SceneId, TenantId};

pub use attempts::{AttemptWork, Begun, KeptAttempt, MadeAttempt};
pub(super) use attempts::{keep, make_again};
pub use dataset::{ArchivePart, RecordingArchive};
pub(super) use ending::{cancel_by_job, fail, finish};
pub use events::{RecordingEventHead, RecordingEventKind};
pub use files::RecordingFile;
pub use progress::RecordingProgress;
pub use requests::{CancelRecordingOutcome, NewRecording, SubmitRecordingOutcome};
pub(super) use schedule::begun;

/// State of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordingState {
    /// Waits for a process.
    Queued,
    Running,
    /// The dataset is there, and never changes.
    Finished,
    /// There is no dataset.
    Failed,
    Cancelled,
}

impl RecordingState {
    pub const ALL: [Self; 5] = [Self::Queued, Self::Running, Self::Finished, Self::Failed, Self::Cancelled];

    pub fn as_str(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Finished => "finished",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    /// Inverse of [`Self::as_str`].
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.as_str() == text)
    }

    pub fn is_final(self) -> bool {
        !matches!(self, Self::Queued | Self::Running)
    }
}

/// A recording's row.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingRow {
    pub id: RecordingId,
    pub tenant_id: TenantId,
    pub scene_id: SceneId,
    pub state: RecordingState,
    /// Request of the recording, as JSON.
    pub request: Value,
    /// The blob of the scene's archive.
    pub bundle: Digest,
    /// Attempts that are to succeed.
    pub wanted: u64,
    pub max_attempts: u64,
    /// Of everything that attempts depend on, once a process knows it.
    pub identity: Option<String>,
    /// Number of times that all attempts were dropped for another identity.
    pub restarts: i64,
    /// Attempts that were enqueued: the number of the next one.
    pub begun: u64,
    /// Attempts that have an outcome.
    pub made: u64,
    pub successes: u64,
    /// Result as JSON, once the recording is ended.
    pub summary: Option<Value>,
    pub failure_code: Option<String>,
    pub failure_message: Option<String>,
    /// Milliseconds since 1970.
    pub created_at_ms: i64,
    pub started_at_ms: Option<i64>,
    pub finished_at_ms: Option<i64>,
    pub is_deleted: bool,
}

/// Filter of a list of recordings.
#[derive(Clone, Debug, Default)]
pub struct RecordingFilter {
    pub scene_id: Option<SceneId>,
    pub state: Option<RecordingState>,
    /// Only recordings older than this id, the last id of the previous page.
    pub before_id: Option<RecordingId>,
    pub limit: u32,
}

impl Store {
    /// A recording of the tenant, including deleted recordings.
    #[boxed]
    pub async fn recording(
        &self,
        tenant_id: &TenantId,
        id: &RecordingId,
    ) -> Result<Option<RecordingRow>, StoreError> {
        let row = sqlx::query("SELECT * FROM recordings WHERE id = $1 AND tenant_id = $2")
            .bind(id.as_str())
            .bind(tenant_id.as_str())
            .fetch_optional(&self.readers)
            .await?;
        row.as_ref().map(recording_of).transpose()
    }

    /// Recordings of the tenant, newest first.
    #[boxed]
    pub async fn recordings(
        &self,
        tenant_id: &TenantId,
        filter: RecordingFilter,
    ) -> Result<Vec<RecordingRow>, StoreError> {
        let list = ListQuery::of(tenant_id)
            .fixed("deleted_at IS NULL")
            .word("state", filter.state.map(RecordingState::as_str))
            .text("scene_id =", filter.scene_id)
            .text("id <", filter.before_id);
        let rows = list.select("recordings", filter.limit).rows(&self.readers).await?;
        rows.iter().map(recording_of).collect()
    }
}

fn corrupt(reason: String) -> StoreError {
    StoreError::Corrupt { table: "recordings", reason }
}

fn count(row: &AnyRow, column: &str) -> Result<u64, StoreError> {
    Ok(u64::try_from(row.try_get::<i64, _>(column)?).unwrap_or(0))
}

/// A count as the database has it.
fn stored(count: u64) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

fn recording_of(row: &AnyRow) -> Result<RecordingRow, StoreError> {
    let json = |column: &str| -> Result<Option<Value>, StoreError> {
        let text: Option<String> = row.try_get(column)?;
        text.map(|text| serde_json::from_str(&text))
            .transpose()
            .map_err(|error| corrupt(format!("{column}: {error}")))
    };
    let state: String = row.try_get("state")?;
    Ok(RecordingRow {
        id: database::id(row, "recordings", "id")?,
        tenant_id: database::id(row, "recordings", "tenant_id")?,
        scene_id: database::id(row, "recordings", "scene_id")?,
        state: RecordingState::parse(&state).ok_or_else(|| corrupt(format!("state {state}")))?,
        request: json("request")?.unwrap_or_default(),
        bundle: Digest::parse(&row.try_get::<String, _>("bundle")?)?,
        wanted: count(row, "wanted")?,
        max_attempts: count(row, "max_attempts")?,
        identity: row.try_get("identity")?,
        restarts: row.try_get("restarts")?,
        begun: count(row, "begun")?,
        made: count(row, "made")?,
        successes: count(row, "successes")?,
        summary: json("summary")?,
        failure_code: row.try_get("failure_code")?,
        failure_message: row.try_get("failure_message")?,
        created_at_ms: row.try_get("created_at")?,
        started_at_ms: row.try_get("started_at")?,
        finished_at_ms: row.try_get("finished_at")?,
        is_deleted: row.try_get::<Option<i64>, _>("deleted_at")?.is_some(),
    })
}
