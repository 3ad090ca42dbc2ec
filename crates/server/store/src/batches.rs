//! Batches: many requests that are submitted together and put into the queue a few at a time.
//!
//! [`receive`] stores a batch and its items; until all are there, no query finds the batch. The requests of a recipe
//! get their items a group at a time ([`expansion`]). [`feed`] gives pending items a scene and a job, so that at most a
//! window of them is in the queue, and settles those that have ended: the item then has its final state, its error and
//! its cost. An item gets its scene in the transaction that changes its state, and the transaction holds the batch's
//! row, so processes may feed the same batch, and die, at any time: every item is submitted exactly once. [`control`]
//! cancels and retries, [`deletion`] deletes, [`account`] counts, [`output`] lists results.

mod receive;
mod admission;
mod expansion;
mod feed;
mod begin;
mod settle;
mod control;
mod deletion;
mod account;
mod output;

use serde::{Deserialize, Serialize};
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, AssertSqlSafe, Row};

use ::batches::{BatchState, OutputError};

use super::database::Dialect;
use super::list_query::ListQuery;
use super::{Store, StoreError, database};
use crate::boxed;
use scene::{BatchId, JobId, MicroUsd, SceneId, TenantId};

pub use account::{BatchAccount, BatchMoney};
pub(super) use admission::unsettled;
pub use control::{BatchCancelOutcome, BatchRetryOutcome};
pub use deletion::BatchScenes;
pub use expansion::{RecipeRest, RestCounts};
pub use feed::{Fed, FeedRules};
pub use output::{ItemRow, OutputKind};
pub use receive::{ItemContent, NewBatch, NewItem, PublishOutcome};

/// Section `[batches]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Requests of one batch that are in the queue or worked on at the same time (1..=10,000).
    pub window: i64,
    /// Largest number of requests of one batch (1..=1,000,000).
    pub max_requests: u64,
}

/// A batch's row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BatchRow {
    pub id: BatchId,
    pub tenant_id: TenantId,
    /// Empty where the client gave none.
    pub name: String,
    pub state: BatchState,
    /// The most that all requests may cost together.
    pub budget: Option<MicroUsd>,
    /// Cost of the requests that have ended.
    pub settled: MicroUsd,
    /// Milliseconds since 1970.
    pub created_at_ms: i64,
    /// Begin of the present run; a retry begins another one.
    pub started_at_ms: i64,
    pub finished_at_ms: Option<i64>,
    pub is_deleted: bool,
}

/// Filter of a list of batches.
#[derive(Clone, Debug, Default)]
pub struct BatchFilter {
    pub state: Option<BatchState>,
    /// Only batches older than this id, the last id of the previous page.
    pub before_id: Option<BatchId>,
    pub limit: u32,
}

impl Store {
    /// A batch of the tenant, including deleted batches.
    #[boxed]
    pub async fn batch(&self, tenant_id: &TenantId, id: &BatchId) -> Result<Option<BatchRow>, StoreError> {
        let row =
            sqlx::query("SELECT * FROM batches WHERE id = $1 AND tenant_id = $2 AND state <> 'receiving'")
                .bind(id.as_str())
                .bind(tenant_id.as_str())
                .fetch_optional(&self.readers)
                .await?;
        row.as_ref().map(batch_of).transpose()
    }

    /// Batches of the tenant, newest first.
    #[boxed]
    pub async fn batches(
        &self,
        tenant_id: &TenantId,
        filter: BatchFilter,
    ) -> Result<Vec<BatchRow>, StoreError> {
        let list = ListQuery::of(tenant_id).fixed("deleted_at IS NULL");
        let list = match filter.state {
            Some(state) => list.word("state", Some(state.as_str())),
            None => list.fixed("state <> 'receiving'"),
        };
        let rows =
            list.text("id <", filter.before_id).select("batches", filter.limit).rows(&self.readers).await?;
        rows.iter().map(batch_of).collect()
    }
}

/// Locks the row of a batch until the end of the transaction, and reads it; `None` for a batch that is not there, or
/// still being received.
async fn locked(connection: &mut AnyConnection, id: &BatchId) -> Result<Option<BatchRow>, StoreError> {
    let lock = Dialect::of(connection).lock();
    let query = format!("SELECT * FROM batches WHERE id = $1 AND state <> 'receiving' {lock}");
    let row = sqlx::query(AssertSqlSafe(query)).bind(id.as_str()).fetch_optional(connection).await?;
    row.as_ref().map(batch_of).transpose()
}

/// Notes that the scene of an item has another job: the item is worked on again.
pub(super) async fn scene_retried(
    connection: &mut AnyConnection,
    scene_id: &SceneId,
    job_id: &JobId,
    now_ms: i64,
) -> Result<(), StoreError> {
    let batch_id: Option<String> = sqlx::query_scalar(
        "UPDATE batch_items SET state = 'submitted', job_id = $1, error = NULL, settled_at = NULL
         WHERE scene_id = $2 AND state IN ('failed', 'quarantined', 'cancelled')
           AND (SELECT deleted_at FROM batches WHERE batches.id = batch_items.batch_id) IS NULL
         RETURNING batch_id",
    )
    .bind(job_id.as_str())
    .bind(scene_id.as_str())
    .fetch_optional(&mut *connection)
    .await?;
    let Some(batch_id) = batch_id else { return Ok(()) };
    assign_job(connection, job_id, &batch_id).await?;
    sqlx::query(
        "UPDATE batches SET state = 'running', started_at = $1, finished_at = NULL
         WHERE id = $2 AND state IN ('finished', 'cancelled')",
    )
    .bind(now_ms)
    .bind(batch_id)
    .execute(connection)
    .await?;
    Ok(())
}

/// Marks a job as one of a batch.
async fn assign_job(
    connection: &mut AnyConnection,
    job_id: &JobId,
    batch_id: &str,
) -> Result<(), StoreError> {
    sqlx::query("UPDATE jobs SET batch_id = $1 WHERE id = $2")
        .bind(batch_id)
        .bind(job_id.as_str())
        .execute(connection)
        .await?;
    Ok(())
}

fn batch_of(row: &AnyRow) -> Result<BatchRow, StoreError> {
    let state: String = row.try_get("state")?;
    let corrupt = || StoreError::Corrupt { table: "batches", reason: format!("state {state}") };
    Ok(BatchRow {
        id: database::id(row, "batches", "id")?,
        tenant_id: database::id(row, "batches", "tenant_id")?,
        name: row.try_get("name")?,
        state: BatchState::parse(&state).ok_or_else(corrupt)?,
        budget: row.try_get::<Option<i64>, _>("budget_micro_usd")?.map(MicroUsd),
        settled: MicroUsd(row.try_get("spent_micro_usd")?),
        created_at_ms: row.try_get("created_at")?,
        started_at_ms: row.try_get("started_at")?,
        finished_at_ms: row.try_get("finished_at")?,
        is_deleted: row.try_get::<Option<i64>, _>("deleted_at")?.is_some(),
    })
}

/// The JSON form of an error in its column.
fn error_text(error: &OutputError) -> String {
    // Texts and numbers cannot fail to be written.
    serde_json::to_string(error).unwrap_or_default()
}

fn corrupt_item(reason: String) -> StoreError {
    StoreError::Corrupt { table: "batch_items", reason }
}
