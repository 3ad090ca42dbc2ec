//! Events of a job, numbered 1, 2, 3, ... within the job.
//!
//! The number comes from the job's row in the same transaction as the change. A reader that has received event `n` has
//! therefore received all earlier events, across restarts.

use serde_json::Value;
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::readers::Readers;
use super::{Store, StoreError, database};
use crate::boxed;
use crate::lifecycle::JobState;
use scene::{JobId, TenantId};

/// One event, of a job or of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// 1, 2, 3, ... within its job or recording.
    pub seq: i64,
    /// Milliseconds since 1970.
    pub at_ms: i64,
    /// `job_queued`, `job_started`, `stage_started`, `stage_finished`, `job_retrying`, ...; of a recording those of
    /// [`crate::recordings::RecordingEventKind`].
    pub kind: String,
    pub data: Value,
}

/// Position of the newest event of a job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EventHead {
    pub job_id: JobId,
    /// Number of the last event; 0 where there is none.
    pub last_seq: i64,
    /// State of the job; after a final one no event follows.
    pub state: JobState,
}

/// Number of the first event of a job.
pub(super) const FIRST_SEQ: i64 = 1;

/// Appends an event inside the caller's transaction.
pub(super) async fn append(
    connection: &mut AnyConnection,
    job_id: &JobId,
    now_ms: i64,
    kind: &str,
    data: &Value,
) -> Result<(), StoreError> {
    let seq: i64 =
        sqlx::query_scalar("UPDATE jobs SET next_seq = next_seq + 1 WHERE id = $1 RETURNING next_seq - 1")
            .bind(job_id.as_str())
            .fetch_one(&mut *connection)
            .await?;
    insert(connection, job_id, seq, now_ms, kind, data).await
}

/// Inserts the event of a number that the caller took from the job's row.
pub(super) async fn insert(
    connection: &mut AnyConnection,
    job_id: &JobId,
    seq: i64,
    now_ms: i64,
    kind: &str,
    data: &Value,
) -> Result<(), StoreError> {
    sqlx::query("INSERT INTO events (job_id, seq, at, kind, data) VALUES ($1, $2, $3, $4, $5)")
        .bind(job_id.as_str())
        .bind(seq)
        .bind(now_ms)
        .bind(kind)
        .bind(data.to_string())
        .execute(connection)
        .await?;
    Ok(())
}

/// The event of a row of `table`.
pub(super) fn event_of(row: &AnyRow, table: &'static str) -> Result<Event, StoreError> {
    let data: String = row.try_get("data")?;
    let corrupt = |error: serde_json::Error| StoreError::Corrupt { table, reason: error.to_string() };
    Ok(Event {
        seq: row.try_get("seq")?,
        at_ms: row.try_get("at")?,
        kind: row.try_get("kind")?,
        data: serde_json::from_str(&data).map_err(corrupt)?,
    })
}

/// Columns of the tenant's rows of `table` with these ids, in one query.
pub(super) async fn rows_of_ids(
    readers: &Readers,
    table: &str,
    columns: &str,
    tenant_id: &TenantId,
    ids: &[&str],
) -> Result<Vec<AnyRow>, StoreError> {
    if ids.is_empty() {
        return Ok(Vec::new());
    }
    let places: Vec<String> = (2..ids.len() + 2).map(|place| format!("${place}")).collect();
    let sql = format!("SELECT {columns} FROM {table} WHERE tenant_id = $1 AND id IN ({})", places.join(", "));
    let query = sqlx::query(AssertSqlSafe(sql)).persistent(false).bind(tenant_id.as_str());
    let query = ids.iter().fold(query, |query, id| query.bind(*id));
    Ok(query.fetch_all(readers).await?)
}

impl Store {
    /// At most `limit` events of a job after number `after`, in order.
    #[boxed]
    pub async fn events(
        &self,
        tenant_id: &TenantId,
        job_id: &JobId,
        after: i64,
        limit: u32,
    ) -> Result<Vec<Event>, StoreError> {
        let rows = sqlx::query(
            "SELECT seq, at, kind, data FROM events
             WHERE job_id = $1 AND seq > $2 AND (SELECT tenant_id FROM jobs WHERE id = events.job_id) = $3
             ORDER BY seq LIMIT $4",
        )
        .bind(job_id.as_str())
        .bind(after)
        .bind(tenant_id.as_str())
        .bind(i64::from(limit))
        .fetch_all(&self.readers)
        .await?;
        rows.iter().map(|row| event_of(row, "events")).collect()
    }

    /// Newest events of these jobs, in one query; a job that is not there is left out. At most some hundred jobs, since
    /// each is a parameter.
    #[boxed]
    pub async fn event_heads(
        &self,
        tenant_id: &TenantId,
        job_ids: &[JobId],
    ) -> Result<Vec<EventHead>, StoreError> {
        let ids: Vec<&str> = job_ids.iter().map(JobId::as_str).collect();
        let columns = "id, next_seq - 1 AS last_seq, state";
        let rows = rows_of_ids(&self.readers, "jobs", columns, tenant_id, &ids).await?;
        rows.iter()
            .map(|row| {
                let state: String = row.try_get("state")?;
                let reason = format!("state {state}");
                Ok(EventHead {
                    job_id: database::id(row, "jobs", "id")?,
                    last_seq: row.try_get("last_seq")?,
                    state: JobState::parse(&state).ok_or(StoreError::Corrupt { table: "jobs", reason })?,
                })
            })
            .collect()
    }
}
