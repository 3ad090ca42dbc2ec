//! Changes of a dataset while its job runs, and when that ends. Each function is a part of the transaction that changes
//! the job.

use serde_json::Value;
use sqlx::AnyConnection;

use super::{DatasetRow, dataset_of};
use crate::lifecycle::JobState;
use crate::{StoreError, database};
use scene::{DatasetId, JobId};

/// A version whose files are recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct FrozenVersion {
    pub version: i64,
    /// Digest of the manifest, as the manifest states it.
    pub digest: String,
    /// For clients, as JSON.
    pub summary: Value,
    /// Paths of the files; others that an interrupted freeze recorded are dropped.
    pub paths: Vec<String>,
}

/// A dataset whose job was claimed; its steps count from 0.
pub(crate) async fn begun(connection: &mut AnyConnection, id: &DatasetId) -> Result<DatasetRow, StoreError> {
    let row = sqlx::query("UPDATE datasets SET steps_done = 0, steps_all = 0 WHERE id = $1 RETURNING *")
        .bind(id.as_str())
        .fetch_one(connection)
        .await?;
    dataset_of(&row)
}

/// A dataset that is not frozen, and a verification that is not finished, have the state of their job.
pub(crate) async fn follow(
    connection: &mut AnyConnection,
    id: &DatasetId,
    job: JobState,
) -> Result<(), StoreError> {
    let state = match job {
        JobState::Queued => "queued",
        JobState::Running => "running",
        _ => return Ok(()),
    };
    sqlx::query(
        "UPDATE datasets
         SET state = CASE WHEN state IN ('queued', 'running') THEN $1 ELSE state END,
             verify_state = CASE WHEN verify_state IN ('queued', 'running') THEN $1 ELSE verify_state END
         WHERE id = $2",
    )
    .bind(state)
    .bind(id.as_str())
    .execute(connection)
    .await?;
    Ok(())
}

/// Records the version that a freeze made.
pub(crate) async fn record_version(
    connection: &mut AnyConnection,
    job_id: &JobId,
    frozen: &FrozenVersion,
    now_ms: i64,
) -> Result<(), StoreError> {
    let row = sqlx::query(
        "UPDATE datasets SET state = 'finished', version = $1, digest = $2, summary = $3, finished_at = $4
         WHERE id = (SELECT dataset_id FROM jobs WHERE id = $5) RETURNING id",
    )
    .bind(frozen.version)
    .bind(&frozen.digest)
    .bind(frozen.summary.to_string())
    .bind(now_ms)
    .bind(job_id.as_str())
    .fetch_one(&mut *connection)
    .await?;
    let id: DatasetId = database::id(&row, "datasets", "id")?;
    keep_files(connection, &id, &frozen.paths).await
}

/// Records what a verification found.
pub(crate) async fn record_verification(
    connection: &mut AnyConnection,
    job_id: &JobId,
    found: &Value,
) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE datasets SET verify_state = 'finished', verification = $1
         WHERE id = (SELECT dataset_id FROM jobs WHERE id = $2)",
    )
    .bind(found.to_string())
    .bind(job_id.as_str())
    .execute(connection)
    .await?;
    Ok(())
}

/// Ends the dataset of a failed or cancelled job: a freeze leaves no version, a verification leaves the version as it
/// was.
pub(crate) async fn fail(
    connection: &mut AnyConnection,
    id: &DatasetId,
    code: &str,
    message: &str,
    now_ms: i64,
) -> Result<(), StoreError> {
    let freeze = sqlx::query(
        "UPDATE datasets SET state = 'failed', failure_code = $1, failure_message = $2, finished_at = $3
         WHERE id = $4 AND state IN ('queued', 'running')",
    )
    .bind(code)
    .bind(message)
    .bind(now_ms)
    .bind(id.as_str())
    .execute(&mut *connection)
    .await?;
    if freeze.rows_affected() > 0 {
        return keep_files(connection, id, &[]).await;
    }
    sqlx::query("UPDATE datasets SET verify_state = NULL WHERE id = $1 AND verify_state <> 'finished'")
        .bind(id.as_str())
        .execute(connection)
        .await?;
    Ok(())
}

/// Drops the rows of all other files of a dataset.
async fn keep_files(
    connection: &mut AnyConnection,
    id: &DatasetId,
    paths: &[String],
) -> Result<(), StoreError> {
    let recorded: Vec<String> = sqlx::query_scalar("SELECT path FROM dataset_files WHERE dataset_id = $1")
        .bind(id.as_str())
        .fetch_all(&mut *connection)
        .await?;
    for path in recorded.iter().filter(|path| !paths.contains(path)) {
        sqlx::query("DELETE FROM dataset_files WHERE dataset_id = $1 AND path = $2")
            .bind(id.as_str())
            .bind(path)
            .execute(&mut *connection)
            .await?;
    }
    Ok(())
}
