//! The right of one process to work on a dataset: claimed, renewed, and checked before every write.
//!
//! Deaths, isolation and pauses follow the rules of jobs ([`crate::deaths`], [`crate::queue`]): an operator's pause
//! holds datasets too, a freeze that kills its processes runs alone and fails in the end, and one that fails is tried
//! again after a delay, so often.

use std::time::Duration;

use sqlx::any::AnyRow;
use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::{DatasetRow, dataset_of};
use crate::boxed;
use crate::database::Dialect;
use crate::deaths::{Deaths, IS_SUSPECT};
use crate::{AfterSetback, Setback, Store, StoreError, database, deaths, queue};
use scene::DatasetId;

/// Condition on work that is not ended; that of the index `datasets_waiting`.
const UNFINISHED: &str = "(state IN ('queued', 'running') OR verify_state IN ('queued', 'running'))";
/// Dead work that one transaction returns at most.
const MAX_RESCUED: i64 = 16;

/// The right to work on a dataset: valid while `owner` and `epoch` equal those of its row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DatasetLease {
    pub id: DatasetId,
    pub owner: String,
    pub epoch: i64,
}

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DatasetTask {
    Freeze,
    Verify,
}

/// Claimed work.
#[derive(Clone, Debug, PartialEq)]
pub struct DatasetClaim {
    pub lease: DatasetLease,
    pub task: DatasetTask,
    pub dataset: DatasetRow,
    /// Claims since the last progress, this one included.
    pub attempt: i64,
}

impl Store {
    /// Claims the oldest work on a dataset that waits, after work of dead processes has returned to the queue. Work
    /// that was alone in its process when it died, `max_deaths` times without progress, fails instead.
    #[boxed]
    pub async fn claim_dataset(
        &self,
        owner: &str,
        lease: Duration,
        max_deaths: u32,
    ) -> Result<Option<DatasetClaim>, StoreError> {
        let unfinished = format!("SELECT CAST(1 AS BIGINT) FROM datasets WHERE {UNFINISHED} LIMIT 1");
        let unfinished: Option<i64> =
            sqlx::query_scalar(AssertSqlSafe(unfinished)).fetch_optional(&self.readers).await?;
        if unfinished.is_none() {
            return Ok(None);
        }
        let (owner, is_shared) = (owner.to_owned(), self.is_shared);
        let (rescued, claim) = self
            .writer
            .write("claim a dataset", move |connection| {
                Box::pin(async move {
                    let now = database::now_ms(connection).await?;
                    let rescued = rescue(connection, &owner, i64::from(max_deaths), is_shared, now).await?;
                    Ok((rescued, claim(connection, &owner, lease, now).await?))
                })
            })
            .await?;
        if rescued > 0 || claim.is_some() {
            self.announce();
        }
        Ok(claim)
    }

