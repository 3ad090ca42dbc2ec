//! The outlook of jobs of scenes that have not ended: their places in the queue, and when they are likely to end. Jobs
//! of other kinds have slots of their own and last otherwise; nothing is estimated of them.
//!
//! A place counts the queued jobs of the tenant that are claimed before, on the index of its queue; tenants take
//! turns. The end follows from the mean duration of the tenant's newest jobs that succeeded and the number of its
//! jobs that run now: of n jobs beside each other, n end in a mean duration. Nothing is estimated before a job has
//! succeeded, nor for queued jobs while none runs.
//!
//! Cost: three statements for any number of jobs, none where all have ended. The outlook of a job that was submitted a
//! moment ago takes its place from the count that admitted it, and the pace that this process read less than
//! [`FRESH`] ago, so that most submissions read nothing.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::jobs::JobRow;
use super::scenes::NewRows;
use super::{Store, StoreError, database};
use crate::boxed;
use crate::lifecycle::JobState;
use scene::TenantId;

/// The durations of so many jobs are averaged.
const MEASURED_JOBS: i64 = 50;

/// Time for which a pace serves the outlooks of new jobs.
const FRESH: Duration = Duration::from_millis(250);

/// Expected place and end of a job; empty where it has ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outlook {
    /// Place in the queue, 1 is next; `None` unless the job is queued.
    pub queue_position: Option<i64>,
    /// Milliseconds since 1970; `None` where nothing is known.
    pub finish_at_ms: Option<i64>,
}

/// The newest paces that this process read, by tenant.
#[derive(Debug, Default)]
pub(crate) struct Paces(Mutex<BTreeMap<TenantId, (Instant, Pace)>>);

/// Pace of the store's jobs, by which others are estimated.
#[derive(Clone, Copy, Debug)]
struct Pace {
    /// Of the newest jobs that succeeded; `None` before the first.
    mean_ms: Option<i64>,
    running: i64,
    now_ms: i64,
}

impl Store {
    /// The outlook of each of these jobs of a tenant.
    #[boxed]
    pub async fn outlooks(&self, tenant_id: &TenantId, jobs: &[&JobRow]) -> Result<Vec<Outlook>, StoreError> {
        if jobs.iter().all(|job| job.state.is_final() || !job.kind.builds_scene()) {
            return Ok(vec![Outlook::default(); jobs.len()]);
        }
        let read = async {
            let mut connection = self.readers.acquire().await?;
            let pace = pace(&mut connection, tenant_id).await?;
            Ok((pace, places(&mut connection, tenant_id, jobs).await?))
        };
        let (pace, places) = self.readers.within_limit(read).await?;
        let outlook = |job: &&JobRow| {
            let queue_position = places.get(job.id.as_str()).copied();
            Outlook { queue_position, finish_at_ms: pace.finish_at_ms(job, queue_position) }
        };
        Ok(jobs.iter().map(outlook).collect())
    }

    /// The outlook of a job that was submitted a moment ago; its place may be a few too high, as jobs that were claimed
    /// in the last moment still count.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if the database does not answer.
    #[boxed]
    pub async fn outlook_of_new(&self, tenant_id: &TenantId, rows: &NewRows) -> Result<Outlook, StoreError> {
        let Some(place) = rows.last_place else {
            return Ok(self.outlooks(tenant_id, &[&rows.job]).await?.pop().unwrap_or_default());
        };
        let pace = match self.paces.fresh(tenant_id) {
            Some(pace) => pace,
            None => {
                let read = async { pace(&mut *self.readers.acquire().await?, tenant_id).await };
                let pace = self.readers.within_limit(read).await?;
                self.paces.keep(tenant_id, pace);
                pace
            }
        };
        let queue_position = Some(place);
        Ok(Outlook { queue_position, finish_at_ms: pace.finish_at_ms(&rows.job, queue_position) })
    }
}

impl Paces {
    fn fresh(&self, tenant_id: &TenantId) -> Option<Pace> {
        let paces = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        paces.get(tenant_id).filter(|(read_at, _)| read_at.elapsed() < FRESH).map(|(_, pace)| *pace)
    }

    fn keep(&self, tenant_id: &TenantId, pace: Pace) {
        let mut paces = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        paces.insert(tenant_id.clone(), (Instant::now(), pace));
    }
}

