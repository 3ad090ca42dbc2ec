//! Cancellation and retry of a batch.

use ::batches::{BatchState, OutputError};
use sqlx::AnyConnection;

use super::{BatchRow, admission, error_text, expansion, locked};
use crate::boxed;
use crate::limits::{self, LimitReached, LimitSettings};
use crate::{Store, StoreError, database, queue};
use scene::{BatchId, JobId, MicroUsd, TenantId};

/// Result of a request to cancel a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BatchCancelOutcome {
    Accepted,
    /// The batch had ended already.
    TooLate(BatchState),
    NotFound,
}

/// Result of a request to retry a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BatchRetryOutcome {
    /// So many items wait again.
    Accepted(u64),
    /// No item has failed or was cancelled.
    NothingToRetry,
    /// Items of a cancelled batch have not stopped yet.
    StillCancelling,
    NotFound,
    /// A limit of the tenant leaves no room; nothing waits again.
    Refused(LimitReached),
}

impl Store {
    /// Cancels a batch: pending items at once, and the jobs of the others.
    #[boxed]
    pub async fn cancel_batch(
        &self,
        tenant_id: &TenantId,
        id: &BatchId,
    ) -> Result<BatchCancelOutcome, StoreError> {
        let (tenant_id, id) = (tenant_id.clone(), id.clone());
        let cancelled = self
            .writer
            .unhurried()
            .write("cancel a batch", move |connection| {
                Box::pin(async move { cancel(connection, &tenant_id, &id).await })
            })
            .await?;
        self.announce_cancellation();
        Ok(cancelled)
    }

    /// Lets the items that failed or were cancelled wait again, with another budget if one is given. Finished stages
    /// of their scenes are reused.
    #[boxed]
    pub async fn retry_batch(
        &self,
        tenant_id: &TenantId,
        id: &BatchId,
        budget: Option<MicroUsd>,
    ) -> Result<BatchRetryOutcome, StoreError> {
        let (tenant_id, id) = (tenant_id.clone(), id.clone());
        let limits = *self.admission.settings();
        let retried = self
            .writer
            .unhurried()
            .write("retry a batch", move |connection| {
                Box::pin(async move { retry(connection, &tenant_id, &id, budget, &limits).await })
            })
            .await?;
        self.announce();
        Ok(retried)
    }
}

async fn cancel(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    id: &BatchId,
) -> Result<BatchCancelOutcome, StoreError> {
    let Some(batch) = of_tenant(connection, tenant_id, id).await? else {
        return Ok(BatchCancelOutcome::NotFound);
    };
    if batch.state.is_final() {
        return Ok(BatchCancelOutcome::TooLate(batch.state));
    }
    let now = database::now_ms(connection).await?;
    cancel_items(connection, &batch, now).await?;
    Ok(BatchCancelOutcome::Accepted)
}

/// Locks a batch of the tenant that is not deleted.
async fn of_tenant(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    id: &BatchId,
) -> Result<Option<BatchRow>, StoreError> {
    let batch = locked(connection, id).await?;
    Ok(batch.filter(|batch| batch.tenant_id == *tenant_id && !batch.is_deleted))
}

/// Cancels the pending items of a locked batch, and the jobs of the others.
pub(super) async fn cancel_items(
    connection: &mut AnyConnection,
    batch: &BatchRow,
    now_ms: i64,
) -> Result<(), StoreError> {
    let id = &batch.id;
    let message = "the batch was cancelled before the request began; retry the batch to make its scene";
    sqlx::query(
        "UPDATE batch_items SET state = 'cancelled', error = $1, settled_at = $2
         WHERE batch_id = $3 AND state = 'pending'",
    )
    .bind(error_text(&OutputError::new("cancelled", message)))
    .bind(now_ms)
    .bind(id.as_str())
    .execute(&mut *connection)
    .await?;
    expansion::stop(connection, id).await?;
    sqlx::query("UPDATE batches SET state = 'cancelling' WHERE id = $1")
        .bind(id.as_str())
        .execute(&mut *connection)
        .await?;
    let jobs: Vec<String> = sqlx::query_scalar(
        "SELECT job_id FROM batch_items WHERE batch_id = $1 AND state = 'submitted' ORDER BY job_id",
    )
    .bind(id.as_str())
    .fetch_all(&mut *connection)
    .await?;
    for job in jobs {
        let job_id: JobId = database::parse_id(&job, "batch_items")?;
        // A job that has ended already keeps its result.
        queue::cancel(connection, batch.tenant_id.clone(), job_id).await?;
    }
    Ok(())
}

async fn retry(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    id: &BatchId,
    budget: Option<MicroUsd>,
    limits: &LimitSettings,
) -> Result<BatchRetryOutcome, StoreError> {
    // Before the batch is locked, as submissions lock it before all else.
    limits::one_at_a_time(connection, &limits::submissions_of(tenant_id)).await?;
    let Some(batch) = of_tenant(connection, tenant_id, id).await? else {
        return Ok(BatchRetryOutcome::NotFound);
    };
    if batch.state == BatchState::Cancelling {
        return Ok(BatchRetryOutcome::StillCancelling);
    }
    let requests = admission::repeatable(connection, id).await?;
    if requests == 0 {
        return Ok(BatchRetryOutcome::NothingToRetry);
    }
    let now = database::now_ms(connection).await?;
    if let Some(reached) = admission::full(connection, tenant_id, limits, requests, now).await? {
        return Ok(BatchRetryOutcome::Refused(reached));
    }
    let waiting = sqlx::query(
        "UPDATE batch_items SET state = 'pending', error = NULL, settled_at = NULL
         WHERE batch_id = $1 AND state IN ('failed', 'cancelled')",
    )
    .bind(id.as_str())
    .execute(&mut *connection)
    .await?
    .rows_affected();
    let waiting = waiting + expansion::go_on(connection, id).await?;
    sqlx::query(
        "UPDATE batches SET state = 'running', finished_at = NULL, started_at = $1,
                            budget_micro_usd = COALESCE($2, budget_micro_usd)
         WHERE id = $3",
    )
    .bind(now)
    .bind(budget.map(|budget| budget.0))
    .bind(id.as_str())
    .execute(connection)
    .await?;
    Ok(BatchRetryOutcome::Accepted(waiting))
}
