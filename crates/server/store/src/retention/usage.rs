//! Bytes of a tenant, and its quota.
//!
//! A sum reads a row for every artifact of the tenant, which takes minutes where there are millions. So no submission
//! waits for one: sums are computed in the background, only where there is a quota, and a submission is compared with
//! the newest. A sum is renewed after [`MAX_AGE`], or after [`MIN_REST`] times what it took, so that sums take a
//! twentieth of one connection at most. A tenant can exceed its quota by what it stores in that time, and by the scenes
//! it has in the queue; before the first sum of a process, nothing is refused.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::watch;
use tokio::time::Instant;

use super::{Store, StoreError};
use crate::boxed;
use scene::TenantId;

const MAX_AGE: Duration = Duration::from_secs(30);
/// Time that a sum is used, as a multiple of the time of its computation.
const MIN_REST: u32 = 20;
/// Time that the first submissions of a tenant wait for its first sum; small tenants are summed within it.
const PATIENCE: Duration = Duration::from_secs(1);

/// Bytes of the artifacts and bundles of a tenant's scenes; a blob counts once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TenantUsage {
    pub bytes: u64,
}

/// Whether a tenant may store more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuotaOutcome {
    Within,
    Exceeded { used_bytes: u64, quota_bytes: u64 },
}

/// The quota of every tenant, and the newest sums.
pub(crate) struct Quota {
    quota_bytes: u64,
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
    /// From then on it is renewed.
    old_at: Instant,
}

impl Quota {
    pub(crate) fn new(quota_bytes: u64) -> Self {
        Self { quota_bytes, sums: Mutex::default() }
    }

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
    /// Compares a tenant's bytes with its quota, `store.retention.tenant_quota_bytes`. It reads no rows itself.
    #[boxed]
    pub async fn quota(&self, tenant_id: &TenantId) -> QuotaOutcome {
        let quota_bytes = self.quota.quota_bytes;
        if quota_bytes == 0 {
            return QuotaOutcome::Within;
        }
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
        match known {
            Some(known) if known.usage.bytes >= quota_bytes => {
                QuotaOutcome::Exceeded { used_bytes: known.usage.bytes, quota_bytes }
            }
            _ => QuotaOutcome::Within,
        }
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
            match store.usage_of(&tenant_id).await {
                Ok(usage) => {
                    let rest = MAX_AGE.max(began.elapsed().saturating_mul(MIN_REST));
                    sum.newest.send_replace(Some(Known { usage, old_at: Instant::now() + rest }));
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

    /// A tenant's bytes now.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if the database does not answer.
    #[boxed]
    pub async fn usage_of(&self, tenant_id: &TenantId) -> Result<TenantUsage, StoreError> {
        let bytes: i64 = sqlx::query_scalar(
            "SELECT CAST(COALESCE(SUM(size), 0) AS BIGINT) FROM (
                 SELECT artifacts.digest AS digest, artifacts.size AS size
                 FROM artifacts JOIN scenes ON scenes.id = artifacts.scene_id
                 WHERE scenes.tenant_id = $1 AND scenes.state <> 'deleted'
                 UNION
                 SELECT bundle_archives.digest, bundle_archives.size
                 FROM bundle_archives JOIN scenes ON scenes.id = bundle_archives.scene_id
                 WHERE scenes.tenant_id = $2 AND scenes.state <> 'deleted') AS stored",
        )
        .bind(tenant_id.as_str())
        .bind(tenant_id.as_str())
        .fetch_one(&self.readers.unhurried())
        .await?;
        Ok(TenantUsage { bytes: bytes.max(0) as u64 })
    }
}

/// Ends the note that a sum is computed, however the computation ends.
struct Computing<'a>(&'a Sum);

impl Drop for Computing<'_> {
    fn drop(&mut self) {
        *self.0.computing.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}
