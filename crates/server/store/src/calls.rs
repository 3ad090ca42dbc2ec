//! The ledger: one row per attempt of every call of a remote model.
//!
//! A row is committed, and its cost reserved, before the request is sent. The budget check and the insert are one
//! transaction that locks the job, and a scene has one active job, so concurrent calls cannot exceed the budget. An
//! unsettled row becomes `outcome_unknown` when its job leaves its worker: the vendor may have answered and billed,
//! so the reserved cost counts as spent.
//!
//! A call about a finished scene outside any job (an instruction that is read when its order comes) is a row of the
//! scene's last job, under the budget of the scene. Nothing holds a lease then, so such a row that was never settled
//! becomes `outcome_unknown` by its age.

use sqlx::any::AnyRow;
use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::database::Dialect;
use super::limits::{LimitSettings, Month};
use super::queue::guard;
use super::{Digest, Lease, Store, StoreError, database, limits};
use crate::boxed;
use scene::{JobId, SceneId, TenantId};

/// Outcome of a call that may or may not have been answered and billed.
pub const OUTCOME_UNKNOWN: &str = "outcome_unknown";

/// A call to be sent. Money is in millionths of a US dollar.
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
    /// Reject the call if an earlier call of this job with the same key has an unknown outcome.
    pub refuse_after_unknown: bool,
}

/// Result of a reservation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reservation {
    /// Reservation; the id of the row.
    Granted(i64),
    /// Rejected, nothing was written. Amounts in millionths of a US dollar.
    OverBudget { committed: i64, budget: i64 },
    /// Rejected, nothing was written: the tenant has spent what it may in this month. Amounts as before.
    OverMonth { committed: i64, limit: i64 },
    /// Rejected, nothing was written: an earlier call may have been answered.
    OutcomeUnknown,
}

/// End of a call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CallEnd {
    /// `None` = unknown; then the reserved cost counts.
    pub settled_micro_usd: Option<i64>,
    pub outcome: String,
    pub received_bytes: u64,
    pub input_tokens: Option<u64>,
    pub output_tokens: Option<u64>,
    /// The vendor's id of the started job, for asynchronous calls.
    pub task: Option<String>,
    /// The blob with the answer, if the answer is reusable.
    pub answer: Option<Digest>,
}

/// A row of the ledger.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CallRow {
    pub id: i64,
    pub job_id: JobId,
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
    /// `None` while the call is in flight.
    pub settled_micro_usd: Option<i64>,
    pub outcome: Option<String>,
    pub sent_bytes: i64,
    pub received_bytes: Option<i64>,
    pub input_tokens: Option<i64>,
    pub output_tokens: Option<i64>,
    /// The vendor's id of the started job, for asynchronous calls.
    pub task: Option<String>,
    /// Milliseconds since 1970.
    pub started_at_ms: i64,
    pub finished_at_ms: Option<i64>,
}

/// Budget and cost of one scene, millionths of a US dollar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spending {
    pub budget: i64,
    /// Cost of ended calls, including the reserved cost of calls with unknown outcome.
    pub spent: i64,
    /// Reservation cost of calls in flight.
    pub reserved: i64,
}

impl Store {
    /// Inserts a call and reserves its cost, if the scene's budget allows it.
    #[boxed]
    pub async fn reserve_call(&self, lease: &Lease, call: NewCall) -> Result<Reservation, StoreError> {
        let (lease, limits) = (lease.clone(), *self.admission.settings());
        self.writer
            .write("reserve a call", move |connection| {
                Box::pin(async move { reserve(connection, &lease, &call, &limits).await })
            })
            .await
    }

    /// The same about a finished scene; `None` where the tenant has no such scene. Calls of it that were never settled
    /// and are older than `given_up_after_ms` count as of unknown outcome.
    #[boxed]
    pub async fn reserve_call_about(
        &self,
        tenant_id: &TenantId,
        scene_id: &SceneId,
        call: NewCall,
        given_up_after_ms: i64,
    ) -> Result<Option<Reservation>, StoreError> {
        let (tenant_id, scene_id, limits) = (tenant_id.clone(), scene_id.clone(), *self.admission.settings());
        self.writer
            .write("reserve a call about a scene", move |connection| {
                Box::pin(async move {
                    let Some(booking) = Booking::of_scene(connection, tenant_id, scene_id).await? else {
                        return Ok(None);
                    };
                    let now = database::now_ms(connection).await?;
                    give_up(connection, &booking, &call.stage, now - given_up_after_ms, now).await?;
                    insert(connection, &booking, &call, &limits).await.map(Some)
                })
            })
            .await
    }

    /// Records the end of a call. A call that is already `outcome_unknown` does not change.
    #[boxed]
    pub async fn settle_call(&self, lease: &Lease, id: i64, end: CallEnd) -> Result<(), StoreError> {
        let lease = lease.clone();
        self.writer
            .write("settle a call", move |connection| {
                Box::pin(async move {
                    guard(connection, &lease).await?;
                    settle(connection, &lease.job_id, id, end).await
                })
            })
            .await
    }

