//! Batches as clients see them.

use schemars::JsonSchema;
use serde::Serialize;

use crate::schemas::values::{BatchBudget, Id, Link, Timestamp};
use crate::schemas::words::BatchState;
use ::batches::RequestCounts;
use scene::{BatchId, MicroUsd};
use store::batches::{BatchAccount, BatchRow};

/// Many requests for scenes.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Batch")]
pub(in crate::api) struct BatchView {
    #[schemars(with = "Id")]
    id: BatchId,
    name: Option<String>,
    #[schemars(with = "BatchState")]
    state: &'static str,
    request_counts: RequestCounts,
    /// Share of the requests that came to their end, without duplicates and invalid ones.
    #[schemars(range(min = 0.0, max = 1.0))]
    progress: f64,
    /// Absent before the first request has ended, and after the last.
    estimate: Option<EstimateView>,
    spending: BatchSpendingView,
    created_at: Timestamp,
    finished_at: Option<Timestamp>,
    pub(super) links: BatchLinks,
}

/// By the pace of the requests that ended last.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "BatchEstimate")]
pub(in crate::api) struct EstimateView {
    #[schemars(range(min = 0.0, max = 1000000000.0))]
    scenes_per_hour: f64,
    #[schemars(range(min = 0.0, max = 3200000000.0))]
    time_left_s: f64,
    finish_at: Timestamp,
}

/// Calls of remote models for all requests, US dollars.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "BatchSpending")]
pub(in crate::api) struct BatchSpendingView {
    #[schemars(with = "Option<BatchBudget>")]
    budget_usd: Option<f64>,
    #[schemars(range(min = 0.0, max = 9000000000.0))]
    spent_usd: f64,
    #[schemars(range(min = 0.0, max = 9000000000.0))]
    reserved_usd: f64,
}

/// Paths of what belongs to a batch.
#[derive(Serialize, JsonSchema)]
pub(in crate::api) struct BatchLinks {
    #[serde(rename = "self")]
    #[schemars(with = "Link")]
    pub(super) this: String,
    #[schemars(with = "Link")]
    output: String,
    #[schemars(with = "Link")]
    errors: String,
    #[schemars(with = "Link")]
    jobs: String,
}

impl BatchView {
    pub(super) fn new(row: BatchRow, account: BatchAccount) -> Self {
        let this = format!("/batches/{}", row.id);
        let BatchAccount { counts, money, pace, at_ms } = account;
        let is_over = row.state.is_final();
        let estimate = pace.per_hour().zip(pace.time_left(counts.remaining())).filter(|_| !is_over);
        Self {
            links: BatchLinks {
                output: format!("{this}/output"),
                errors: format!("{this}/errors"),
                jobs: format!("/jobs?batch={}", row.id),
                this,
            },
            id: row.id,
            name: Some(row.name).filter(|name| !name.is_empty()),
            state: row.state.as_str(),
            request_counts: counts,
            progress: progress(&counts),
            estimate: estimate.map(|(scenes_per_hour, left)| EstimateView {
                scenes_per_hour,
                time_left_s: left.as_secs_f64(),
                finish_at: Timestamp::of_ms(
                    at_ms.saturating_add(i64::try_from(left.as_millis()).unwrap_or(i64::MAX)),
                ),
            }),
            spending: BatchSpendingView {
                budget_usd: row.budget.map(MicroUsd::usd),
                spent_usd: money.spent.usd(),
                reserved_usd: money.reserved.usd(),
            },
            created_at: Timestamp::of_ms(row.created_at_ms),
            finished_at: row.finished_at_ms.map(Timestamp::of_ms),
        }
    }
}

fn progress(counts: &RequestCounts) -> f64 {
    match counts.computed() {
        0 => 1.0,
        computed => counts.finished() as f64 / computed as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_leaves_out_what_is_never_computed() {
        let counts = RequestCounts {
            total: 10,
            pending: 3,
            running: 1,
            succeeded: 2,
            failed: 2,
            duplicate: 1,
            invalid: 1,
            ..RequestCounts::default()
        };
        assert_eq!(progress(&counts), 0.5);
        assert_eq!(progress(&RequestCounts { total: 1, invalid: 1, ..RequestCounts::default() }), 1.0);
    }
}
