//! Events of a job, numbered 1, 2, 3, ... within the job.
//!
//! The number comes from the job's row in the same transaction as the change. A reader that has received event `n` has
//! therefore received all earlier events, across restarts.

use serde_json::Value;
use sqlx::{Row, SqliteConnection};

use super::{Store, StoreError};
use scene::{JobId, TenantId};

/// One event.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// 1, 2, 3, ... within its job.
    pub seq: i64,
    /// Milliseconds since 1970.
    pub at_ms: i64,
    /// `job_queued`, `job_started`, `stage_started`, `stage_finished`, `job_retrying`, ...
    pub kind: String,
    pub data: Value,
}

/// Appends an event inside the caller's transaction.
pub(super) async fn append(
    connection: &mut SqliteConnection,
    job_id: &JobId,
    now_ms: i64,
    kind: &str,
    data: &Value,
) -> Result<(), StoreError> {
    let seq: i64 =
        sqlx::query_scalar("UPDATE jobs SET next_seq = next_seq + 1 WHERE id = ? RETURNING next_seq - 1")
            .bind(job_id.as_str())
            .fetch_one(&mut *connection)
            .await?;
    sqlx::query("INSERT INTO events (job_id, seq, at, kind, data) VALUES (?, ?, ?, ?, ?)")
        .bind(job_id.as_str())
        .bind(seq)
        .bind(now_ms)
        .bind(kind)
        .bind(data.to_string())
        .execute(connection)
        .await?;
    Ok(())
}

impl Store {
    /// At most `limit` events of a job after number `after`, in order.
    pub async fn events(
        &self,
        tenant_id: &TenantId,
        job_id: &JobId,
        after: i64,
        limit: u32,
    ) -> Result<Vec<Event>, StoreError> {
        let rows = sqlx::query(
            "SELECT seq, at, kind, data FROM events
             WHERE job_id = ? AND seq > ? AND (SELECT tenant_id FROM jobs WHERE id = events.job_id) = ?
             ORDER BY seq LIMIT ?",
        )
        .bind(job_id.as_str())
        .bind(after)
        .bind(tenant_id.as_str())
        .bind(limit)
        .fetch_all(&self.readers)
        .await?;
        rows.into_iter()
            .map(|row| {
                let data: String = row.try_get("data")?;
                Ok(Event {
                    seq: row.try_get("seq")?,
                    at_ms: row.try_get("at")?,
                    kind: row.try_get("kind")?,
                    data: serde_json::from_str(&data).map_err(|error| StoreError::Corrupt {
                        table: "events",
                        reason: error.to_string(),
                    })?,
                })
            })
            .collect()
    }
}
