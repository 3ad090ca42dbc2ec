//! Batches as clients see them.

use serde::Serialize;

use crate::api::views::timestamp;
use ::batches::RequestCounts;
use scene::{BatchId, MicroUsd};
use store::batches::{BatchAccount, BatchRow};

/// A batch and how far it is.
#[derive(Serialize)]
pub(super) struct BatchView {
    id: BatchId,
    name: Option<String>,
    state: &'static str,
    request_counts: RequestCounts,
    /// Share of the requests that are computed to their end, of those that are computed at all.
    progress: f64,
    /// Absent before the first request has ended, and after the last.
    estimate: Option<EstimateView>,
    spending: BatchSpendingView,
    created_at: String,
    finished_at: Option<String>,
    pub(super) links: BatchLinks,
}

/// Expected end of a batch.
#[derive(Serialize)]
struct EstimateView {
    scenes_per_hour: f64,
    time_left_s: f64,
    finish_at: String,
}

/// Money of a batch, US dollars.
#[derive(Serialize)]
struct BatchSpendingView {
    budget_usd: Option<f64>,
    spent_usd: f64,
    reserved_usd: f64,
}

#[derive(Serialize)]
pub(super) struct BatchLinks {
    #[serde(rename = "self")]
    pub(super) this: String,
    output: String,
    errors: String,
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
                finish_at: timestamp(
                    at_ms.saturating_add(i64::try_from(left.as_millis()).unwrap_or(i64::MAX)),
                ),
            }),
            spending: BatchSpendingView {
                budget_usd: row.budget.map(MicroUsd::usd),
                spent_usd: money.spent.usd(),
                reserved_usd: money.reserved.usd(),
            },
            created_at: timestamp(row.created_at_ms),
            finished_at: row.finished_at_ms.map(timestamp),
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
