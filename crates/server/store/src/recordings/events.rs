//! Events of a recording, numbered 1, 2, 3, ... within the recording.
//!
//! An event is written in the transaction of the change that it tells of, which holds the recording's row. A reader
//! that has received event `n` has therefore received all earlier events, across restarts. Events are kept as long as
//! the recording, also after its attempts are dropped.

use serde_json::{Map, Value, json};
use sqlx::{AnyConnection, Row};

use super::progress::progress;
use super::{RecordingState, corrupt, recording_of};
use crate::boxed;
use crate::events::{Event, event_of, rows_of_ids};
use crate::{Store, StoreError, database};
use scene::{RecordingId, TenantId};

/// Subject of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordingEventKind {
    /// The recording waits for a process.
    Queued,
    /// Begin of the first attempt.
    Running,
    /// An attempt is finished.
    Attempt,
    /// The episode of an attempt is lost or damaged; the attempt is made again.
    AttemptLost,
    /// All attempts so far were dropped, as a process of another identity has taken over.
    Restarted,
    /// No attempt is missing; the dataset is assembled.
    Assembling,
    Finished,
    Failed,
    Cancelled,
}

impl RecordingEventKind {
    pub const ALL: [Self; 9] = [
        Self::Queued,
        Self::Running,
        Self::Attempt,
        Self::AttemptLost,
        Self::Restarted,
        Self::Assembling,
        Self::Finished,
        Self::Failed,
        Self::Cancelled,
    ];

    pub fn as_str(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Attempt => "attempt",
            Self::AttemptLost => "attempt_lost",
            Self::Restarted => "restarted",
            Self::Assembling => "assembling",
            Self::Finished => "finished",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }
}

/// Position of the newest event of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordingEventHead {
    pub id: RecordingId,
    /// Number of the last event; 0 where there is none.
    pub last_seq: i64,
    /// State of the recording; after a final one no event follows.
    pub state: RecordingState,
}

/// Appends an event inside the caller's transaction, which has locked the recording's row and changed it already. To
/// the fields `data` comes the progress after the change.
pub(super) async fn append(
    connection: &mut AnyConnection,
    id: &RecordingId,
    now_ms: i64,
    kind: RecordingEventKind,
    mut data: Map<String, Value>,
) -> Result<(), StoreError> {
    let row = sqlx::query("SELECT * FROM recordings WHERE id = $1")
        .bind(id.as_str())
        .fetch_one(&mut *connection)
        .await?;
    let progress = progress(connection, &recording_of(&row)?).await?;
    data.insert("progress".to_owned(), json!(progress));
    sqlx::query(
        "INSERT INTO recording_events (recording_id, seq, at, kind, data)
         SELECT $1, COALESCE(MAX(seq), 0) + 1, $2, $3, $4 FROM recording_events WHERE recording_id = $5",
    )
    .bind(id.as_str())
    .bind(now_ms)
    .bind(kind.as_str())
    .bind(Value::Object(data).to_string())
    .bind(id.as_str())
    .execute(connection)
    .await?;
    Ok(())
}

/// Whether the last event of a recording is of this kind.
pub(super) async fn ends_with(
    connection: &mut AnyConnection,
    id: &RecordingId,
    kind: RecordingEventKind,
) -> Result<bool, StoreError> {
    let last: Option<String> = sqlx::query_scalar(
        "SELECT kind FROM recording_events WHERE recording_id = $1 ORDER BY seq DESC LIMIT 1",
    )
    .bind(id.as_str())
    .fetch_optional(connection)
    .await?;
    Ok(last.as_deref() == Some(kind.as_str()))
}

impl Store {
    /// At most `limit` events of a recording after number `after`, in order.
    #[boxed]
    pub async fn recording_events(
        &self,
        tenant_id: &TenantId,
        id: &RecordingId,
        after: i64,
        limit: u32,
    ) -> Result<Vec<Event>, StoreError> {
        let rows = sqlx::query(
            "SELECT seq, at, kind, data FROM recording_events
             WHERE recording_id = $1 AND seq > $2
               AND (SELECT tenant_id FROM recordings WHERE id = recording_events.recording_id) = $3
             ORDER BY seq LIMIT $4",
        )
        .bind(id.as_str())
        .bind(after)
        .bind(tenant_id.as_str())
        .bind(i64::from(limit))
        .fetch_all(&self.readers)
        .await?;
        rows.iter().map(|row| event_of(row, "recording_events")).collect()
    }

    /// Newest events of these recordings, in one query; a recording that is not there is left out. At most some hundred
    /// recordings, since each is a parameter.
    #[boxed]
    pub async fn recording_event_heads(
        &self,
        tenant_id: &TenantId,
        ids: &[RecordingId],
    ) -> Result<Vec<RecordingEventHead>, StoreError> {
        let ids: Vec<&str> = ids.iter().map(RecordingId::as_str).collect();
        let columns = "id, state, CAST(COALESCE((SELECT MAX(seq) FROM recording_events
                                                 WHERE recording_id = recordings.id), 0) AS BIGINT) AS last_seq";
        let rows = rows_of_ids(&self.readers, "recordings", columns, tenant_id, &ids).await?;
        rows.iter()
            .map(|row| {
                let state: String = row.try_get("state")?;
                Ok(RecordingEventHead {
                    id: database::id(row, "recordings", "id")?,
                    last_seq: row.try_get("last_seq")?,
                    state: RecordingState::parse(&state).ok_or_else(|| corrupt(format!("state {state}")))?,
                })
            })
            .collect()
    }
}