impl Pace {
    fn finish_at_ms(&self, job: &JobRow, queue_position: Option<i64>) -> Option<i64> {
        let mean_ms = self.mean_ms.filter(|_| job.kind.builds_scene())?;
        match (job.state, queue_position, job.started_at_ms) {
            (JobState::Queued, Some(place), _) if self.running > 0 => {
                let wait_ms = mean_ms.saturating_mul(place) / self.running;
                Some(self.now_ms.saturating_add(wait_ms).saturating_add(mean_ms))
            }
            (JobState::Running, _, Some(started_ms)) => {
                Some(started_ms.saturating_add(mean_ms).max(self.now_ms))
            }
            _ => None,
        }
    }
}

async fn pace(connection: &mut AnyConnection, tenant_id: &TenantId) -> Result<Pace, StoreError> {
    let now_ms = database::now_ms(connection).await?;
    // A condition on the tenant would lead SQLite to the index of all its jobs.
    let row = sqlx::query(
        "SELECT (SELECT CAST(AVG(finished_at - started_at) AS BIGINT)
                 FROM (SELECT finished_at, started_at FROM jobs
                       WHERE tenant_id = $1 AND state = 'succeeded' AND kind IN ('generate', 'retry')
                       ORDER BY id DESC LIMIT $2) AS lately) AS mean_ms,
                (SELECT COALESCE(CAST(SUM(CASE WHEN tenant_id = $1 THEN 1 ELSE 0 END) AS BIGINT), 0) FROM jobs
                 WHERE state IN ('running', 'cancelling') AND kind IN ('generate', 'retry')) AS running",
    )
    .bind(tenant_id.as_str())
    .bind(MEASURED_JOBS)
    .fetch_one(connection)
    .await?;
    Ok(Pace { mean_ms: row.try_get("mean_ms")?, running: row.try_get("running")?, now_ms })
}

/// The places of the queued ones among these jobs, by id. Each counts from the one before it, so that together they
/// read the index of the queue once.
async fn places<'a>(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    jobs: &[&'a JobRow],
) -> Result<HashMap<&'a str, i64>, StoreError> {
    let mut queued: Vec<&JobRow> =
        jobs.iter().copied().filter(|job| job.state == JobState::Queued && job.kind.builds_scene()).collect();
    queued.sort_unstable_by_key(|job| (job.rank_at_ms, job.id.as_str()));
    queued.dedup_by_key(|job| job.id.as_str());
    if queued.is_empty() {
        return Ok(HashMap::new());
    }
    // Rank and id of the job, and those that are counted from.
    let values: Vec<String> = (0..queued.len())
        .map(|k| format!("(${}, ${}, ${}, ${})", 4 * k + 2, 4 * k + 3, 4 * k + 4, 4 * k + 5))
        .collect();
    let counts = format!(
        "WITH page (rank_at, id, last_rank_at, last_id) AS (VALUES {})
         SELECT page.id AS id,
                (SELECT COUNT(*) FROM jobs
                 WHERE jobs.tenant_id = $1 AND jobs.state = 'queued' AND jobs.kind IN ('generate', 'retry')
                   AND COALESCE(jobs.rank_at, jobs.created_at) >= page.last_rank_at
                   AND COALESCE(jobs.rank_at, jobs.created_at) <= page.rank_at
                   AND (COALESCE(jobs.rank_at, jobs.created_at) > page.last_rank_at OR jobs.id > page.last_id)
                   AND (COALESCE(jobs.rank_at, jobs.created_at) < page.rank_at OR jobs.id <= page.id)) AS jobs
         FROM page",
        values.join(", ")
    );
    let mut query = sqlx::query(AssertSqlSafe(counts)).bind(tenant_id.as_str());
    let (mut last_rank_at_ms, mut last_id) = (i64::MIN, "");
    for job in &queued {
        query = query.bind(job.rank_at_ms).bind(job.id.as_str()).bind(last_rank_at_ms).bind(last_id);
        (last_rank_at_ms, last_id) = (job.rank_at_ms, job.id.as_str());
    }
    let rows = query.fetch_all(connection).await?;
    let mut counted = HashMap::new();
    for row in &rows {
        counted.insert(row.try_get::<String, _>("id")?, row.try_get::<i64, _>("jobs")?);
    }
    let (mut places, mut place) = (HashMap::new(), 0);
    for job in queued {
        place += counted.get(job.id.as_str()).copied().unwrap_or_default();
        // A job that was claimed a moment ago counts no more.
        places.insert(job.id.as_str(), place.max(1));
    }
    Ok(places)
}
