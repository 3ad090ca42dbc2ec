//! The operator's switch: pauses claiming in every process that works on the database, until it is resumed.
//!
//! Paused processes finish the jobs they hold and claim no other. Submissions
//! are accepted meanwhile.

use serde::Serialize;
use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::turns;
use crate::{Operator, StoreError, boxed, database};

/// State of the queue, for operators.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct QueueStatus {
    /// `None` = workers claim jobs.
    pub paused: Option<Pause>,
    /// Jobs that wait, those for a later time included.
    pub queued: i64,
    /// Of them, jobs that wait for a time, such as the end of a backoff.
    pub delayed: i64,
    /// Of them, jobs that have to run alone.
    pub suspects: i64,
    /// Jobs that a worker holds.
    pub active: i64,
    /// Workers that hold jobs.
    pub workers: i64,
    /// Of the jobs, freezes and verifications.
    pub datasets: BackgroundWork,
    /// Of the jobs, attempts of recordings and the assembling of their datasets.
    pub recordings: BackgroundWork,
    /// Age of the job that has waited longest, milliseconds.
    pub oldest_ms: Option<i64>,
    /// Jobs that failed in the last day because their process died again and again.
    pub poisoned: Vec<String>,
}

/// Jobs of one sort.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct BackgroundWork {
    /// Jobs that no worker holds.
    pub queued: i64,
    /// Jobs that a worker holds.
    pub active: i64,
}

/// A pause of claiming.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Pause {
    pub reason: String,
    /// Milliseconds since 1970.
    pub since_ms: i64,
}

impl Operator {
    /// Lets every worker finish the jobs that it holds, and claim no others. Workers notice within `worker.poll_ms`.
    #[boxed]
    pub async fn pause_queue(&mut self, reason: &str) -> Result<(), StoreError> {
        set_paused(&mut self.connection, true, reason).await
    }

    /// Lets workers claim jobs again.
    #[boxed]
    pub async fn resume_queue(&mut self) -> Result<(), StoreError> {
        set_paused(&mut self.connection, false, "").await
    }

    /// The state of the queue.
    #[boxed]
    pub async fn queue_status(&mut self) -> Result<QueueStatus, StoreError> {
        status(&mut self.connection).await
    }
}

/// Pauses or resumes claiming.
pub(super) async fn set_paused(
    connection: &mut AnyConnection,
    paused: bool,
    reason: &str,
) -> Result<(), StoreError> {
    let now = database::now_ms(connection).await?;
    sqlx::query(
        "INSERT INTO switches (name, value, reason, changed_at) VALUES ('claiming', $1, $2, $3)
         ON CONFLICT (name) DO UPDATE SET value = excluded.value, reason = excluded.reason,
             changed_at = excluded.changed_at",
    )
    .bind(if paused { "paused" } else { "running" })
    .bind(reason)
    .bind(now)
    .execute(connection)
    .await?;
    Ok(())
}

pub(super) async fn status(connection: &mut AnyConnection) -> Result<QueueStatus, StoreError> {
    let now = database::now_ms(connection).await?;
    let paused = match turns::is_paused(connection).await? {
        false => None,
        true => {
            let row = sqlx::query("SELECT changed_at, reason FROM switches WHERE name = 'claiming'")
                .fetch_one(&mut *connection)
                .await?;
            Some(Pause { reason: row.try_get("reason")?, since_ms: row.try_get("changed_at")? })
        }
    };
    let row = sqlx::query(
        "SELECT COUNT(*) AS queued, COUNT(CASE WHEN not_before > $1 THEN 1 END) AS delayed,
                COUNT(CASE WHEN shared_deaths + lone_deaths >= 2 THEN 1 END) AS suspects,
                MIN(created_at) AS oldest
         FROM jobs WHERE state = 'queued'",
    )
    .bind(now)
    .fetch_one(&mut *connection)
    .await?;
    let oldest: Option<i64> = row.try_get("oldest")?;
    let active: i64 =
        sqlx::query_scalar("SELECT COUNT(*) FROM jobs WHERE state IN ('running', 'cancelling')")
            .fetch_one(&mut *connection)
            .await?;
    let workers: i64 = sqlx::query_scalar(
        "SELECT COUNT(DISTINCT owner) FROM jobs WHERE state IN ('running', 'cancelling') AND owner IS NOT NULL",
    )
    .fetch_one(&mut *connection)
    .await?;
    let datasets = background(connection, "dataset_id IS NOT NULL").await?;
    let recordings = background(connection, "recording_id IS NOT NULL").await?;
    let poisoned = sqlx::query_scalar(
        "SELECT id FROM jobs WHERE failure_code = 'worker_crashed' AND finished_at > $1 ORDER BY id DESC LIMIT 100",
    )
    .bind(now - 24 * 3_600_000)
    .fetch_all(connection)
    .await?;
    Ok(QueueStatus {
        paused,
        queued: row.try_get("queued")?,
        delayed: row.try_get("delayed")?,
        suspects: row.try_get("suspects")?,
        active,
        workers,
        datasets,
        recordings,
        oldest_ms: oldest.map(|oldest| now - oldest),
        poisoned,
    })
}

/// The jobs that have not ended and meet a condition.
async fn background(
    connection: &mut AnyConnection,
    condition: &'static str,
) -> Result<BackgroundWork, StoreError> {
    // Each condition is that of one index.
    let query = format!(
        "SELECT (SELECT COUNT(*) FROM jobs WHERE state = 'queued' AND {condition}) AS queued,
                (SELECT COUNT(*) FROM jobs WHERE state IN ('running', 'cancelling') AND {condition}) AS active"
    );
    let row = sqlx::query(AssertSqlSafe(query)).fetch_one(connection).await?;
    Ok(BackgroundWork { queued: row.try_get("queued")?, active: row.try_get("active")? })
}
