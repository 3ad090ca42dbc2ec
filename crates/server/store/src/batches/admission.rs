//! Admission of batches: the limits of their tenant, in the transaction that lets their requests wait.

use sqlx::AnyConnection;

use crate::boxed;
use crate::limits::{self, Limit, LimitReached, LimitSettings};
use crate::{Store, StoreError};
use scene::{BatchId, TenantId};

/// Time after which a refused batch may be sent again, seconds: some requests of others have ended by then.
const RETRY_AFTER_SECS: i64 = 60;

/// The limit of a tenant that leaves no room for so many more requests. Transactions of the tenant that make work
/// follow each other from here on.
pub(super) async fn full(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    settings: &LimitSettings,
    requests: i64,
    now_ms: i64,
) -> Result<Option<LimitReached>, StoreError> {
    limits::one_at_a_time(connection, &limits::submissions_of(tenant_id)).await?;
    let limits = limits::of_tenant(connection, settings, tenant_id).await?;
    if let Some(reached) = limits::spent(connection, tenant_id, limits.micro_usd_per_month).await? {
        return Ok(Some(reached));
    }
    if let Some(reached) = beyond(connection, tenant_id, limits.batch_requests, requests).await? {
        return Ok(Some(reached));
    }
    if limits.submissions_per_minute > 0 {
        let taken =
            limits::take_pace(connection, tenant_id, limits.submissions_per_minute, 1, now_ms).await?;
        return Ok(taken.err());
    }
    Ok(None)
}

/// The limit of requests of batches, if so many more would be beyond it.
async fn beyond(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    max: i64,
    requests: i64,
) -> Result<Option<LimitReached>, StoreError> {
    if max == 0 {
        return Ok(None);
    }
    let used = unsettled(connection, tenant_id).await?;
    let (limit, retry_after_secs) = (Limit::BatchRequests, RETRY_AFTER_SECS);
    let is_beyond = used.saturating_add(requests) > max;
    Ok(is_beyond.then_some(LimitReached { limit, max, used, retry_after_secs }))
}

impl Store {
    /// The limit that refuses every further batch of a tenant: a cheap question before a batch is received.
    #[boxed]
    pub async fn full_of_batches(&self, tenant_id: &TenantId) -> Result<Option<LimitReached>, StoreError> {
        let read = async {
            let connection = &mut *self.readers.acquire().await?;
            let limits = limits::of_tenant(connection, self.admission.settings(), tenant_id).await?;
            beyond(connection, tenant_id, limits.batch_requests, 1).await
        };
        self.readers.within_limit(read).await
    }
}

/// Requests of a batch that wait, with and without rows.
pub(super) async fn pending(connection: &mut AnyConnection, id: &BatchId) -> Result<i64, StoreError> {
    Ok(sqlx::query_scalar(
        "SELECT (SELECT COUNT(*) FROM batch_items WHERE batch_id = $1 AND state = 'pending')
              + COALESCE((SELECT pending FROM batch_recipes WHERE batch_id = $1), 0)",
    )
    .bind(id.as_str())
    .fetch_one(connection)
    .await?)
}

/// Requests of a batch that a retry lets wait again, with and without rows.
pub(super) async fn repeatable(connection: &mut AnyConnection, id: &BatchId) -> Result<i64, StoreError> {
    Ok(sqlx::query_scalar(
        "SELECT (SELECT COUNT(*) FROM batch_items WHERE batch_id = $1 AND state = 'failed')
              + (SELECT COUNT(*) FROM batch_items WHERE batch_id = $1 AND state = 'cancelled')
              + COALESCE((SELECT pending FROM batch_recipes WHERE batch_id = $1 AND is_stopped = 1), 0)",
    )
    .bind(id.as_str())
    .fetch_one(connection)
    .await?)
}

/// Requests of a tenant's batches that have not come to their end, with and without rows.
pub(crate) async fn unsettled(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
) -> Result<i64, StoreError> {
    Ok(sqlx::query_scalar(
        "SELECT CAST(COALESCE(SUM(
                    (SELECT COUNT(*) FROM batch_items WHERE batch_id = batches.id AND state = 'pending')
                  + (SELECT COUNT(*) FROM batch_items WHERE batch_id = batches.id AND state = 'submitted')
                  + COALESCE((SELECT pending FROM batch_recipes
                              WHERE batch_id = batches.id AND is_stopped = 0), 0)), 0) AS BIGINT)
         FROM batches WHERE tenant_id = $1 AND state IN ('running', 'cancelling')",
    )
    .bind(tenant_id.as_str())
    .fetch_one(connection)
    .await?)
}
