//! Admission of new work: the limits of its tenant, and the length of the queue, in the transaction that makes it.
//!
//! Waiting jobs are counted, which takes milliseconds in a long queue. So a count is used for a moment ([`FRESH`]),
//! with what this process has admitted since, while it is far from every limit: others would have to add a thousand
//! jobs in that moment. Close to a limit every submission counts, and those of a tenant follow each other, so that no
//! limit is exceeded. A change of a tenant's limits counts after that moment. So does a refusal, until work that waited
//! has begun or has been cancelled: a tenant that does not heed it costs the database nothing.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use sqlx::{AnyConnection, Row};

use super::{Limit, LimitReached, LimitSettings, TenantLimits};
use super::{of_tenant, one_at_a_time, spending, submissions_of, take_pace};
use crate::StoreError;
use scene::TenantId;

/// Time for which a count is used.
const FRESH: Duration = Duration::from_millis(250);

/// A count is far from a limit if at least so many more have room, and a tenth of the limit.
const FAR: i64 = 1000;

/// Window over which the pace of the queue is measured, seconds.
const WINDOW_SECS: i64 = 600;

/// Admission of new work, with the counts of this process.
#[derive(Debug)]
pub(crate) struct Admission {
    settings: LimitSettings,
    counts: Mutex<BTreeMap<TenantId, Count>>,
    refusals: Mutex<BTreeMap<TenantId, Refusal>>,
}

/// A scene that waiting work left no room for.
#[derive(Clone, Copy, Debug)]
struct Refusal {
    refused: Instant,
    reached: LimitReached,
}

/// Waiting work, as this process knows it.
#[derive(Clone, Copy, Debug)]
struct Count {
    counted: Instant,
    limits: TenantLimits,
    waiting: Waiting,
}

#[derive(Clone, Copy, Debug, Default)]
struct Waiting {
    /// Scenes of all tenants.
    all_scenes: i64,
    /// Scenes of the tenant.
    scenes: i64,
    /// Work of the tenant: jobs, and recordings.
    own: i64,
}

impl Waiting {
    fn add(&mut self, is_scene: bool) {
        self.own += 1;
        self.scenes += i64::from(is_scene);
        self.all_scenes += i64::from(is_scene);
    }
}

impl Admission {
    pub(crate) fn new(settings: LimitSettings) -> Self {
        Self { settings, counts: Mutex::default(), refusals: Mutex::default() }
    }

    pub(crate) fn settings(&self) -> &LimitSettings {
        &self.settings
    }

    /// The refusal of a scene of the tenant a moment ago, if this process has made no room since. A tenant that
    /// does not heed `Retry-After` is answered by this, so that the transactions of others need not wait for it.
    pub(crate) fn recent_refusal(&self, tenant_id: &TenantId) -> Option<LimitReached> {
        let refusals = self.refusals.lock().unwrap_or_else(PoisonError::into_inner);
        refusals
            .get(tenant_id)
            .filter(|refusal| refusal.refused.elapsed() < FRESH)
            .map(|refusal| refusal.reached)
    }

