//! Time and order in which jobs run.
//!
//! A tenant's jobs run in the order of their rank: the time of submission, or `not_before` if that is later, moved
//! earlier by `priority_step_secs` for each step of priority. Ranks never change, so a waiting job overtakes every
//! job that is submitted more than that much later, whatever its priority: this is linear aging without a sweep.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use sqlx::{AnyConnection, Row};

use crate::StoreError;
use scene::JobId;

/// Section `[queue]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Scenes of all tenants that may wait (1..=10,000,000).
    pub max_jobs: i64,
    /// Time by which a job of priority 1 counts as submitted earlier, seconds.
    pub priority_step_secs: i64,
    /// Time from the submission to the deadline of jobs whose request names none, seconds.
    pub deadline_secs: i64,
}

/// Start of a new job, and its queue. Times are milliseconds since 1970.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    pub queue: Settings,
    /// Within the tenant; 0 is usual, more is sooner.
    pub priority: i64,
    /// The job does not start earlier.
    pub not_before_ms: Option<i64>,
    /// The job fails if it has not ended by then.
    pub deadline_ms: Option<i64>,
}

/// Columns of a new job about its place in the queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct QueueColumns {
    pub(crate) priority: i64,
    pub(crate) not_before: i64,
    pub(crate) rank_at: i64,
    pub(crate) deadline_at: Option<i64>,
    pub(crate) request_version: i64,
}

impl Schedule {
    /// At once, with the usual priority and the usual deadline.
    pub fn usual(queue: Settings) -> Self {
        Self { queue, priority: 0, not_before_ms: None, deadline_ms: None }
    }

    /// Whether the job is the last of its tenant's queue when it comes.
    pub(crate) fn is_usual(&self) -> bool {
        self.priority == 0 && self.not_before_ms.is_none()
    }

    fn columns(&self, request_version: i64, now_ms: i64) -> QueueColumns {
        let not_before = self.not_before_ms.unwrap_or(0);
        let advance_ms = self.priority.saturating_mul(self.queue.priority_step_secs.saturating_mul(1000));
        let usual_deadline =
            now_ms.max(not_before).saturating_add(self.queue.deadline_secs.saturating_mul(1000));
        QueueColumns {
            priority: self.priority,
            not_before,
            rank_at: now_ms.max(not_before).saturating_sub(advance_ms),
            deadline_at: Some(self.deadline_ms.unwrap_or(usual_deadline)),
            request_version,
        }
    }
}

impl QueueColumns {
    /// Columns of a new scene's first job; without a schedule it is for now and has no deadline.
    pub(crate) fn of_new(schedule: Option<&Schedule>, request: &Value, now_ms: i64) -> Self {
        let request_version = request["version"].as_i64().unwrap_or(1);
        let for_now =
            Self { priority: 0, not_before: 0, rank_at: now_ms, deadline_at: None, request_version };
        schedule.map_or(for_now, |schedule| schedule.columns(request_version, now_ms))
    }

    /// Columns of a job that repeats another one: the same priority, and as much time as that one had.
    pub(crate) async fn of_retry(
        connection: &mut AnyConnection,
        retried: &JobId,
        now_ms: i64,
    ) -> Result<Self, StoreError> {
        let row = sqlx::query(
            "SELECT priority, created_at, rank_at, not_before, deadline_at, request_version FROM jobs WHERE id = $1",
        )
        .bind(retried.as_str())
        .fetch_one(connection)
        .await?;
        let created_at: i64 = row.try_get("created_at")?;
        let rank_at: Option<i64> = row.try_get("rank_at")?;
        let deadline_at: Option<i64> = row.try_get("deadline_at")?;
        Ok(Self {
            priority: row.try_get("priority")?,
            not_before: 0,
            // A job for a later time ranked later; its retry is for now.
            rank_at: now_ms + rank_at.map_or(0, |rank_at| (rank_at - created_at).min(0)),
            deadline_at: deadline_at.map(|deadline_at| now_ms + (deadline_at - created_at).max(0)),
            request_version: row.try_get("request_version")?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn rank_ages_and_priority_is_worth_its_step() {
        let queue = Settings { max_jobs: 9, priority_step_secs: 600, deadline_secs: 60 };
        let usual = Schedule::usual(queue);
        let request = json!({ "version": 2 });
        let columns = |schedule: &Schedule, now_ms| QueueColumns::of_new(Some(schedule), &request, now_ms);
        let rank = |priority, now_ms| columns(&Schedule { priority, ..usual.clone() }, now_ms).rank_at;
        assert!(rank(1, 1_000_000) < rank(0, 1_000_000), "more urgent");
        assert!(rank(0, 0) < rank(1, 600_001), "but not more urgent than ten minutes of waiting");
        assert!(rank(1, 599_999) < rank(0, 0));
        let later = columns(&Schedule { not_before_ms: Some(5_000), ..usual.clone() }, 1_000);
        assert_eq!(later.rank_at, 5_000, "the time before its time is no waiting");
        assert_eq!((later.deadline_at, later.request_version), (Some(65_000), 2));
        assert_eq!(columns(&usual, 1_000).deadline_at, Some(61_000));
    }
}
