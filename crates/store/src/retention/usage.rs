//! Bytes of a tenant, and its quota.
//!
//! The sum is computed at most once in [`MAX_AGE`], and only where there is a quota: it reads a row for every artifact.
//! A tenant can therefore exceed its quota by what it stores in that time, and by the scenes it has in the queue.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use tokio::sync::Mutex;

use super::{Store, StoreError};
use scene::TenantId;

const MAX_AGE: Duration = Duration::from_secs(30);

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
    /// The lock is held while a sum is computed, so that no two requests compute the same.
    pub(crate) sums: Mutex<BTreeMap<TenantId, (Instant, TenantUsage)>>,
}

impl Quota {
    pub(crate) fn new(quota_bytes: u64) -> Self {
        Self { quota_bytes, sums: Mutex::default() }
    }
}

impl Store {
    /// Compares a tenant's bytes with its quota, `store.retention.tenant_quota_bytes`.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if the database does not answer.
    pub async fn quota(&self, tenant_id: &TenantId) -> Result<QuotaOutcome, StoreError> {
        let quota_bytes = self.quota.quota_bytes;
        if quota_bytes == 0 {
            return Ok(QuotaOutcome::Within);
        }
        let mut sums = self.quota.sums.lock().await;
        let known = sums.get(tenant_id).filter(|(at, _)| at.elapsed() < MAX_AGE).map(|(_, usage)| *usage);
        let usage = match known {
            Some(usage) => usage,
            None => {
                let usage = self.usage_of(tenant_id).await?;
                sums.insert(tenant_id.clone(), (Instant::now(), usage));
                usage
            }
        };
        Ok(if usage.bytes < quota_bytes {
            QuotaOutcome::Within
        } else {
            QuotaOutcome::Exceeded { used_bytes: usage.bytes, quota_bytes }
        })
    }

    /// A tenant's bytes now.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if the database does not answer.
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
        .fetch_one(&self.readers)
        .await?;
        Ok(TenantUsage { bytes: bytes.max(0) as u64 })
    }
}
