//! Cost of a scene's calls of remote models, for clients.

use serde::Serialize;

use super::views::timestamp;
use scene::{JobId, MicroUsd};
use store::calls::{CallRow, Spending};

/// The money of a scene, and every call it went to.
#[derive(Serialize)]
pub struct SpendingView {
    pub budget_usd: f64,
    pub spent_usd: f64,
    pub reserved_usd: f64,
    pub calls: Vec<CallView>,
}

#[derive(Serialize)]
pub struct CallView {
    pub job_id: JobId,
    pub stage: String,
    /// Absent when the stage works on the whole scene.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub instance: String,
    pub port: String,
    pub provider: String,
    pub model: String,
    pub endpoint: String,
    pub operation: String,
    pub idempotency_key: String,
    pub attempt: i64,
    pub reserved_usd: f64,
    pub settled_usd: Option<f64>,
    pub outcome: Option<String>,
    pub sent_bytes: i64,
    pub received_bytes: Option<i64>,
    pub input_tokens: Option<i64>,
    pub output_tokens: Option<i64>,
    pub task: Option<String>,
    pub started_at: String,
    pub finished_at: Option<String>,
}

impl SpendingView {
    pub fn new(spending: Spending, calls: Vec<CallRow>) -> Self {
        Self {
            budget_usd: MicroUsd(spending.budget).usd(),
            spent_usd: MicroUsd(spending.spent).usd(),
            reserved_usd: MicroUsd(spending.reserved).usd(),
            calls: calls.into_iter().map(CallView::new).collect(),
        }
    }
}

impl CallView {
    fn new(row: CallRow) -> Self {
        Self {
            job_id: row.job_id,
            stage: row.stage,
            instance: row.instance,
            port: row.port,
            provider: row.provider,
            model: row.model,
            endpoint: row.endpoint,
            operation: row.operation,
            idempotency_key: row.idempotency_key,
            attempt: row.attempt,
            reserved_usd: MicroUsd(row.reserved_micro_usd).usd(),
            settled_usd: row.settled_micro_usd.map(|settled| MicroUsd(settled).usd()),
            outcome: row.outcome,
            sent_bytes: row.sent_bytes,
            received_bytes: row.received_bytes,
            input_tokens: row.input_tokens,
            output_tokens: row.output_tokens,
            task: row.task,
            started_at: timestamp(row.started_at_ms),
            finished_at: row.finished_at_ms.map(timestamp),
        }
    }
}
