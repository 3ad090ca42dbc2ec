//! Stage keys in progress, so that two jobs compute, and pay for, the result of one key once.
//!
//! A job claims a key in the transaction that starts the stage. The claim counts while the job holds the lease of that
//! epoch: it ends when the stage is committed or given up, when the job leaves its worker, and when another worker has
//! taken the job over. An expired lease alone does not end it, because its worker may still write until the job is
//! rescued.

use sqlx::AnyConnection;

use super::checkpoints::StageKey;
use super::queue::guard;
use super::{Lease, Store, StoreError};
use crate::boxed;
use scene::{JobId, TenantId};

/// Result of starting a stage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StageStart {
    /// The job has the key and computes.
    Granted,
    /// The job that computes the key at present.
    ComputedBy(JobId),
}

impl Store {
    /// The job that computes a key at present, other than that of the lease.
    #[boxed]
    pub async fn stage_computed_by(
        &self,
        lease: &Lease,
        stage: &StageKey,
    ) -> Result<Option<JobId>, StoreError> {
        let read = async { holder(&mut *self.readers.acquire().await?, lease, stage).await };
        self.readers.within_limit(read).await
    }

    /// Gives up a key whose stage failed, so that waiting jobs need not wait for the end of this one.
    #[boxed]
    pub async fn release_stage(&self, lease: &Lease, stage: &StageKey) -> Result<(), StoreError> {
        let (lease, stage) = (lease.clone(), stage.clone());
        self.writer
            .write("give up a stage", move |connection| {
                Box::pin(async move {
                    guard(connection, &lease).await?;
                    release(connection, &stage.tenant_id, stage.key.as_str(), &lease.job_id).await
                })
            })
            .await?;
        self.announce();
        Ok(())
    }
}

/// Claims a key for the job of a valid lease.
pub(super) async fn claim(
    connection: &mut AnyConnection,
    lease: &Lease,
    stage: &StageKey,
    now_ms: i64,
) -> Result<StageStart, StoreError> {
    if let Some(job_id) = holder(connection, lease, stage).await? {
        return Ok(StageStart::ComputedBy(job_id));
    }
    // What is left is no row, a row of this job, or a row of a job that has lost its lease.
    let claimed = sqlx::query(
        "INSERT INTO stage_claims (tenant_id, key, job_id, epoch, claimed_at) VALUES ($1, $2, $3, $4, $5)
         ON CONFLICT (tenant_id, key) DO UPDATE
         SET job_id = excluded.job_id, epoch = excluded.epoch, claimed_at = excluded.claimed_at
         WHERE stage_claims.job_id = excluded.job_id OR NOT EXISTS (
             SELECT 1 FROM jobs WHERE jobs.id = stage_claims.job_id AND jobs.epoch = stage_claims.epoch
                                  AND jobs.state IN ('running', 'cancelling'))",
    )
    .bind(stage.tenant_id.as_str())
    .bind(stage.key.as_str())
    .bind(lease.job_id.as_str())
    .bind(lease.epoch)
    .bind(now_ms)
    .execute(&mut *connection)
    .await?
    .rows_affected();
    if claimed > 0 {
        return Ok(StageStart::Granted);
    }
    // Another transaction was faster.
    let holder = holder(connection, lease, stage).await?;
    Ok(StageStart::ComputedBy(holder.unwrap_or_else(|| lease.job_id.clone())))
}

async fn holder(
    connection: &mut AnyConnection,
    lease: &Lease,
    stage: &StageKey,
) -> Result<Option<JobId>, StoreError> {
    let id: Option<String> = sqlx::query_scalar(
        "SELECT jobs.id FROM stage_claims JOIN jobs ON jobs.id = stage_claims.job_id
         WHERE stage_claims.tenant_id = $1 AND stage_claims.key = $2 AND jobs.id <> $3
           AND jobs.epoch = stage_claims.epoch AND jobs.state IN ('running', 'cancelling')",
    )
    .bind(stage.tenant_id.as_str())
    .bind(stage.key.as_str())
    .bind(lease.job_id.as_str())
    .fetch_optional(connection)
    .await?;
    id.map(|id| super::database::parse_id(&id, "stage_claims")).transpose()
}

/// Ends a job's claim of a key.
pub(super) async fn release(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    key: &str,
    job_id: &JobId,
) -> Result<(), StoreError> {
    sqlx::query("DELETE FROM stage_claims WHERE tenant_id = $1 AND key = $2 AND job_id = $3")
        .bind(tenant_id.as_str())
        .bind(key)
        .bind(job_id.as_str())
        .execute(connection)
        .await?;
    Ok(())
}

/// Ends all claims of a job that leaves its worker.
pub(super) async fn release_all(connection: &mut AnyConnection, job_id: &JobId) -> Result<(), StoreError> {
    sqlx::query("DELETE FROM stage_claims WHERE job_id = $1")
        .bind(job_id.as_str())
        .execute(connection)
        .await?;
    Ok(())
}
