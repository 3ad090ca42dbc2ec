//! Room in the queue: submissions of scenes beyond its limits are refused. Jobs of other kinds do not count.
//!
//! Waiting jobs are counted, which takes milliseconds in a long queue, so a count is used for a moment, with the jobs
//! that this process has added since. Close to a limit every submission counts. Processes that submit at the same time
//! may exceed a limit by what they submit in that moment.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::Settings;
use crate::StoreError;
use crate::readers::Readers;
use scene::TenantId;

/// Time for which a count is used.
const FRESH: Duration = Duration::from_millis(250);

/// Window over which the pace of the queue is measured, seconds.
const WINDOW_SECS: i64 = 600;

/// A submission that the queue has no room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueueFull {
    /// The limit that is reached.
    pub limit: i64,
    /// Estimated time until a job may be accepted, seconds.
    pub retry_after_secs: i64,
}

/// Waiting jobs, as this process knows them.
#[derive(Debug, Default)]
pub(crate) struct Room {
    counts: Mutex<BTreeMap<TenantId, Count>>,
}

#[derive(Clone, Copy, Debug)]
struct Count {
    counted: Instant,
    all: i64,
    own: i64,
}

impl Room {
    /// Takes a place for a job of the tenant: the number of its jobs that wait, with this one. Inner `Err` where there
    /// is none.
    pub(crate) async fn take(
        &self,
        readers: &Readers,
        tenant_id: &TenantId,
        settings: &Settings,
    ) -> Result<Result<i64, QueueFull>, StoreError> {
        if let Some(place) = self.take_counted(tenant_id, settings) {
            return Ok(Ok(place));
        }
        let (all, own): (i64, i64) = sqlx::query_as(
            "SELECT COUNT(*), COUNT(CASE WHEN tenant_id = $1 THEN 1 END) FROM jobs
             WHERE state = 'queued' AND kind IN ('generate', 'retry')",
        )
        .bind(tenant_id.as_str())
        .fetch_one(readers)
        .await?;
        let limit = if own >= settings.max_jobs_per_tenant {
            settings.max_jobs_per_tenant
        } else if all >= settings.max_jobs {
            settings.max_jobs
        } else {
            let count = Count { counted: Instant::now(), all: all + 1, own: own + 1 };
            self.counts.lock().unwrap_or_else(PoisonError::into_inner).insert(tenant_id.clone(), count);
            return Ok(Ok(own + 1));
        };
        // One job has to leave the queue: the mean interval between the tenant's claims of the last ten minutes.
        let now = readers.now_ms().await?;
        let claims: i64 =
            sqlx::query_scalar("SELECT COUNT(*) FROM jobs WHERE tenant_id = $1 AND claimed_at > $2 AND kind IN ('generate', 'retry')")
                .bind(tenant_id.as_str())
                .bind(now - WINDOW_SECS * 1000)
                .fetch_one(readers)
                .await?;
        Ok(Err(QueueFull { limit, retry_after_secs: (WINDOW_SECS / claims.max(1)).clamp(1, 60) }))
    }

    /// Takes a place by a fresh count that is far from the limits.
    fn take_counted(&self, tenant_id: &TenantId, settings: &Settings) -> Option<i64> {
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        let count = counts.get_mut(tenant_id)?;
        let is_far = |jobs: i64, limit: i64| jobs < limit - limit / 10 - 1;
        let is_room = count.counted.elapsed() < FRESH
            && is_far(count.own, settings.max_jobs_per_tenant)
            && is_far(count.all, settings.max_jobs);
        if is_room {
            count.all += 1;
            count.own += 1;
        }
        is_room.then_some(count.own)
    }
}
