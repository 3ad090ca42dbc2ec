//! Executions: tasks that a simulated robot does in a finished scene. The execution is its job, with the job's id,
//! state, events and failure; a row beside it has the request, and the answer once there is one.

use serde_json::Value;
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, Row};

use super::queue::{JobSubject, NewJob, QueueColumns};
use super::{Digest, Store, StoreError, database};
use crate::boxed;
use crate::lifecycle::JobKind;
use scene::{JobId, SceneId, TenantId};

/// An execution to be enqueued.
#[derive(Clone, Debug)]
pub struct NewExecution {
    pub tenant_id: TenantId,
    pub scene_id: SceneId,
    /// The versioned request, as JSON.
    pub request: Value,
    /// The blob of the scene's archive.
    pub bundle: Digest,
}

/// An execution's row.
#[derive(Clone, Debug, PartialEq)]
pub struct ExecutionRow {
    pub scene_id: SceneId,
    /// The versioned request, as JSON.
    pub request: Value,
    /// The blob of the scene's archive.
    pub bundle: Digest,
    pub answer: Option<ExecutionAnswer>,
}

/// The answer of an execution, done or failed: a blob.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExecutionAnswer {
    pub digest: Digest,
    pub media_type: String,
    /// Bytes.
    pub size: u64,
}

impl Store {
    /// Enqueues an execution.
    #[boxed]
    pub async fn submit_execution(&self, new: NewExecution) -> Result<JobId, StoreError> {
        let job_id = self
            .writer
            .write("enqueue an execution", move |connection| {
                Box::pin(async move { submit(connection, &new).await })
            })
            .await?;
        self.announce();
        Ok(job_id)
    }

    /// An execution of the tenant.
    #[boxed]
    pub async fn execution(
        &self,
        tenant_id: &TenantId,
        job_id: &JobId,
    ) -> Result<Option<ExecutionRow>, StoreError> {
        let row = sqlx::query("SELECT * FROM executions WHERE job_id = $1 AND tenant_id = $2")
            .bind(job_id.as_str())
            .bind(tenant_id.as_str())
            .fetch_optional(&self.readers)
            .await?;
        row.as_ref().map(execution_of).transpose()
    }
}

async fn submit(connection: &mut AnyConnection, new: &NewExecution) -> Result<JobId, StoreError> {
    let now = database::now_ms(connection).await?;
    let columns = QueueColumns::of_new(None, &new.request, now);
    let job =
        NewJob::new(&new.tenant_id, JobKind::ExecuteTask, JobSubject::Execution(&new.scene_id), columns);
    let job = job.insert(connection, now).await?;
    sqlx::query(
        "INSERT INTO executions (job_id, tenant_id, scene_id, request, bundle) VALUES ($1, $2, $3, $4, $5)",
    )
    .bind(job.id.as_str())
    .bind(new.tenant_id.as_str())
    .bind(new.scene_id.as_str())
    .bind(new.request.to_string())
    .bind(new.bundle.as_str())
    .execute(connection)
    .await?;
    Ok(job.id)
}

/// The execution of a claimed job.
pub(super) async fn begun(
    connection: &mut AnyConnection,
    job_id: &JobId,
) -> Result<ExecutionRow, StoreError> {
    let row = sqlx::query("SELECT * FROM executions WHERE job_id = $1")
        .bind(job_id.as_str())
        .fetch_one(connection)
        .await?;
    execution_of(&row)
}

/// Records the answer of a job that has succeeded.
pub(super) async fn record_answer(
    connection: &mut AnyConnection,
    job_id: &JobId,
    answer: &ExecutionAnswer,
) -> Result<(), StoreError> {
    sqlx::query("UPDATE executions SET answer = $1, media_type = $2, size = $3 WHERE job_id = $4")
        .bind(answer.digest.as_str())
        .bind(&answer.media_type)
        .bind(i64::try_from(answer.size).unwrap_or(i64::MAX))
        .bind(job_id.as_str())
        .execute(connection)
        .await?;
    Ok(())
}

fn execution_of(row: &AnyRow) -> Result<ExecutionRow, StoreError> {
    let corrupt = |reason: String| StoreError::Corrupt { table: "executions", reason };
    let request: String = row.try_get("request")?;
    let digest: Option<String> = row.try_get("answer")?;
    let answer = match digest {
        Some(digest) => Some(ExecutionAnswer {
            digest: Digest::parse(&digest)?,
            media_type: row.try_get::<Option<String>, _>("media_type")?.unwrap_or_default(),
            size: u64::try_from(row.try_get::<Option<i64>, _>("size")?.unwrap_or(0)).unwrap_or(0),
        }),
        None => None,
    };
    Ok(ExecutionRow {
        scene_id: database::id(row, "executions", "scene_id")?,
        request: serde_json::from_str(&request).map_err(|error| corrupt(error.to_string()))?,
        bundle: Digest::parse(&row.try_get::<String, _>("bundle")?)?,
        answer,
    })
}
