//! Bytes of a tenant, and its quota.
//!
//! A sum reads a row for every artifact of the tenant, which takes minutes where there are millions. So no submission
//! waits for one: sums are computed in the background, only where there is a quota, and a submission is compared with
//! the newest. A sum is renewed after [`MAX_AGE`], or after [`MIN_REST`] times what it took, so that sums take a
//! twentieth of one connection at most; so is the quota of the tenant. A tenant can exceed its quota by what it stores
//! in that time, and by the scenes it has in the queue; before the first sum of a process, nothing is refused.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::watch;
use tokio::time::Instant;

use sqlx::AnyConnection;

use super::{Store, StoreError};
use crate::boxed;
use crate::limits::{Limit, LimitReached, of_tenant};
use scene::TenantId;

const MAX_AGE: Duration = Duration::from_secs(30);
/// Time that a sum is used, as a multiple of the time of its computation.
const MIN_REST: u32 = 20;
/// Time that the first submissions of a tenant wait for its first sum; small tenants are summed within it.
const PATIENCE: Duration = Duration::from_secs(1);

/// Time after which a refused tenant may ask again: its sum is renewed by then.
const RETRY_AFTER_SECS: i64 = MAX_AGE.as_secs() as i64;

/// Bytes of the artifacts and bundles of a tenant's scenes, and of its datasets, recordings and executions; a blob
/// counts once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TenantUsage {
    pub bytes: u64,
}

/// The newest sums.
#[derive(Default)]
pub(crate) struct Quota {
    sums: Mutex<BTreeMap<TenantId, Arc<Sum>>>,
}

/// The sum of a tenant.
struct Sum {
    newest: watch::Sender<Option<Known>>,
    /// Begin of the computation under way.
    computing: Mutex<Option<Instant>>,
}

#[derive(Clone, Copy, Debug)]
struct Known {
    usage: TenantUsage,
    /// The quota of the tenant, bytes; 0 = none.
    quota_bytes: i64,
    /// From then on it is renewed.
    old_at: Instant,
}

impl Quota {
    fn sum_of(&self, tenant_id: &TenantId) -> Arc<Sum> {
        let mut sums = self.sums.lock().unwrap_or_else(PoisonError::into_inner);
        let new = || Arc::new(Sum { newest: watch::Sender::new(None), computing: Mutex::default() });
        sums.entry(tenant_id.clone()).or_insert_with(new).clone()
    }

    /// Forgets every sum.
    #[cfg(test)]
    pub(crate) fn forget(&self) {
        self.sums.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }
}

impl Store {
    /// The limit of bytes of a tenant, if it has reached it. It reads no rows itself.
    #[boxed]
    pub async fn full_quota(&self, tenant_id: &TenantId) -> Option<LimitReached> {
        let sum = self.quota.sum_of(tenant_id);
        let mut known = *sum.newest.borrow();
        if known.is_none_or(|known| known.old_at <= Instant::now()) {
            let began = self.renew_sum(&sum, tenant_id);
            if known.is_none() {
                let mut newest = sum.newest.subscribe();
                let first = newest.wait_for(Option::is_some);
                known = match tokio::time::timeout_at(began + PATIENCE, first).await {
                    Ok(Ok(first)) => *first,
                    _ => None,
                };
            }
        }
        let Known { usage, quota_bytes: max, .. } = known?;
        let used = i64::try_from(usage.bytes).unwrap_or(i64::MAX);
        let is_full = max > 0 && used >= max;
        is_full.then_some(LimitReached { limit: Limit::Bytes, max, used, retry_after_secs: RETRY_AFTER_SECS })
    }

    /// Computes a sum in the background, unless that is under way; when it began.
    fn renew_sum(&self, sum: &Arc<Sum>, tenant_id: &TenantId) -> Instant {
        let mut computing = sum.computing.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(began) = *computing {
            return began;
        }
        let began = Instant::now();
        *computing = Some(began);
        let (store, sum, tenant_id) = (self.clone(), sum.clone(), tenant_id.clone());
        tokio::spawn(async move {
            let _ended = Computing(&sum);
            match store.quota_and_usage(&tenant_id).await {
                Ok((quota_bytes, usage)) => {
                    let rest = MAX_AGE.max(began.elapsed().saturating_mul(MIN_REST));
                    let old_at = Instant::now() + rest;
                    sum.newest.send_replace(Some(Known { usage, quota_bytes, old_at }));
                }
                // The store itself reports outages, once.
                Err(error) if error.outage().is_some() => {}
                Err(error) => {
                    tracing::error!(%tenant_id, error = error.chain(), "cannot add up the bytes of a tenant")
                }
            }
        });
        began
    }

    /// The quota of a tenant, and its bytes; nothing is added up where there is no quota.
    async fn quota_and_usage(&self, tenant_id: &TenantId) -> Result<(i64, TenantUsage), StoreError> {
        let read = async {
            let mut connection = self.readers.acquire().await?;
            of_tenant(&mut connection, self.admission.settings(), tenant_id).await
        };
        let quota_bytes = self.readers.within_limit(read).await?.bytes;
        let usage = match quota_bytes {
            0 => TenantUsage { bytes: 0 },
            _ => self.usage_of(tenant_id).await?,
        };
        Ok((quota_bytes, usage))
    }

    /// A tenant's bytes now.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if the database does not answer.
    #[boxed]
    pub async fn usage_of(&self, tenant_id: &TenantId) -> Result<TenantUsage, StoreError> {
        let readers = self.readers.unhurried();
        let read = async { bytes_of(&mut *readers.acquire().await?, tenant_id).await };
        let bytes = readers.within_limit(read).await?;
        Ok(TenantUsage { bytes: u64::try_from(bytes).unwrap_or(0) })
    }
}

/// A tenant's bytes.
pub(crate) async fn bytes_of(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
) -> Result<i64, StoreError> {
    Ok(sqlx::query_scalar(
        "SELECT CAST(COALESCE(SUM(size), 0) AS BIGINT) FROM (
             SELECT artifacts.digest AS digest, artifacts.size AS size
             FROM artifacts JOIN scenes ON scenes.id = artifacts.scene_id
             WHERE scenes.tenant_id = $1 AND scenes.state <> 'deleted'
             UNION
             SELECT bundle_archives.digest, bundle_archives.size
             FROM bundle_archives JOIN scenes ON scenes.id = bundle_archives.scene_id
             WHERE scenes.tenant_id = $1 AND scenes.state <> 'deleted'
             UNION
             SELECT dataset_files.digest, dataset_files.size
             FROM dataset_files JOIN datasets ON datasets.id = dataset_files.dataset_id
             WHERE datasets.tenant_id = $1 AND datasets.deleted_at IS NULL
             UNION
             SELECT COALESCE(recording_archives.digest, recording_archives.recording_id || recording_archives.format),
                    recording_archives.size
             FROM recording_archives JOIN recordings ON recordings.id = recording_archives.recording_id
             WHERE recordings.tenant_id = $1 AND recordings.deleted_at IS NULL
             UNION
             SELECT answer, size FROM executions WHERE tenant_id = $1 AND answer IS NOT NULL) AS stored",
    )
    .bind(tenant_id.as_str())
    .fetch_one(connection)
    .await?)
}

/// Ends the note that a sum is computed, however the computation ends.
struct Computing<'a>(&'a Sum);

impl Drop for Computing<'_> {
    fn drop(&mut self) {
        *self.0.computing.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}