    /// Waiting work has begun or has been cancelled.
    pub(crate) fn made_room(&self) {
        self.refusals.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// Admits one scene: the number of the tenant's scenes that wait, with this one. `max_scenes` is the limit of the
    /// scenes of all tenants. Inner `Err` where a limit leaves no room.
    pub(crate) async fn scene(
        &self,
        connection: &mut AnyConnection,
        tenant_id: &TenantId,
        max_scenes: i64,
        now_ms: i64,
    ) -> Result<Result<i64, LimitReached>, StoreError> {
        self.admit(connection, tenant_id, Some(max_scenes), now_ms).await
    }

    /// Admits other work: a job, or a recording. Inner `Err` where a limit leaves no room.
    pub(crate) async fn work(
        &self,
        connection: &mut AnyConnection,
        tenant_id: &TenantId,
        now_ms: i64,
    ) -> Result<Result<(), LimitReached>, StoreError> {
        Ok(self.admit(connection, tenant_id, None, now_ms).await?.map(|_| ()))
    }

    async fn admit(
        &self,
        connection: &mut AnyConnection,
        tenant_id: &TenantId,
        max_scenes: Option<i64>,
        now_ms: i64,
    ) -> Result<Result<i64, LimitReached>, StoreError> {
        if let Some(scenes) = self.admit_counted(tenant_id, max_scenes) {
            return Ok(Ok(scenes));
        }
        let limits = of_tenant(connection, &self.settings, tenant_id).await?;
        if let Some(reached) = spending::reached(connection, tenant_id, limits.micro_usd_per_month).await? {
            return Ok(Err(reached));
        }
        let mut waiting = count(connection, tenant_id).await?;
        let is_near_all = max_scenes.is_some_and(|max| !is_far(waiting.all_scenes, max));
        let is_near_own = !is_far(waiting.own, limits.waiting_jobs);
        if is_near_all || is_near_own {
            // Always in this order, so that no two transactions wait for each other.
            if is_near_all {
                one_at_a_time(connection, "submissions").await?;
            }
            if is_near_own {
                one_at_a_time(connection, &submissions_of(tenant_id)).await?;
            }
            waiting = count(connection, tenant_id).await?;
        }
        if let Some((limit, max, used)) = full(&limits, max_scenes, &waiting) {
            let retry_after_secs = time_to_room(connection, tenant_id, now_ms).await?;
            let reached = LimitReached { limit, max, used, retry_after_secs };
            if max_scenes.is_some() {
                let refusal = Refusal { refused: Instant::now(), reached };
                let mut refusals = self.refusals.lock().unwrap_or_else(PoisonError::into_inner);
                refusals.insert(tenant_id.clone(), refusal);
            }
            return Ok(Err(reached));
        }
        if limits.submissions_per_minute > 0
            && let Err(reached) =
                take_pace(connection, tenant_id, limits.submissions_per_minute, 1, now_ms).await?
        {
            return Ok(Err(reached));
        }
        waiting.add(max_scenes.is_some());
        let counted = Count { counted: Instant::now(), limits, waiting };
        self.counts.lock().unwrap_or_else(PoisonError::into_inner).insert(tenant_id.clone(), counted);
        Ok(Ok(waiting.scenes))
    }

    /// Admits by a fresh count that is far from every limit.
    fn admit_counted(&self, tenant_id: &TenantId, max_scenes: Option<i64>) -> Option<i64> {
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        let Count { counted, limits, waiting } = counts.get_mut(tenant_id)?;
        let has_room = counted.elapsed() < FRESH
            && limits.submissions_per_minute == 0
            && limits.micro_usd_per_month == 0
            && is_far(waiting.own, limits.waiting_jobs)
            && max_scenes.is_none_or(|max| is_far(waiting.all_scenes, max));
        has_room.then(|| {
            waiting.add(max_scenes.is_some());
            waiting.scenes
        })
    }
}

/// Whether a count is so far from a limit that it need not be exact.
fn is_far(count: i64, max: i64) -> bool {
    max == 0 || count < max - (max / 10).max(FAR)
}

/// The limit that leaves no room, its value and what is used of it.
fn full(limits: &TenantLimits, max_scenes: Option<i64>, waiting: &Waiting) -> Option<(Limit, i64, i64)> {
    if limits.waiting_jobs > 0 && waiting.own >= limits.waiting_jobs {
        return Some((Limit::WaitingJobs, limits.waiting_jobs, waiting.own));
    }
    let max = max_scenes.filter(|max| waiting.all_scenes >= *max)?;
    Some((Limit::AllWaitingScenes, max, waiting.all_scenes))
}

/// Counts waiting work, on the indexes of what waits. Attempts of a recording are a part of it, and do not count
/// beside.
async fn count(connection: &mut AnyConnection, tenant_id: &TenantId) -> Result<Waiting, StoreError> {
    let row = sqlx::query(
        "SELECT (SELECT COUNT(*) FROM jobs WHERE state = 'queued' AND kind IN ('generate', 'retry')) AS all_scenes,
                (SELECT COUNT(*) FROM jobs
                 WHERE state = 'queued' AND kind IN ('generate', 'retry') AND tenant_id = $1) AS scenes,
                (SELECT COUNT(*) FROM jobs
                 WHERE state = 'queued' AND kind IN ('freeze_dataset', 'verify_dataset', 'execute_task')
                   AND tenant_id = $1) AS others,
                (SELECT COUNT(*) FROM recordings
                 WHERE tenant_id = $1 AND state IN ('queued', 'running')) AS recordings",
    )
    .bind(tenant_id.as_str())
    .fetch_one(connection)
    .await?;
    let (scenes, others): (i64, i64) = (row.try_get("scenes")?, row.try_get("others")?);
    let recordings: i64 = row.try_get("recordings")?;
    Ok(Waiting { all_scenes: row.try_get("all_scenes")?, scenes, own: scenes + others + recordings })
}

/// Work of a tenant that waits.
pub(crate) async fn waiting_work(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
) -> Result<i64, StoreError> {
    Ok(count(connection, tenant_id).await?.own)
}

/// Estimated time until one job has left the queue: the mean interval between the tenant's claims of the last ten
/// minutes, seconds.
async fn time_to_room(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    now_ms: i64,
) -> Result<i64, StoreError> {
    let claims: i64 =
        sqlx::query_scalar("SELECT COUNT(*) FROM jobs WHERE tenant_id = $1 AND claimed_at > $2")
            .bind(tenant_id.as_str())
            .bind(now_ms - WINDOW_SECS * 1000)
            .fetch_one(connection)
            .await?;
    Ok((WINDOW_SECS / claims.max(1)).clamp(1, 60))
}
