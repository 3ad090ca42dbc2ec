//! Asynchronous jobs of vendors: submitted by a call of the ledger, fetched later by this worker or its successor.

use sqlx::Row;

use super::queue::guard;
use super::{Digest, Lease, Store, StoreError};
use crate::boxed;
use crate::lifecycle::JobState;
use scene::JobId;

/// A vendor's job that has not ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskRow {
    /// The call that submitted it.
    pub call_id: i64,
    /// The vendor's id.
    pub task: String,
    /// The blob with its result, once fetched.
    pub file: Option<Digest>,
}

/// End of a vendor's job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TaskEnd {
    /// The blob that was fetched.
    Fetched(Digest),
    /// End without a usable result.
    Over,
}

impl Store {
    /// The newest vendor's job of a question of a job, unless it has ended.
    #[boxed]
    pub async fn task_of(
        &self,
        job_id: &JobId,
        idempotency_key: &str,
    ) -> Result<Option<TaskRow>, StoreError> {
        let row = sqlx::query(
            "SELECT id, task, task_file FROM calls
             WHERE job_id = $1 AND idempotency_key = $2 AND task_state IN ('submitted', 'fetched')
             ORDER BY id DESC LIMIT 1",
        )
        .bind(job_id.as_str())
        .bind(idempotency_key)
        .fetch_optional(&self.readers)
        .await?;
        let Some(row) = row else { return Ok(None) };
        let file: Option<String> = row.try_get("task_file")?;
        let file = file.map(|digest| Digest::parse(&digest)).transpose()?;
        Ok(Some(TaskRow { call_id: row.try_get("id")?, task: row.try_get("task")?, file }))
    }

    /// Records the end of a vendor's job.
    #[boxed]
    pub async fn note_task(&self, lease: &Lease, call_id: i64, end: TaskEnd) -> Result<(), StoreError> {
        let lease = lease.clone();
        self.writer
            .write("note a vendor's job", move |connection| {
                Box::pin(async move {
                    guard(connection, &lease).await?;
                    let (state, file) = match &end {
                        TaskEnd::Fetched(digest) => ("fetched", Some(digest.as_str())),
                        TaskEnd::Over => ("over", None),
                    };
                    sqlx::query(
                        "UPDATE calls SET task_state = $1, task_file = $2
                         WHERE id = $3 AND job_id = $4 AND task IS NOT NULL",
                    )
                    .bind(state)
                    .bind(file)
                    .bind(call_id)
                    .bind(lease.job_id.as_str())
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            })
            .await
    }

    /// Whether cancellation of a job has been requested.
    #[boxed]
    pub async fn is_cancelled(&self, job_id: &JobId) -> Result<bool, StoreError> {
        let state: Option<String> = sqlx::query_scalar("SELECT state FROM jobs WHERE id = $1")
            .bind(job_id.as_str())
            .fetch_optional(&self.readers)
            .await?;
        let state = state.and_then(|state| JobState::parse(&state));
        Ok(matches!(state, Some(JobState::Cancelling | JobState::Cancelled)))
    }
}
