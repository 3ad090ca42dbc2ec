//! The right of one process to work on a dataset: claimed, renewed, and checked before every write.

use std::time::Duration;

use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::{DatasetRow, dataset_of};
use crate::database::Dialect;
use crate::{Store, StoreError, database};
use scene::DatasetId;

/// Processes that may die over the same work before it fails.
const MAX_ATTEMPTS: i64 = 5;

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
}

impl Store {
    /// Claims the oldest work on a dataset that waits, or whose process is dead.
    pub async fn claim_dataset(
        &self,
        owner: &str,
        lease: Duration,
    ) -> Result<Option<DatasetClaim>, StoreError> {
        let waiting: Option<i64> = sqlx::query_scalar(
            "SELECT CAST(1 AS BIGINT) FROM datasets
             WHERE state IN ('queued', 'running') OR verify_state IN ('queued', 'running') LIMIT 1",
        )
        .fetch_optional(&self.readers)
        .await?;
        if waiting.is_none() {
            return Ok(None);
        }
        let (owner, is_shared) = (owner.to_owned(), self.is_shared);
        let claim = self
            .writer
            .write("claim a dataset", move |connection| {
                Box::pin(async move {
                    give_up(connection).await?;
                    claim(connection, &owner, lease, is_shared).await
                })
            })
            .await?;
        if claim.is_some() {
            self.announce();
        }
        Ok(claim)
    }

    /// Extends a lease and notes the progress; `false` if the lease is lost.
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

/// Ends work that processes died over too often.
async fn give_up(connection: &mut AnyConnection) -> Result<(), StoreError> {
    let now = database::now_ms(connection).await?;
    sqlx::query(
        "UPDATE datasets SET state = 'failed', owner = NULL, finished_at = $1, failure_code = 'interrupted_too_often',
                             failure_message = 'the processes that froze it died; see their logs, then freeze it again'
         WHERE state = 'running' AND lease_until <= $2 AND attempt >= $3",
    )
    .bind(now)
    .bind(now)
    .bind(MAX_ATTEMPTS)
    .execute(&mut *connection)
    .await?;
    sqlx::query(
        "UPDATE datasets SET verify_state = NULL, owner = NULL
         WHERE verify_state = 'running' AND lease_until <= $1 AND attempt >= $2",
    )
    .bind(now)
    .bind(MAX_ATTEMPTS)
    .execute(connection)
    .await?;
    Ok(())
}

async fn claim(
    connection: &mut AnyConnection,
    owner: &str,
    lease: Duration,
    is_shared: bool,
) -> Result<Option<DatasetClaim>, StoreError> {
    let now = database::now_ms(connection).await?;
    let lock = Dialect::of(connection).lock_free_rows();
    // In a file of one process the leases of other owners are those of dead ones.
    let dead = if is_shared { "lease_until <= $1" } else { "(lease_until <= $1 OR owner <> $2)" };
    let query = format!(
        "SELECT * FROM datasets
         WHERE (state = 'queued' OR verify_state = 'queued'
                OR ((state = 'running' OR verify_state = 'running') AND {dead}))
           AND NOT EXISTS (SELECT 1 FROM datasets AS other
                           WHERE other.tenant_id = datasets.tenant_id AND other.name = datasets.name
                             AND other.state = 'running' AND other.id <> datasets.id AND datasets.state = 'queued')
         ORDER BY id LIMIT 1 {lock}"
    );
    let query = sqlx::query(AssertSqlSafe(query)).bind(now);
    let query = if is_shared { query } else { query.bind(owner) };
    let Some(row) = query.fetch_optional(&mut *connection).await? else { return Ok(None) };
    let id: DatasetId = database::id(&row, "datasets", "id")?;
    let state: String = row.try_get("state")?;
    let task = if state == "finished" { DatasetTask::Verify } else { DatasetTask::Freeze };
    let (state, verify_state) = match task {
        DatasetTask::Freeze => ("running", None),
        DatasetTask::Verify => ("finished", Some("running")),
    };
    let row = sqlx::query(
        "UPDATE datasets SET owner = $1, epoch = epoch + 1, attempt = attempt + 1, lease_until = $2, state = $3,
                             verify_state = $4, steps_done = 0, steps_all = 0
         WHERE id = $5 RETURNING *",
    )
    .bind(owner)
    .bind(now + milliseconds(lease))
    .bind(state)
    .bind(verify_state)
    .bind(id.as_str())
    .fetch_one(connection)
    .await?;
    let lease = DatasetLease { id, owner: owner.to_owned(), epoch: row.try_get("epoch")? };
    Ok(Some(DatasetClaim { lease, task, dataset: dataset_of(&row)? }))
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
