//! Progress of batches: requests by state, pace and money, from the rows of the items.
//!
//! Items in the queue are pending or running until they are settled, so counts agree with the results that are listed.
//! Requests of a recipe that have no items yet count as what they are to become; those of a cancelled batch as
//! cancelled.

use std::collections::HashMap;
use std::time::Duration;

use ::batches::{Pace, RequestCounts, RequestState};
use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::{BatchRow, corrupt_item};
use crate::boxed;
use crate::{Store, StoreError, database};
use scene::{BatchId, MicroUsd};

/// The pace is that of so many requests that ended last.
const MEASURED_ITEMS: i64 = 50;

/// Progress of a batch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BatchAccount {
    pub counts: RequestCounts,
    pub money: BatchMoney,
    /// Of the present run; without items that never had a scene.
    pub pace: Pace,
    /// The time of this account, milliseconds since 1970.
    pub at_ms: i64,
}

/// Money of a batch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BatchMoney {
    /// By all calls so far.
    pub spent: MicroUsd,
    /// Reserved by calls under way.
    pub reserved: MicroUsd,
}

impl Store {
    /// The account of each batch, in the same order.
    #[boxed]
    pub async fn batch_accounts(&self, batches: &[BatchRow]) -> Result<Vec<BatchAccount>, StoreError> {
        let read = async { accounts(&mut *self.readers.acquire().await?, batches).await };
        self.readers.within_limit(read).await
    }

    /// Number of requests in each state.
    #[boxed]
    pub async fn batch_counts(&self, id: &BatchId) -> Result<RequestCounts, StoreError> {
        let read = async { counts_of(&mut *self.readers.acquire().await?, &[id.as_str()]).await };
        Ok(self.readers.within_limit(read).await?.remove(id.as_str()).unwrap_or_default())
    }
}

async fn accounts(
    connection: &mut AnyConnection,
    batches: &[BatchRow],
) -> Result<Vec<BatchAccount>, StoreError> {
    let at_ms = database::now_ms(connection).await?;
    let mut counts = counts(connection, batches).await?;
    let mut accounts = Vec::with_capacity(batches.len());
    for batch in batches {
        accounts.push(BatchAccount {
            counts: counts.remove(batch.id.as_str()).unwrap_or_default(),
            money: money(connection, batch).await?,
            pace: pace(connection, batch, at_ms).await?,
            at_ms,
        });
    }
    Ok(accounts)
}

async fn counts(
    connection: &mut AnyConnection,
    batches: &[BatchRow],
) -> Result<HashMap<String, RequestCounts>, StoreError> {
    let ids: Vec<&str> = batches.iter().map(|batch| batch.id.as_str()).collect();
    counts_of(connection, &ids).await
}

async fn counts_of(
    connection: &mut AnyConnection,
    ids: &[&str],
) -> Result<HashMap<String, RequestCounts>, StoreError> {
    if ids.is_empty() {
        return Ok(HashMap::new());
    }
    let places: Vec<String> = (1..=ids.len()).map(|k| format!("${k}")).collect();
    let places = places.join(", ");
    let query = format!(
        "SELECT batch_id, state, COUNT(*) AS items FROM batch_items
         WHERE batch_id IN ({places}) AND state <> 'submitted' GROUP BY batch_id, state
         UNION ALL
         SELECT i.batch_id, CASE WHEN j.state IS NULL OR j.state = 'queued' THEN 'pending' ELSE 'running' END AS state,
                COUNT(*) AS items
         FROM batch_items AS i LEFT JOIN jobs AS j ON j.id = i.job_id
         WHERE i.batch_id IN ({places}) AND i.state = 'submitted' GROUP BY 1, 2
         UNION ALL
         SELECT batch_id, CASE WHEN is_stopped = 0 THEN 'pending' ELSE 'cancelled' END AS state, pending AS items
         FROM batch_recipes WHERE batch_id IN ({places})
         UNION ALL
         SELECT batch_id, 'duplicate' AS state, duplicate AS items FROM batch_recipes WHERE batch_id IN ({places})
         UNION ALL
         SELECT batch_id, 'invalid' AS state, invalid AS items FROM batch_recipes WHERE batch_id IN ({places})"
    );
    let bound = ids.iter().fold(sqlx::query(AssertSqlSafe(query)), |query, id| query.bind(*id));
    let mut counts: HashMap<String, RequestCounts> = HashMap::new();
    for row in bound.fetch_all(connection).await? {
        let state: String = row.try_get("state")?;
        let state = RequestState::parse(&state).ok_or_else(|| corrupt_item(format!("state {state}")))?;
        let items: i64 = row.try_get("items")?;
        counts
            .entry(row.try_get("batch_id")?)
            .or_default()
            .add_many(state, u64::try_from(items).unwrap_or(0));
    }
    Ok(counts)
}

async fn money(connection: &mut AnyConnection, batch: &BatchRow) -> Result<BatchMoney, StoreError> {
    if batch.state.is_final() {
        return Ok(BatchMoney { spent: batch.settled, reserved: MicroUsd::ZERO });
    }
    let row = sqlx::query(
        "SELECT CAST(COALESCE(SUM(c.settled_micro_usd), 0) AS BIGINT) AS spent,
                CAST(COALESCE(SUM(CASE WHEN c.outcome IS NULL THEN c.reserved_micro_usd END), 0) AS BIGINT) AS reserved,
                (SELECT CAST(COALESCE(SUM(spent_micro_usd), 0) AS BIGINT) FROM batch_items
                 WHERE batch_id = $1 AND state = 'submitted') AS settled
         FROM batch_items AS i JOIN calls AS c ON c.scene_id = i.scene_id
         WHERE i.batch_id = $1 AND i.state = 'submitted'",
    )
    .bind(batch.id.as_str())
    .fetch_one(connection)
    .await?;
    let (spent, settled): (i64, i64) = (row.try_get("spent")?, row.try_get("settled")?);
    let now = MicroUsd(batch.settled.0.saturating_add((spent - settled).max(0)));
    Ok(BatchMoney { spent: now, reserved: MicroUsd(row.try_get("reserved")?) })
}

async fn pace(connection: &mut AnyConnection, batch: &BatchRow, at_ms: i64) -> Result<Pace, StoreError> {
    let row = sqlx::query(
        "SELECT COUNT(*) AS items, MIN(settled_at) AS oldest
         FROM (SELECT settled_at FROM batch_items
               WHERE batch_id = $1 AND settled_at >= $2 AND attempts > 0
               ORDER BY settled_at DESC LIMIT $3) AS lately",
    )
    .bind(batch.id.as_str())
    .bind(batch.started_at_ms)
    .bind(MEASURED_ITEMS)
    .fetch_one(connection)
    .await?;
    let items: i64 = row.try_get("items")?;
    let oldest: Option<i64> = row.try_get("oldest")?;
    // The first of a full window only marks its begin.
    let (items, since) = match oldest {
        Some(oldest) if items == MEASURED_ITEMS => (items - 1, oldest),
        _ => (items, batch.started_at_ms),
    };
    let until = batch.finished_at_ms.unwrap_or(at_ms);
    Ok(Pace {
        finished: u64::try_from(items).unwrap_or(0),
        elapsed: Duration::from_millis(u64::try_from(until - since).unwrap_or(0)),
    })
}
