//! Requests of clients: to freeze a dataset, and to verify a version.

use serde_json::Value;
use sqlx::{AnyConnection, AssertSqlSafe, Row};
use uuid::Uuid;

use super::DatasetState;
use crate::boxed;
use crate::database::Dialect;
use crate::jobs::{JobRow, RetryOutcome};
use crate::lifecycle::{JobKind, JobState};
use crate::limits::{Admission, LimitReached};
use crate::queue::{JobSubject, NewJob, QueueColumns};
use crate::{Digest, Store, StoreError, database};
use scene::{DatasetId, JobId, TenantId};

/// A dataset to be frozen.
#[derive(Clone, Debug)]
pub struct NewDataset {
    pub tenant_id: TenantId,
    pub name: String,
    /// Request of the dataset, as JSON.
    pub request: Value,
    pub idempotency_key: Option<String>,
    pub body_digest: Digest,
}

/// Result of a submission.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SubmitDatasetOutcome {
    Created(DatasetId),
    /// The key was used before with the same body.
    Replayed(DatasetId),
    /// The key was used before with another body; nothing was enqueued.
    KeyReused,
    /// A limit of the tenant leaves no room; nothing was enqueued.
    Refused(LimitReached),
}

/// Result of a request to verify a version.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VerifyOutcome {
    /// Verification that waits, or that is under way already.
    Accepted,
    /// There is no version to verify.
    NotFrozen(DatasetState),
    NotFound,
    /// A limit of the tenant leaves no room.
    Refused(LimitReached),
}

impl Store {
    /// Enqueues a freeze, once for each idempotency key.
    #[boxed]
    pub async fn submit_dataset(&self, new: NewDataset) -> Result<SubmitDatasetOutcome, StoreError> {
        let admission = self.admission.clone();
        let submitted = self
            .writer
            .write("enqueue a dataset", move |connection| {
                Box::pin(async move { submit(connection, new, &admission).await })
            })
            .await?;
        self.announce();
        Ok(submitted)
    }

    /// Enqueues the verification of a version.
    #[boxed]
    pub async fn verify_dataset(
        &self,
        tenant_id: &TenantId,
        id: &DatasetId,
    ) -> Result<VerifyOutcome, StoreError> {
        let (tenant_id, id) = (tenant_id.clone(), id.clone());
        let admission = self.admission.clone();
        let outcome = self
            .writer
            .write("enqueue a verification", move |connection| {
                Box::pin(async move { verify(connection, &tenant_id, &id, &admission).await })
            })
            .await?;
        self.announce();
        Ok(outcome)
    }
}

async fn submit(
    connection: &mut AnyConnection,
    new: NewDataset,
    admission: &Admission,
) -> Result<SubmitDatasetOutcome, StoreError> {
    if let Some(key) = &new.idempotency_key {
        let earlier =
            sqlx::query("SELECT id, body_digest FROM datasets WHERE tenant_id = $1 AND idempotency_key = $2")
                .bind(new.tenant_id.as_str())
                .bind(key)
                .fetch_optional(&mut *connection)
                .await?;
        if let Some(earlier) = earlier {
            let is_same = earlier.try_get::<String, _>("body_digest")? == new.body_digest.as_str();
            let id = database::id(&earlier, "datasets", "id")?;
            return Ok(if is_same {
                SubmitDatasetOutcome::Replayed(id)
            } else {
                SubmitDatasetOutcome::KeyReused
            });
        }
    }
    let now = database::now_ms(connection).await?;
    if let Err(reached) = admission.work(connection, &new.tenant_id, now).await? {
        return Ok(SubmitDatasetOutcome::Refused(reached));
    }
    let columns = QueueColumns::of_new(None, &new.request, now);
    let id: DatasetId = database::parse_id(&Uuid::now_v7().to_string(), "datasets")?;
    sqlx::query(
        "INSERT INTO datasets (id, tenant_id, name, state, request, idempotency_key, body_digest, created_at)
         VALUES ($1, $2, $3, 'queued', $4, $5, $6, $7)",
    )
    .bind(id.as_str())
    .bind(new.tenant_id.as_str())
    .bind(&new.name)
    .bind(new.request.to_string())
    .bind(new.idempotency_key)
    .bind(new.body_digest.as_str())
    .bind(now)
    .execute(&mut *connection)
    .await?;
    let key = exclusive_key(&new.name);
    let freeze = NewJob {
        exclusive_key: Some(&key),
        ..NewJob::new(&new.tenant_id, JobKind::FreezeDataset, JobSubject::Dataset(&id), columns)
    };
    enqueue(connection, freeze, &id, now).await?;
    Ok(SubmitDatasetOutcome::Created(id))
}

