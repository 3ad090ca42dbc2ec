//! What happened to a job, as rows numbered 1, 2, 3, ... within the job.
//!
//! The number is taken from the job's own row inside the transaction that makes the change, so a reader
//! who has seen `n` has seen everything before it, across any restart.

use serde_json::Value;
use sqlx::{Row, SqliteConnection};

use super::{Store, StoreError};

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

/// Appends inside the caller's transaction.
pub(super) async fn append(
    connection: &mut SqliteConnection,
    job_id: &str,
    now_ms: i64,
    kind: &str,
    data: &Value,
) -> Result<(), StoreError> {
    let seq: i64 =
        sqlx::query_scalar("UPDATE jobs SET next_seq = next_seq + 1 WHERE id = ? RETURNING next_seq - 1")
            .bind(job_id)
            .fetch_one(&mut *connection)
            .await?;
    sqlx::query("INSERT INTO events (job_id, seq, at, kind, data) VALUES (?, ?, ?, ?, ?)")
        .bind(job_id)
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
    pub async fn events(&self, job_id: &str, after: i64, limit: u32) -> Result<Vec<Event>, StoreError> {
        let rows = sqlx::query(
            "SELECT seq, at, kind, data FROM events WHERE job_id = ? AND seq > ? ORDER BY seq LIMIT ?",
        )
        .bind(job_id)
        .bind(after)
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
