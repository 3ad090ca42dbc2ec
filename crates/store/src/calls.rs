//! The ledger: one row for every try of every call of a remote model.
//!
//! A row is committed, and its cost set aside, before anything is sent; the check against the scene's budget and the
//! row are one transaction of the one writer, so any number of calls at the same time cannot overrun it. A row that
//! is still under way when its job changes hands, or leaves its worker, becomes `outcome_unknown`: the vendor may have
//! answered and billed, so what was set aside stays spent.

use sqlx::sqlite::SqliteRow;
use sqlx::{Row, SqliteConnection};

use super::queue::guard;
use super::{Digest, Lease, Store, StoreError, database};

/// The outcome of a call of which nobody knows whether it was answered and billed.
pub const OUTCOME_UNKNOWN: &str = "outcome_unknown";

/// A call that is about to be sent. Money is in millionths of a US dollar.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewCall {
    pub stage: String,
    /// Empty for the whole scene.
    pub instance: String,
    pub port: String,
    pub provider: String,
    pub model: String,
    pub endpoint: String,
    pub operation: String,
    pub request_digest: String,
    pub idempotency_key: String,
    pub attempt: u32,
    pub reserved_micro_usd: i64,
    pub sent_bytes: u64,
    /// Refuse it where an earlier call of this job with the same key has an unknown outcome.
    pub refuse_after_unknown: bool,
}

/// What came of asking to make a call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reserved {
    /// The row's id.
    Granted(i64),
    /// Nothing was written. All in millionths of a US dollar.
    OverBudget { committed: i64, budget: i64 },
    /// Nothing was written: an earlier one may have been answered.
    OutcomeUnknown,
}

/// How a call ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CallEnd {
    /// `None` = unknown; then what was set aside counts.
    pub settled_micro_usd: Option<i64>,
    pub outcome: String,
    pub received_bytes: u64,
    pub input_tokens: Option<u64>,
    pub output_tokens: Option<u64>,
    /// The vendor's id of the job it has begun, where the answer comes later.
    pub task: Option<String>,
    /// The blob with the answer, if it may be used again.
    pub answer: Option<Digest>,
}

/// A row of the ledger.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CallRow {
    pub id: i64,
    pub job_id: String,
    pub stage: String,
    /// Empty for the whole scene.
    pub instance: String,
    pub port: String,
    pub provider: String,
    pub model: String,
    pub endpoint: String,
    pub operation: String,
    pub idempotency_key: String,
    pub attempt: i64,
    pub reserved_micro_usd: i64,
    /// `None` while the call is under way.
    pub settled_micro_usd: Option<i64>,
    pub outcome: Option<String>,
    pub sent_bytes: i64,
    pub received_bytes: Option<i64>,
    pub input_tokens: Option<i64>,
    pub output_tokens: Option<i64>,
    /// The vendor's id of the job it has begun, where the answer comes later.
    pub task: Option<String>,
    /// Milliseconds since 1970.
    pub started_at_ms: i64,
    pub finished_at_ms: Option<i64>,
}

/// The money of one scene, millionths of a US dollar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spending {
    pub budget: i64,
    /// By calls that have ended, with what those of unknown outcome may have cost.
    pub spent: i64,
    /// For calls under way.
    pub reserved: i64,
}

impl Store {
    /// Writes a call down and sets its cost aside, if the scene's budget has room for it.
    pub async fn reserve_call(&self, lease: &Lease, call: NewCall) -> Result<Reserved, StoreError> {
        let lease = lease.clone();
        self.writer
            .write("reserve a call", move |connection| {
                Box::pin(async move { reserve(connection, &lease, &call).await })
            })
            .await
    }