async fn verify(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    id: &DatasetId,
    admission: &Admission,
) -> Result<VerifyOutcome, StoreError> {
    let lock = Dialect::of(connection).lock();
    let query =
        format!("SELECT state FROM datasets WHERE id = $1 AND tenant_id = $2 AND deleted_at IS NULL {lock}");
    let state: Option<String> = sqlx::query_scalar(AssertSqlSafe(query))
        .bind(id.as_str())
        .bind(tenant_id.as_str())
        .fetch_optional(&mut *connection)
        .await?;
    let Some(state) = state.as_deref().and_then(DatasetState::parse) else {
        return Ok(VerifyOutcome::NotFound);
    };
    if state != DatasetState::Finished {
        return Ok(VerifyOutcome::NotFrozen(state));
    }
    // The row is locked, so that its state stays.
    let is_idle: Option<i64> = sqlx::query_scalar(
        "SELECT CAST(1 AS BIGINT) FROM datasets
         WHERE id = $1 AND (verify_state IS NULL OR verify_state = 'finished')",
    )
    .bind(id.as_str())
    .fetch_optional(&mut *connection)
    .await?;
    if is_idle.is_some() {
        let now = database::now_ms(connection).await?;
        if let Err(reached) = admission.work(connection, tenant_id, now).await? {
            return Ok(VerifyOutcome::Refused(reached));
        }
        sqlx::query("UPDATE datasets SET verify_state = 'queued' WHERE id = $1")
            .bind(id.as_str())
            .execute(&mut *connection)
            .await?;
        let columns = QueueColumns::of_new(None, &Value::Null, now);
        let verification = NewJob::new(tenant_id, JobKind::VerifyDataset, JobSubject::Dataset(id), columns);
        enqueue(connection, verification, id, now).await?;
    }
    Ok(VerifyOutcome::Accepted)
}

/// Repeats the ended job of a dataset: a freeze that made no version, or a verification that was given up.
pub(crate) async fn retry(
    connection: &mut AnyConnection,
    ended: &JobRow,
    tenant_id: &TenantId,
    admission: Option<&Admission>,
    now_ms: i64,
) -> Result<RetryOutcome, StoreError> {
    let Some(id) = &ended.dataset_id else { return Ok(RetryOutcome::NotFound) };
    let lock = Dialect::of(connection).lock();
    let query = format!("SELECT name, state, job_id, deleted_at FROM datasets WHERE id = $1 {lock}");
    let row = sqlx::query(AssertSqlSafe(query)).bind(id.as_str()).fetch_one(&mut *connection).await?;
    let newest: Option<JobId> = database::optional_id(&row, "datasets", "job_id")?;
    let is_deleted = row.try_get::<Option<i64>, _>("deleted_at")?.is_some();
    if is_deleted || newest.as_ref() != Some(&ended.id) || ended.state == JobState::Succeeded {
        return Ok(RetryOutcome::NothingToRepeat);
    }
    if !ended.state.is_final() {
        return Ok(RetryOutcome::StillActive);
    }
    if let Some(admission) = admission
        && let Err(reached) = admission.work(connection, tenant_id, now_ms).await?
    {
        return Ok(RetryOutcome::Refused(reached));
    }
    let is_freeze = ended.kind == JobKind::FreezeDataset;
    let restart = match is_freeze {
        true => {
            "UPDATE datasets SET state = 'queued', failure_code = NULL, failure_message = NULL, finished_at = NULL
             WHERE id = $1"
        }
        false => "UPDATE datasets SET verify_state = 'queued' WHERE id = $1",
    };
    sqlx::query(restart).bind(id.as_str()).execute(&mut *connection).await?;
    let key = exclusive_key(&row.try_get::<String, _>("name")?);
    let columns = QueueColumns::of_retry(connection, &ended.id, now_ms).await?;
    let again = NewJob {
        retry_of: Some(&ended.id),
        exclusive_key: is_freeze.then_some(key.as_str()),
        ..NewJob::new(tenant_id, ended.kind, JobSubject::Dataset(id), columns)
    };
    let job_id = enqueue(connection, again, id, now_ms).await?;
    Ok(RetryOutcome::Created { job_id })
}

/// Inserts the job of a dataset, which is then its newest.
async fn enqueue(
    connection: &mut AnyConnection,
    job: NewJob<'_>,
    id: &DatasetId,
    now_ms: i64,
) -> Result<JobId, StoreError> {
    let job = job.insert(connection, now_ms).await?;
    sqlx::query("UPDATE datasets SET job_id = $1, steps_done = 0, steps_all = 0 WHERE id = $2")
        .bind(job.id.as_str())
        .bind(id.as_str())
        .execute(connection)
        .await?;
    Ok(job.id)
}

/// Freezes of one name follow each other, so that every version has another number.
fn exclusive_key(name: &str) -> String {
    format!("dataset {name}")
}