    /// The same of a call about a finished scene, in whose last job it was booked.
    #[boxed]
    pub async fn settle_call_about(&self, job_id: &JobId, id: i64, end: CallEnd) -> Result<(), StoreError> {
        let job_id = job_id.clone();
        self.writer
            .write("settle a call about a scene", move |connection| {
                Box::pin(async move { settle(connection, &job_id, id, end).await })
            })
            .await
    }

    /// All calls of a scene, oldest first.
    #[boxed]
    pub async fn calls(&self, tenant_id: &TenantId, scene_id: &SceneId) -> Result<Vec<CallRow>, StoreError> {
        let rows = sqlx::query("SELECT * FROM calls WHERE scene_id = $1 AND tenant_id = $2 ORDER BY id")
            .bind(scene_id.as_str())
            .bind(tenant_id.as_str())
            .fetch_all(&self.readers)
            .await?;
        rows.iter().map(call_of).collect()
    }

    /// Budget and cost of a scene.
    #[boxed]
    pub async fn spending(&self, tenant_id: &TenantId, scene_id: &SceneId) -> Result<Spending, StoreError> {
        let read = async { spending(&mut *self.readers.acquire().await?, tenant_id, scene_id).await };
        self.readers.within_limit(read).await
    }
}

/// The job that a call is booked in.
struct Booking {
    tenant_id: TenantId,
    scene_id: SceneId,
    job_id: JobId,
    epoch: i64,
}

impl Booking {
    /// In the job of a lease.
    async fn of_lease(connection: &mut AnyConnection, lease: &Lease) -> Result<Self, StoreError> {
        guard(connection, lease).await?;
        let row = sqlx::query("SELECT tenant_id, scene_id FROM jobs WHERE id = $1")
            .bind(lease.job_id.as_str())
            .fetch_one(connection)
            .await?;
        Ok(Self {
            tenant_id: database::id(&row, "jobs", "tenant_id")?,
            scene_id: database::id(&row, "jobs", "scene_id")?,
            job_id: lease.job_id.clone(),
            epoch: lease.epoch,
        })
    }

    /// In the last job of a scene, whose row is locked: calls at once stay within the budget together.
    async fn of_scene(
        connection: &mut AnyConnection,
        tenant_id: TenantId,
        scene_id: SceneId,
    ) -> Result<Option<Self>, StoreError> {
        let lock = Dialect::of(connection).lock();
        let row = sqlx::query(AssertSqlSafe(format!(
            "SELECT id, epoch FROM jobs WHERE scene_id = $1 AND tenant_id = $2 ORDER BY id DESC LIMIT 1 {lock}",
        )))
        .bind(scene_id.as_str())
        .bind(tenant_id.as_str())
        .fetch_optional(connection)
        .await?;
        let Some(row) = row else { return Ok(None) };
        let (job_id, epoch) = (database::id(&row, "jobs", "id")?, row.try_get("epoch")?);
        Ok(Some(Self { tenant_id, scene_id, job_id, epoch }))
    }
}

async fn reserve(
    connection: &mut AnyConnection,
    lease: &Lease,
    call: &NewCall,
    limits: &LimitSettings,
) -> Result<Reservation, StoreError> {
    let booking = Booking::of_lease(connection, lease).await?;
    insert(connection, &booking, call, limits).await
}

async fn settle(
    connection: &mut AnyConnection,
    job_id: &JobId,
    id: i64,
    end: CallEnd,
) -> Result<(), StoreError> {
    let now = database::now_ms(connection).await?;
    sqlx::query(
        "UPDATE calls SET settled_micro_usd = COALESCE($1, reserved_micro_usd), outcome = $2,
                          received_bytes = $3, input_tokens = $4, output_tokens = $5, finished_at = $6,
                          task = $7, task_state = CASE WHEN $8 THEN 'submitted' END,
                          answer_file = $9
         WHERE id = $10 AND job_id = $11 AND outcome IS NULL",
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
    .bind(job_id.as_str())
    .execute(connection)
    .await?;
    Ok(())
}

/// Marks calls of a stage as of unknown outcome that were started before a time and never settled.
async fn give_up(
    connection: &mut AnyConnection,
    booking: &Booking,
    stage: &str,
    started_before_ms: i64,
    now_ms: i64,
) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE calls SET settled_micro_usd = reserved_micro_usd, outcome = $1, finished_at = $2
         WHERE job_id = $3 AND stage = $4 AND outcome IS NULL AND started_at < $5",
    )
    .bind(OUTCOME_UNKNOWN)
    .bind(now_ms)
    .bind(booking.job_id.as_str())
    .bind(stage)
    .bind(started_before_ms)
    .execute(connection)
    .await?;
    Ok(())
}