    /// Writes down how a call ended. A call that somebody has declared unknown meanwhile stays so.
    pub async fn settle_call(&self, lease: &Lease, id: i64, end: CallEnd) -> Result<(), StoreError> {
        let lease = lease.clone();
        self.writer
            .write("settle a call", move |connection| {
                Box::pin(async move {
                    guard(connection, &lease).await?;
                    let now = database::now_ms(connection).await?;
                    sqlx::query(
                        "UPDATE calls SET settled_micro_usd = COALESCE(?, reserved_micro_usd), outcome = ?,
                                          received_bytes = ?, input_tokens = ?, output_tokens = ?, finished_at = ?,
                                          task = ?, task_state = CASE WHEN ? THEN 'submitted' END,
                                          answer_file = ?
                         WHERE id = ? AND job_id = ? AND outcome IS NULL",
                    )
                    .bind(end.settled_micro_usd)
                    .bind(end.outcome)
                    .bind(end.received_bytes as i64)
                    .bind(end.input_tokens.map(|tokens| i64::try_from(tokens).unwrap_or(i64::MAX)))
                    .bind(end.output_tokens.map(|tokens| i64::try_from(tokens).unwrap_or(i64::MAX)))
                    .bind(now)
                    .bind(&end.task)
                    .bind(end.task.is_some())
                    .bind(end.answer.as_ref().map(Digest::as_str))
                    .bind(id)
                    .bind(&lease.job_id)
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            })
            .await
    }

    /// All calls of a scene, in the order they were made.
    pub async fn calls(&self, scene_id: &str) -> Result<Vec<CallRow>, StoreError> {
        let rows = sqlx::query("SELECT * FROM calls WHERE scene_id = ? ORDER BY id")
            .bind(scene_id)
            .fetch_all(&self.readers)
            .await?;
        rows.iter().map(call_of).collect()
    }

    /// What a scene may cost, and what it has cost.
    pub async fn spending(&self, scene_id: &str) -> Result<Spending, StoreError> {
        let mut connection = self.readers.acquire().await?;
        spending(&mut connection, scene_id).await
    }
}

async fn reserve(
    connection: &mut SqliteConnection,
    lease: &Lease,
    call: &NewCall,
) -> Result<Reserved, StoreError> {
    guard(connection, lease).await?;
    let row = sqlx::query("SELECT tenant_id, scene_id FROM jobs WHERE id = ?")
        .bind(&lease.job_id)
        .fetch_one(&mut *connection)
        .await?;
    let (tenant_id, scene_id): (String, String) = (row.try_get("tenant_id")?, row.try_get("scene_id")?);
    if call.refuse_after_unknown {
        let unknown: Option<i64> = sqlx::query_scalar(
            "SELECT 1 FROM calls WHERE job_id = ? AND idempotency_key = ? AND outcome = ? LIMIT 1",
        )
        .bind(&lease.job_id)
        .bind(&call.idempotency_key)
        .bind(OUTCOME_UNKNOWN)
        .fetch_optional(&mut *connection)
        .await?;
        if unknown.is_some() {
            return Ok(Reserved::OutcomeUnknown);
        }
    }
    let Spending { budget, spent, reserved } = spending(connection, &scene_id).await?;
    let committed = spent.saturating_add(reserved);
    // What costs nothing is always granted, even where vendors billed more than was set aside.
    if call.reserved_micro_usd > 0 && committed.saturating_add(call.reserved_micro_usd) > budget {
        return Ok(Reserved::OverBudget { committed, budget });
    }
    let now = database::now_ms(connection).await?;
    let id = sqlx::query_scalar(
        "INSERT INTO calls (tenant_id, scene_id, job_id, epoch, stage, instance, port, provider, model, endpoint,
                            operation, request_digest, idempotency_key, attempt, reserved_micro_usd, sent_bytes,
                            started_at)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) RETURNING id",
    )
    .bind(tenant_id)
    .bind(scene_id)
    .bind(&lease.job_id)
    .bind(lease.epoch)
    .bind(&call.stage)
    .bind(&call.instance)
    .bind(&call.port)
    .bind(&call.provider)
    .bind(&call.model)
    .bind(&call.endpoint)
    .bind(&call.operation)
    .bind(&call.request_digest)
    .bind(&call.idempotency_key)
    .bind(call.attempt)
    .bind(call.reserved_micro_usd)
    .bind(call.sent_bytes as i64)
    .bind(now)
    .fetch_one(connection)
    .await?;
    Ok(Reserved::Granted(id))
}

async fn spending(connection: &mut SqliteConnection, scene_id: &str) -> Result<Spending, StoreError> {
    let row = sqlx::query(
        "SELECT COALESCE((SELECT budget_micro_usd FROM scenes WHERE id = ?1), 0) AS budget,
                COALESCE(SUM(settled_micro_usd), 0) AS spent,
                COALESCE(SUM(CASE WHEN outcome IS NULL THEN reserved_micro_usd END), 0) AS reserved
         FROM calls WHERE scene_id = ?1",
    )
    .bind(scene_id)
    .fetch_one(connection)
    .await?;
    Ok(Spending {
        budget: row.try_get("budget")?,
        spent: row.try_get("spent")?,
        reserved: row.try_get("reserved")?,
    })
}

/// Of a job that changes hands or leaves its worker: nobody will ever settle its calls under way.
pub(super) async fn abandon(
    connection: &mut SqliteConnection,
    job_id: &str,
    now_ms: i64,
) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE calls SET settled_micro_usd = reserved_micro_usd, outcome = ?, finished_at = ?
         WHERE job_id = ? AND outcome IS NULL",
    )
    .bind(OUTCOME_UNKNOWN)
    .bind(now_ms)
    .bind(job_id)
    .execute(connection)
    .await?;
    Ok(())
}

fn call_of(row: &SqliteRow) -> Result<CallRow, StoreError> {
    Ok(CallRow {
        id: row.try_get("id")?,
        job_id: row.try_get("job_id")?,
        stage: row.try_get("stage")?,
        instance: row.try_get("instance")?,
        port: row.try_get("port")?,
        provider: row.try_get("provider")?,
        model: row.try_get("model")?,
        endpoint: row.try_get("endpoint")?,
        operation: row.try_get("operation")?,
        idempotency_key: row.try_get("idempotency_key")?,
        attempt: row.try_get("attempt")?,
        reserved_micro_usd: row.try_get("reserved_micro_usd")?,
        settled_micro_usd: row.try_get("settled_micro_usd")?,
        outcome: row.try_get("outcome")?,
        sent_bytes: row.try_get("sent_bytes")?,
        received_bytes: row.try_get("received_bytes")?,
        input_tokens: row.try_get("input_tokens")?,
        output_tokens: row.try_get("output_tokens")?,
        task: row.try_get("task")?,
        started_at_ms: row.try_get("started_at")?,
        finished_at_ms: row.try_get("finished_at")?,
    })
}
