//! Jobs that vendors work on: submitted by a call of the ledger, fetched later, by this worker or the one after it.

use sqlx::Row;

use super::queue::guard;
use super::{Digest, Lease, Store, StoreError};
use scene::job::JobState;

/// A vendor's job that is not over.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskRow {
    /// The call that submitted it.
    pub call_id: i64,
    /// The vendor's id.
    pub task: String,
    /// What came of it, once fetched.
    pub file: Option<Digest>,
}

/// What became of a vendor's job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TaskEnd {
    /// The blob that was fetched.
    Fetched(Digest),
    /// Nothing more comes of it.
    Over,
}

impl Store {
    /// The newest vendor's job of a question in a job, unless it is over.
    pub async fn task_of(&self, job_id: &str, idempotency_key: &str) -> Result<Option<TaskRow>, StoreError> {
        let row = sqlx::query(
            "SELECT id, task, task_file FROM calls
             WHERE job_id = ? AND idempotency_key = ? AND task_state IN ('submitted', 'fetched')
             ORDER BY id DESC LIMIT 1",
        )
        .bind(job_id)
        .bind(idempotency_key)
        .fetch_optional(&self.readers)
        .await?;
        let Some(row) = row else { return Ok(None) };
        let file: Option<String> = row.try_get("task_file")?;
        let file = file.map(|digest| Digest::parse(&digest)).transpose()?;
        Ok(Some(TaskRow { call_id: row.try_get("id")?, task: row.try_get("task")?, file }))
    }

    /// Writes down what became of a vendor's job.
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
                        "UPDATE calls SET task_state = ?, task_file = ?
                         WHERE id = ? AND job_id = ? AND task IS NOT NULL",
                    )
                    .bind(state)
                    .bind(file)
                    .bind(call_id)
                    .bind(&lease.job_id)
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            })
            .await
    }

    /// Whether somebody has asked for a job to be cancelled.
    pub async fn is_cancelled(&self, job_id: &str) -> Result<bool, StoreError> {
        let state: Option<String> = sqlx::query_scalar("SELECT state FROM jobs WHERE id = ?")
            .bind(job_id)
            .fetch_optional(&self.readers)
            .await?;
        let state = state.and_then(|state| JobState::parse(&state));
        Ok(matches!(state, Some(JobState::Cancelling | JobState::Cancelled)))
    }
}
