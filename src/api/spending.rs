//! Cost of a scene's calls of remote models, for clients.

use crate::schemas::values::{Id, MAX_INTEGER, Timestamp, Usd};
use crate::schemas::words::Port;
use schemars::JsonSchema;
use serde::Serialize;

use scene::{JobId, MicroUsd};
use store::calls::{CallRow, Spending};

/// Cost of calls of remote models; only when one scene is asked for. No call is made whose reservation would overrun
/// the budget.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Spending")]
pub struct SpendingView {
    #[schemars(with = "Usd")]
    pub budget_usd: f64,
    /// By calls that have ended, with what those of unknown outcome may have cost.
    #[schemars(with = "Usd")]
    pub spent_usd: f64,
    /// For calls under way.
    #[schemars(with = "Usd")]
    pub reserved_usd: f64,
    /// Every try of every call, in order.
    pub calls: Vec<CallView>,
}

/// One try of a call of a remote model.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Call")]
pub struct CallView {
    #[schemars(with = "Id")]
    pub job_id: JobId,
    pub stage: String,
    /// Absent when the stage works on the whole scene.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub instance: String,
    #[schemars(with = "Port")]
    pub port: String,
    pub provider: String,
    pub model: String,
    pub endpoint: String,
    pub operation: String,
    /// The same for every try of a question in one stage of one job.
    pub idempotency_key: String,
    #[schemars(range(min = 1, max = 2_147_483_647))]
    pub attempt: i64,
    #[schemars(with = "Usd")]
    pub reserved_usd: f64,
    /// Null while the call is under way.
    #[schemars(with = "Option<Usd>")]
    pub settled_usd: Option<f64>,
    /// `answered`, `outcome_unknown` (it may have been answered and billed), or the code of a failure; null while the
    /// call is under way.
    pub outcome: Option<String>,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub sent_bytes: i64,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub received_bytes: Option<i64>,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub input_tokens: Option<i64>,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub output_tokens: Option<i64>,
    /// The vendor's id of the job that the call began; null where the answer came at once.
    pub task: Option<String>,
    pub started_at: Timestamp,
    pub finished_at: Option<Timestamp>,
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
            started_at: Timestamp::of_ms(row.started_at_ms),
            finished_at: row.finished_at_ms.map(Timestamp::of_ms),
        }
    }
}