    /// Ends an attempt that did not come to its end.
    ///
    /// # Errors
    ///
    /// [`StoreError::DatasetLeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn set_dataset_back(
        &self,
        lease: &DatasetLease,
        setback: Setback,
    ) -> Result<AfterSetback, StoreError> {
        let lease = lease.clone();
        let after = self
            .writer
            .write("set a dataset back", move |connection| {
                Box::pin(async move { set_back(connection, &lease, &setback).await })
            })
            .await?;
        self.announce();
        Ok(after)
    }

    /// Extends a lease and notes the progress; `false` if the lease is lost.
    #[boxed]
    pub async fn renew_dataset(
        &self,
        lease: &DatasetLease,
        duration: Duration,
        steps: (i64, i64),
    ) -> Result<bool, StoreError> {
        let lease = lease.clone();
        self.writer
            .write("renew the lease of a dataset", move |connection| {
                Box::pin(async move {
                    let now = database::now_ms(connection).await?;
                    let renewed = sqlx::query(
                        "UPDATE datasets SET lease_until = $1, steps_done = $2, steps_all = $3
                         WHERE id = $4 AND owner = $5 AND epoch = $6",
                    )
                    .bind(now + milliseconds(duration))
                    .bind(steps.0)
                    .bind(steps.1)
                    .bind(lease.id.as_str())
                    .bind(&lease.owner)
                    .bind(lease.epoch)
                    .execute(connection)
                    .await?;
                    Ok(renewed.rows_affected() > 0)
                })
            })
            .await
    }

    /// Gives work back, for another process to begin it again.
    #[boxed]
    pub async fn release_dataset(&self, lease: &DatasetLease) -> Result<(), StoreError> {
        let lease = lease.clone();
        self.writer
            .write("give a dataset back", move |connection| {
                Box::pin(async move {
                    sqlx::query(
                        "UPDATE datasets
                         SET owner = NULL, lease_until = 0, attempt = CASE WHEN attempt > 0 THEN attempt - 1 ELSE 0 END,
                             state = CASE WHEN state = 'running' THEN 'queued' ELSE state END,
                             verify_state = CASE WHEN verify_state = 'running' THEN 'queued' ELSE verify_state END
                         WHERE id = $1 AND owner = $2 AND epoch = $3",
                    )
                    .bind(lease.id.as_str())
                    .bind(&lease.owner)
                    .bind(lease.epoch)
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            })
            .await?;
        self.announce();
        Ok(())
    }
}

/// Returns work of dead processes to the queue, or ends it; how much.
async fn rescue(
    connection: &mut AnyConnection,
    owner: &str,
    max_deaths: i64,
    is_shared: bool,
    now_ms: i64,
) -> Result<u64, StoreError> {
    let lock = Dialect::of(connection).lock_free_rows();
    // In a file of one process the leases of other owners are those of dead ones.
    let dead = if is_shared { "lease_until <= $1" } else { "(lease_until <= $1 OR owner <> $2)" };
    let query = format!(
        "SELECT * FROM datasets
         WHERE {UNFINISHED} AND (state = 'running' OR verify_state = 'running') AND {dead}
         ORDER BY id LIMIT {MAX_RESCUED} {lock}"
    );
    let query = sqlx::query(AssertSqlSafe(query)).bind(now_ms);
    let query = if is_shared { query } else { query.bind(owner) };
    let orphans = query.fetch_all(&mut *connection).await?;
    let count = orphans.len() as u64;
    for orphan in orphans {
        let id: DatasetId = database::id(&orphan, "datasets", "id")?;
        // Read again: the rescue of the one before may have marked it.
        let row =
            sqlx::query("SELECT owner, was_beside, shared_deaths, lone_deaths FROM datasets WHERE id = $1")
                .bind(id.as_str())
                .fetch_one(&mut *connection)
                .await?;
        let dead: Option<String> = row.try_get("owner")?;
        let deaths =
            Deaths::count(connection, Deaths::of(&row)?, &dead.unwrap_or_default(), id.as_str()).await?;
        if deaths.are_too_many(max_deaths) {
            let message = format!(
                "the process died {} times while it worked on this dataset alone; see its log and memory, then freeze \
                 it again",
                deaths.lone
            );
            end(connection, &id, "interrupted_too_often", &message, now_ms).await?;
            continue;
        }
        sqlx::query(
            "UPDATE datasets
             SET shared_deaths = $1, lone_deaths = $2, was_beside = 0, owner = NULL, lease_until = 0, not_before = $3,
                 attempt = CASE WHEN attempt > 0 THEN attempt - 1 ELSE 0 END,
                 state = CASE WHEN state = 'running' THEN 'queued' ELSE state END,
                 verify_state = CASE WHEN verify_state = 'running' THEN 'queued' ELSE verify_state END
             WHERE id = $4",
        )
        .bind(deaths.shared)
        .bind(deaths.lone)
        .bind(now_ms + deaths.delay_ms())
        .bind(id.as_str())
        .execute(&mut *connection)
        .await?;
    }
    Ok(count)
}

/// Ends work that is in progress: the freeze fails, a verification is given up.
async fn end(
    connection: &mut AnyConnection,
    id: &DatasetId,
    code: &str,
    message: &str,
    now_ms: i64,
) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE datasets SET owner = NULL, lease_until = 0, was_beside = 0, verify_state = NULL,
             failure_code = CASE WHEN state = 'running' THEN $1 END,
             failure_message = CASE WHEN state = 'running' THEN $2 END,
             finished_at = CASE WHEN state = 'running' THEN $3 ELSE finished_at END,
             state = CASE WHEN state = 'running' THEN 'failed' ELSE state END
         WHERE id = $4",
    )
    .bind(code)
    .bind(message)
    .bind(now_ms)
    .bind(id.as_str())
    .execute(connection)
    .await?;
    Ok(())
}

async fn set_back(
    connection: &mut AnyConnection,
    lease: &DatasetLease,
    setback: &Setback,
) -> Result<AfterSetback, StoreError> {
    guard(connection, lease).await?;
    let now = database::now_ms(connection).await?;
    let attempt: i64 = sqlx::query_scalar("SELECT attempt FROM datasets WHERE id = $1")
        .bind(lease.id.as_str())
        .fetch_one(&mut *connection)
        .await?;
    if setback.is_end(attempt) {
        end(connection, &lease.id, setback.code, &setback.message, now).await?;
        return Ok(AfterSetback::Ended);
    }
    sqlx::query(
        "UPDATE datasets
         SET owner = NULL, lease_until = 0, not_before = $1, attempt = $2,
             state = CASE WHEN state = 'running' THEN 'queued' ELSE state END,
             verify_state = CASE WHEN verify_state = 'running' THEN 'queued' ELSE verify_state END
         WHERE id = $3",
    )
    .bind(setback.again_at_ms(now))
    .bind(setback.counted(attempt))
    .bind(lease.id.as_str())
    .execute(connection)
    .await?;
    Ok(AfterSetback::Again)
}

