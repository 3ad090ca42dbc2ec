//! Executions: tasks that a simulated robot does in a finished scene. The execution is its job, with the job's id,
//! state, events and failure; a row beside it has the request, and the answer once there is one.

use std::collections::HashMap;

use serde_json::Value;
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::limits::{Admission, LimitReached};
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
    /// The client's idempotency key, and a digest of the request.
    pub idempotency: Option<(String, Digest)>,
}

/// Result of a submission.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SubmitExecutionOutcome {
    Created(JobId),
    /// The key was used before with the same request.
    Replayed(JobId),
    /// The key was used before with another request; nothing was enqueued.
    KeyReused,
    /// A limit of the tenant leaves no room; nothing was enqueued.
    Refused(LimitReached),
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
    /// Enqueues an execution, once for each idempotency key.
    #[boxed]
    pub async fn submit_execution(&self, new: NewExecution) -> Result<SubmitExecutionOutcome, StoreError> {
        let admission = self.admission.clone();
        let submitted = self
            .writer
            .write("enqueue an execution", move |connection| {
                Box::pin(async move { submit(connection, &new, &admission).await })
            })
            .await?;
        self.announce();
        Ok(submitted)
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

    /// The scenes in which tasks are executed, by the job of the execution; other jobs have no entry.
    #[boxed]
    pub async fn executed_scenes(
        &self,
        tenant_id: &TenantId,
        jobs: &[JobId],
    ) -> Result<HashMap<JobId, SceneId>, StoreError> {
        if jobs.is_empty() {
            return Ok(HashMap::new());
        }
        let list: Vec<String> = (0..jobs.len()).map(|index| format!("${}", index + 2)).collect();
        let sql = format!(
            "SELECT job_id, scene_id FROM executions WHERE tenant_id = $1 AND job_id IN ({})",
            list.join(", ")
        );
        let query = sqlx::query(AssertSqlSafe(sql)).bind(tenant_id.as_str());
        let query = jobs.iter().fold(query, |query, id| query.bind(id.as_str()));
        let rows = query.fetch_all(&self.readers).await?;
        let ids = |row| {
            let scene = database::id(row, "executions", "scene_id")?;
            Ok((database::id(row, "executions", "job_id")?, scene))
        };
        rows.iter().map(ids).collect()
    }
}

async fn submit(
    connection: &mut AnyConnection,
    new: &NewExecution,
    admission: &Admission,
) -> Result<SubmitExecutionOutcome, StoreError> {
    if let Some((key, body_digest)) = &new.idempotency
        && let Some((earlier, earlier_digest)) = by_key(connection, &new.tenant_id, key).await?
    {
        return Ok(match earlier_digest == body_digest.as_str() {
            true => SubmitExecutionOutcome::Replayed(earlier),
            false => SubmitExecutionOutcome::KeyReused,
        });
    }
    let now = database::now_ms(connection).await?;
    if let Err(reached) = admission.work(connection, &new.tenant_id, now).await? {
        return Ok(SubmitExecutionOutcome::Refused(reached));
    }
    let columns = QueueColumns::of_new(None, &new.request, now);
    let job =
        NewJob::new(&new.tenant_id, JobKind::ExecuteTask, JobSubject::Execution(&new.scene_id), columns);
    let job = job.insert(connection, now).await?;
    sqlx::query(
        "INSERT INTO executions (job_id, tenant_id, scene_id, request, bundle, idempotency_key, body_digest)
         VALUES ($1, $2, $3, $4, $5, $6, $7)",
    )
    .bind(job.id.as_str())
    .bind(new.tenant_id.as_str())
    .bind(new.scene_id.as_str())
    .bind(new.request.to_string())
    .bind(new.bundle.as_str())
    .bind(new.idempotency.as_ref().map(|(key, _)| key))
    .bind(new.idempotency.as_ref().map(|(_, digest)| digest.as_str()))
    .execute(connection)
    .await?;
    Ok(SubmitExecutionOutcome::Created(job.id))
}

/// The execution that a tenant asked for with a key, and the digest of that request.
async fn by_key(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    key: &str,
) -> Result<Option<(JobId, String)>, StoreError> {
    let row = sqlx::query(
        "SELECT job_id, body_digest FROM executions WHERE tenant_id = $1 AND idempotency_key = $2",
    )
    .bind(tenant_id.as_str())
    .bind(key)
    .fetch_optional(connection)
    .await?;
    row.map(|row| Ok((database::id(&row, "executions", "job_id")?, row.try_get("body_digest")?))).transpose()
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