async fn insert(
    connection: &mut AnyConnection,
    booking: &Booking,
    call: &NewCall,
    limits: &LimitSettings,
) -> Result<Reservation, StoreError> {
    let Booking { tenant_id, scene_id, job_id, epoch } = booking;
    if call.refuse_after_unknown {
        let unknown: Option<i64> = sqlx::query_scalar(
            "SELECT 1 FROM calls WHERE job_id = $1 AND idempotency_key = $2 AND outcome = $3 LIMIT 1",
        )
        .bind(job_id.as_str())
        .bind(&call.idempotency_key)
        .bind(OUTCOME_UNKNOWN)
        .fetch_optional(&mut *connection)
        .await?;
        if unknown.is_some() {
            return Ok(Reservation::OutcomeUnknown);
        }
    }
    let Spending { budget, spent, reserved } = spending(connection, tenant_id, scene_id).await?;
    let committed = spent.saturating_add(reserved);
    // Free calls are always granted, even if vendors billed more than was reserved.
    if call.reserved_micro_usd > 0 && committed.saturating_add(call.reserved_micro_usd) > budget {
        return Ok(Reservation::OverBudget { committed, budget });
    }
    if call.reserved_micro_usd > 0
        && let Some(refused) = over_month(connection, tenant_id, call, limits).await?
    {
        return Ok(refused);
    }
    let now = database::now_ms(connection).await?;
    let id = sqlx::query_scalar(
        "INSERT INTO calls (tenant_id, scene_id, job_id, epoch, stage, instance, port, provider, model, endpoint,
                            operation, request_digest, idempotency_key, attempt, reserved_micro_usd, sent_bytes,
                            started_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17) RETURNING id",
    )
    .bind(tenant_id.as_str())
    .bind(scene_id.as_str())
    .bind(job_id.as_str())
    .bind(*epoch)
    .bind(&call.stage)
    .bind(&call.instance)
    .bind(&call.port)
    .bind(&call.provider)
    .bind(&call.model)
    .bind(&call.endpoint)
    .bind(&call.operation)
    .bind(&call.request_digest)
    .bind(&call.idempotency_key)
    .bind(i64::from(call.attempt))
    .bind(call.reserved_micro_usd)
    .bind(call.sent_bytes as i64)
    .bind(now)
    .fetch_one(connection)
    .await?;
    Ok(Reservation::Granted(id))
}

/// The refusal of a call beyond what its tenant may spend in a month. Calls of a limited tenant follow each other, so
/// that those at once stay within it together.
async fn over_month(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    call: &NewCall,
    limits: &LimitSettings,
) -> Result<Option<Reservation>, StoreError> {
    let limit = limits::of_tenant(connection, limits, tenant_id).await?.micro_usd_per_month;
    if limit == 0 {
        return Ok(None);
    }
    limits::one_at_a_time(connection, &format!("calls {tenant_id}")).await?;
    let month = Month::now(connection).await?;
    let committed = limits::of_month(connection, tenant_id, &month).await?;
    let is_over = committed.saturating_add(call.reserved_micro_usd) > limit;
    Ok(is_over.then_some(Reservation::OverMonth { committed, limit }))
}

async fn spending(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    scene_id: &SceneId,
) -> Result<Spending, StoreError> {
    let row = sqlx::query(
        "SELECT COALESCE((SELECT budget_micro_usd FROM scenes WHERE id = $1 AND tenant_id = $2), 0) AS budget,
                CAST(COALESCE(SUM(settled_micro_usd), 0) AS BIGINT) AS spent,
                CAST(COALESCE(SUM(CASE WHEN outcome IS NULL THEN reserved_micro_usd END), 0) AS BIGINT) AS reserved
         FROM calls WHERE scene_id = $1 AND tenant_id = $2",
    )
    .bind(scene_id.as_str())
    .bind(tenant_id.as_str())
    .fetch_one(connection)
    .await?;
    Ok(Spending {
        budget: row.try_get("budget")?,
        spent: row.try_get("spent")?,
        reserved: row.try_get("reserved")?,
    })
}

/// Marks the calls in flight of a job that leaves its worker as `outcome_unknown`.
pub(super) async fn abandon(
    connection: &mut AnyConnection,
    job_id: &JobId,
    now_ms: i64,
) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE calls SET settled_micro_usd = reserved_micro_usd, outcome = $1, finished_at = $2
         WHERE job_id = $3 AND outcome IS NULL",
    )
    .bind(OUTCOME_UNKNOWN)
    .bind(now_ms)
    .bind(job_id.as_str())
    .execute(connection)
    .await?;
    Ok(())
}

fn call_of(row: &AnyRow) -> Result<CallRow, StoreError> {
    Ok(CallRow {
        id: row.try_get("id")?,
        job_id: database::id(row, "calls", "job_id")?,
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
