//! Depth of the queue: what operators watch and autoscalers follow. Only jobs that have not ended are counted, by the
//! partial indexes of the queue, so that the cost does not grow with the jobs that ended.

use std::time::Duration;

use sqlx::Row;

use super::{Store, StoreError};
use crate::boxed;

/// The jobs of all tenants that have not ended, and the deliveries that wait.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct QueueDepth {
    pub queued: i64,
    pub running: i64,
    pub cancelling: i64,
    /// Time for which the queued job that waits longest could have been claimed; zero without one.
    pub longest_wait: Duration,
    /// Deliveries to webhooks that wait.
    pub deliveries: i64,
}

impl Store {
    /// The depth of the queue now.
    ///
    /// # Errors
    ///
    /// The database does not answer.
    #[boxed]
    pub async fn queue_depth(&self) -> Result<QueueDepth, StoreError> {
        let now = self.readers.now_ms().await?;
        // A retry waits from its `not_before` on. Each condition is that of one index.
        let row = sqlx::query(
            "SELECT queued, ready_since,
                    (SELECT COUNT(*) FROM jobs WHERE state IN ('running', 'cancelling')) AS leased,
                    (SELECT COUNT(*) FROM jobs
                     WHERE state IN ('running', 'cancelling') AND state = 'cancelling') AS cancelling,
                    (SELECT COUNT(*) FROM deliveries WHERE state = 'waiting') AS deliveries
             FROM (SELECT COUNT(*) AS queued,
                          MIN(CASE WHEN not_before > created_at THEN not_before ELSE created_at END) AS ready_since
                   FROM jobs WHERE state = 'queued') AS depth",
        )
        .fetch_one(&self.readers)
        .await?;
        let (leased, cancelling): (i64, i64) = (row.try_get("leased")?, row.try_get("cancelling")?);
        let ready_since: Option<i64> = row.try_get("ready_since")?;
        let waited_ms = ready_since.map_or(0, |since| (now - since).max(0));
        Ok(QueueDepth {
            queued: row.try_get("queued")?,
            running: leased - cancelling,
            cancelling,
            longest_wait: Duration::from_millis(waited_ms.unsigned_abs()),
            deliveries: row.try_get("deliveries")?,
        })
    }
}