async fn claim(
    connection: &mut AnyConnection,
    owner: &str,
    lease: Duration,
    now_ms: i64,
) -> Result<Option<DatasetClaim>, StoreError> {
    if queue::is_paused(connection).await? {
        return Ok(None);
    }
    let hands = deaths::hands(connection, owner, now_ms).await?;
    if hands.are_bound {
        return Ok(None);
    }
    if let Some(suspect) = waiting(connection, IS_SUSPECT, now_ms).await? {
        if hands.are_empty {
            return take(connection, &suspect, owner, lease, now_ms).await.map(Some);
        }
        let id: DatasetId = database::id(&suspect, "datasets", "id")?;
        if deaths::reserve(connection, "datasets", id.as_str(), owner, now_ms).await? {
            return Ok(None);
        }
    }
    if hands.keep_free {
        return Ok(None);
    }
    match waiting(connection, "shared_deaths + lone_deaths < 2", now_ms).await? {
        Some(row) => take(connection, &row, owner, lease, now_ms).await.map(Some),
        None => Ok(None),
    }
}

/// The oldest dataset whose work waits and whose time has come, locked.
async fn waiting(
    connection: &mut AnyConnection,
    condition: &str,
    now_ms: i64,
) -> Result<Option<AnyRow>, StoreError> {
    let lock = Dialect::of(connection).lock_free_rows();
    let query = format!(
        "SELECT * FROM datasets
         WHERE {UNFINISHED} AND (state = 'queued' OR verify_state = 'queued') AND not_before <= $1 AND {condition}
           AND NOT EXISTS (SELECT 1 FROM datasets AS other
                           WHERE other.tenant_id = datasets.tenant_id AND other.name = datasets.name
                             AND other.state = 'running' AND other.id <> datasets.id AND datasets.state = 'queued')
         ORDER BY id LIMIT 1 {lock}"
    );
    Ok(sqlx::query(AssertSqlSafe(query)).bind(now_ms).fetch_optional(connection).await?)
}

async fn take(
    connection: &mut AnyConnection,
    row: &AnyRow,
    owner: &str,
    lease: Duration,
    now_ms: i64,
) -> Result<DatasetClaim, StoreError> {
    let id: DatasetId = database::id(row, "datasets", "id")?;
    let state: String = row.try_get("state")?;
    let task = if state == "finished" { DatasetTask::Verify } else { DatasetTask::Freeze };
    let (state, verify_state) = match task {
        DatasetTask::Freeze => ("running", None),
        DatasetTask::Verify => ("finished", Some("running")),
    };
    let row = sqlx::query(
        "UPDATE datasets SET owner = $1, epoch = epoch + 1, attempt = attempt + 1, lease_until = $2, state = $3,
                             verify_state = $4, steps_done = 0, steps_all = 0, was_beside = 0, reserved_by = NULL
         WHERE id = $5 RETURNING *",
    )
    .bind(owner)
    .bind(now_ms + milliseconds(lease))
    .bind(state)
    .bind(verify_state)
    .bind(id.as_str())
    .fetch_one(connection)
    .await?;
    let lease = DatasetLease { id, owner: owner.to_owned(), epoch: row.try_get("epoch")? };
    Ok(DatasetClaim { lease, task, dataset: dataset_of(&row)?, attempt: row.try_get("attempt")? })
}

/// Fails with [`StoreError::DatasetLeaseLost`] unless the lease is still valid; locks the dataset's row.
pub(super) async fn guard(connection: &mut AnyConnection, lease: &DatasetLease) -> Result<(), StoreError> {
    let lock = Dialect::of(connection).lock();
    let query = format!("SELECT 1 FROM datasets WHERE id = $1 AND owner = $2 AND epoch = $3 {lock}");
    let held = sqlx::query(AssertSqlSafe(query))
        .bind(lease.id.as_str())
        .bind(&lease.owner)
        .bind(lease.epoch)
        .fetch_optional(connection)
        .await?;
    held.map(|_| ()).ok_or_else(|| StoreError::DatasetLeaseLost { id: lease.id.clone() })
}

fn milliseconds(duration: Duration) -> i64 {
    i64::try_from(duration.as_millis()).unwrap_or(i64::MAX / 4)
}
