//! The durable job queue: claim, renew, finish, release, cancel.
//!
//! A claim increments the job's epoch (a fencing token). Every later write of the worker is guarded by owner and epoch,
//! so a worker that was paused past its lease changes no row. Lease times use the database's clock. State changes go
//! through [`JobState::after`] only.

use std::time::Duration;

use serde_json::{Value, json};
use sqlx::{Row, SqliteConnection};

use super::artifacts::BuiltScene;
use super::{Store, StoreError, artifacts, calls, database, events};
use scene::job::{Failure, FailureClass, JobEvent, JobState};
use scene::{JobId, SceneId, TenantId};

/// The right to write rows of a job: valid while `owner` and `epoch` equal those of its row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lease {
    pub job_id: JobId,
    pub owner: String,
    pub epoch: i64,
}

/// A claimed job.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    pub lease: Lease,
    pub tenant_id: TenantId,
    pub scene_id: SceneId,
    /// The scene's request, as JSON.
    pub request: Value,
    /// Claims since the last new checkpoint, this one included.
    pub attempt: i64,
    /// `cancelling` if the worker only has to acknowledge the cancellation.
    pub state: JobState,
    /// Stage and salt: checkpoint keys are salted from this stage on.
    pub salt: Option<(String, String)>,
}

/// Result of a job attempt.
#[derive(Clone, Debug)]
pub enum AttemptOutcome {
    /// The scene is built and certified (pass or quarantine).
    Built(Box<BuiltScene>),
    Failed(Failure),
    /// Back to the queue for at least `delay`. An uncharged attempt does not count. The `max_attempts`-th charged
    /// attempt since the last new checkpoint is a failure instead.
    Retry {
        failure: Failure,
        delay: Duration,
        charged: bool,
        max_attempts: u32,
    },
    /// The worker shuts down: back to the queue, uncharged.
    Released,
    /// The worker stopped because of a cancellation.
    Stopped,
}

/// Result of a cancellation request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CancelOutcome {
    /// The job's state now.
    Accepted(JobState),
    /// The job had already ended.
    TooLate(JobState),
    NotFound,
}

impl Store {
    /// Claims the next job: a job with an expired lease, else the first of the queue by priority and age. A job whose
    /// worker died `max_attempts` times without a new checkpoint fails instead. `only` restricts the claim to one job.
    pub async fn claim(
        &self,
        owner: &str,
        lease: Duration,
        max_attempts: u32,
        only: Option<&JobId>,
    ) -> Result<Option<Claim>, StoreError> {
        let (owner, only) = (owner.to_owned(), only.cloned());
        let claim = self
            .writer
            .write("claim a job", move |connection| {
                Box::pin(claim(connection, owner, lease, i64::from(max_attempts), only))
            })
            .await?;
        if claim.is_some() {
            self.announce();
        }
        Ok(claim)
    }

    /// Extends leases. Returns the state of each job, or `None` if its lease is lost.
    pub async fn renew(
        &self,
        leases: Vec<Lease>,
        lease: Duration,
    ) -> Result<Vec<(Lease, Option<JobState>)>, StoreError> {
        self.writer.write("renew leases", move |connection| Box::pin(renew(connection, leases, lease))).await
    }

    /// Ends an attempt. Returns the job's state, which is `cancelled` if the work ended after a cancellation request.
    ///
    /// # Errors
    ///
    /// [`StoreError::LeaseLost`] if the lease is no longer valid.
    pub async fn finish(&self, lease: &Lease, outcome: AttemptOutcome) -> Result<JobState, StoreError> {
        let lease = lease.clone();
        let state = self
            .writer
            .write("finish a job", move |connection| Box::pin(finish(connection, lease, outcome)))
            .await?;
        self.announce();
        Ok(state)
    }

    /// Requests the cancellation of a job.
    pub async fn cancel(&self, tenant_id: &TenantId, job_id: &JobId) -> Result<CancelOutcome, StoreError> {
        let (tenant_id, job_id) = (tenant_id.clone(), job_id.clone());
        let answer = self
            .writer
            .write("cancel a job", move |connection| Box::pin(cancel(connection, tenant_id, job_id)))
            .await?;
        self.announce();
        self.cancelled.send_modify(|tick| *tick += 1);
        Ok(answer)
    }

    /// Expires the leases of all other owners and returns their number. This is correct because one process locks the
    /// data directory, so all other owners are dead.
    pub async fn expire_leases_of_others(&self, owner: &str) -> Result<u64, StoreError> {
        let owner = owner.to_owned();
        self.writer
            .write("expire the leases of dead workers", move |connection| {
                Box::pin(async move {
                    let done = sqlx::query(
                        "UPDATE jobs SET lease_until = 0
                         WHERE state IN ('running', 'cancelling') AND owner IS NOT ?",
                    )
                    .bind(owner)
                    .execute(connection)
                    .await?;
                    Ok(done.rows_affected())
                })
            })
            .await
    }
}

async fn claim(
    connection: &mut SqliteConnection,
    owner: String,
    lease: Duration,
    max_attempts: i64,
    only: Option<JobId>,
) -> Result<Option<Claim>, StoreError> {
    let now = database::now_ms(connection).await?;
    loop {
        let orphan: Option<(String, i64)> = sqlx::query_as(
            "SELECT id, attempt FROM jobs
             WHERE state IN ('running', 'cancelling') AND lease_until <= ?1 AND (?2 IS NULL OR id = ?2)
             ORDER BY lease_until LIMIT 1",
        )
        .bind(now)
        .bind(only.as_ref().map(JobId::as_str))
        .fetch_optional(&mut *connection)
        .await?;
        let orphan: Option<(JobId, i64)> = orphan
            .map(|(id, attempt)| Ok::<_, StoreError>((database::parse_id(&id, "jobs")?, attempt)))
            .transpose()?;
        if let Some((job_id, attempt)) = &orphan
            && *attempt >= max_attempts
        {
            let failure = Failure {
                class: FailureClass::Crashed,
                code: "worker_crashed".into(),
                message: format!(
                    "the worker died {attempt} times in the same stage; look at its log, then retry the job"
                ),
            };
            fail(connection, job_id, &failure, now).await?;
            continue;
        }
        let next = match orphan {
            Some((job_id, _)) => Some(job_id),
            None => {
                let id: Option<String> = sqlx::query_scalar(
                    "SELECT id FROM jobs
                     WHERE state = 'queued' AND not_before <= ?1 AND (?2 IS NULL OR id = ?2)
                     ORDER BY priority DESC, id LIMIT 1",
                )
                .bind(now)
                .bind(only.as_ref().map(JobId::as_str))
                .fetch_optional(&mut *connection)
                .await?;
                id.map(|id| database::parse_id(&id, "jobs")).transpose()?
            }
        };
        let Some(job_id) = next else { return Ok(None) };
        let state = move_job(connection, &job_id, JobEvent::Claimed, now).await?;
        calls::abandon(connection, &job_id, now).await?;
        let row = sqlx::query(
            "UPDATE jobs SET owner = ?1, epoch = epoch + 1, attempt = attempt + 1, lease_until = ?2,
                             started_at = COALESCE(started_at, ?3)
             WHERE id = ?4
             RETURNING tenant_id, scene_id, epoch, attempt, from_stage, salt,
                       (SELECT request FROM scenes WHERE scenes.id = jobs.scene_id) AS request",
        )
        .bind(&owner)
        .bind(now + milliseconds(lease))
        .bind(now)
        .bind(job_id.as_str())
        .fetch_one(&mut *connection)
        .await?;
        let attempt: i64 = row.try_get("attempt")?;
        let epoch: i64 = row.try_get("epoch")?;
        let started = json!({ "attempt": attempt, "epoch": epoch });
        events::append(connection, &job_id, now, "job_started", &started).await?;
        let request: String = row.try_get("request")?;
        return Ok(Some(Claim {
            lease: Lease { job_id, owner, epoch },
            tenant_id: database::id(&row, "jobs", "tenant_id")?,
            scene_id: database::id(&row, "jobs", "scene_id")?,
            request: serde_json::from_str(&request)
                .map_err(|error| StoreError::Corrupt { table: "scenes", reason: error.to_string() })?,
            attempt,
            state,
            salt: Option::zip(row.try_get("from_stage")?, row.try_get("salt")?),
        }));
    }
}

async fn renew(
    connection: &mut SqliteConnection,
    leases: Vec<Lease>,
    duration: Duration,
) -> Result<Vec<(Lease, Option<JobState>)>, StoreError> {
    let now = database::now_ms(connection).await?;
    let mut answers = Vec::with_capacity(leases.len());
    for lease in leases {
        let state: Option<String> = sqlx::query_scalar(
            "UPDATE jobs SET lease_until = ? WHERE id = ? AND owner = ? AND epoch = ?
             AND state IN ('running', 'cancelling') RETURNING state",
        )
        .bind(now + milliseconds(duration))
        .bind(lease.job_id.as_str())
        .bind(&lease.owner)
        .bind(lease.epoch)
        .fetch_optional(&mut *connection)
        .await?;
        answers.push((lease, state.as_deref().and_then(JobState::parse)));
    }
    Ok(answers)
}

async fn finish(
    connection: &mut SqliteConnection,
    lease: Lease,
    outcome: AttemptOutcome,
) -> Result<JobState, StoreError> {
    let now = database::now_ms(connection).await?;
    guard(connection, &lease).await?;
    let job_id = &lease.job_id;
    match outcome {
        AttemptOutcome::Built(built) => {
            let state = move_job(connection, job_id, JobEvent::Succeeded, now).await?;
            if state == JobState::Succeeded {
                artifacts::record_built(connection, job_id, &built, now).await?;
            }
            Ok(state)
        }
        AttemptOutcome::Failed(failure) => fail(connection, job_id, &failure, now).await,
        AttemptOutcome::Retry { failure, delay, charged, max_attempts } => {
            let attempt: i64 = sqlx::query_scalar("SELECT attempt FROM jobs WHERE id = ?")
                .bind(job_id.as_str())
                .fetch_one(&mut *connection)
                .await?;
            if charged && attempt >= i64::from(max_attempts) {
                return fail(connection, job_id, &failure, now).await;
            }
            let state = move_job(connection, job_id, JobEvent::RetryScheduled, now).await?;
            if state == JobState::Queued {
                sqlx::query("UPDATE jobs SET not_before = ?, attempt = MAX(attempt - ?, 0) WHERE id = ?")
                    .bind(now + milliseconds(delay))
                    .bind(i64::from(!charged))
                    .bind(job_id.as_str())
                    .execute(&mut *connection)
                    .await?;
                let data = json!({ "failure": failure, "delay_ms": milliseconds(delay) });
                events::append(connection, job_id, now, "job_retrying", &data).await?;
            }
            Ok(state)
        }
        AttemptOutcome::Released => {
            let state = move_job(connection, job_id, JobEvent::Released, now).await?;
            if state == JobState::Queued {
                sqlx::query("UPDATE jobs SET attempt = MAX(attempt - 1, 0) WHERE id = ?")
                    .bind(job_id.as_str())
                    .execute(&mut *connection)
                    .await?;
                events::append(connection, job_id, now, "job_released", &json!({})).await?;
            }
            Ok(state)
        }
        AttemptOutcome::Stopped => move_job(connection, job_id, JobEvent::Stopped, now).await,
    }
}

async fn fail(
    connection: &mut SqliteConnection,
    job_id: &JobId,
    failure: &Failure,
    now_ms: i64,
) -> Result<JobState, StoreError> {
    let state = move_job(connection, job_id, JobEvent::Failed, now_ms).await?;
    if state == JobState::Failed {
        sqlx::query("UPDATE jobs SET failure_class = ?, failure_code = ?, failure_message = ? WHERE id = ?")
            .bind(failure.class.as_str())
            .bind(&failure.code)
            .bind(&failure.message)
            .bind(job_id.as_str())
            .execute(&mut *connection)
            .await?;
        scene_failed(connection, job_id, &failure.code, &failure.message, now_ms).await?;
        events::append(connection, job_id, now_ms, "job_failed", &json!(failure)).await?;
    }
    Ok(state)
}

async fn cancel(
    connection: &mut SqliteConnection,
    tenant_id: TenantId,
    job_id: JobId,
) -> Result<CancelOutcome, StoreError> {
    let now = database::now_ms(connection).await?;
    let state: Option<String> = sqlx::query_scalar("SELECT state FROM jobs WHERE id = ? AND tenant_id = ?")
        .bind(job_id.as_str())
        .bind(tenant_id.as_str())
        .fetch_optional(&mut *connection)
        .await?;
    let Some(state) = state.as_deref().and_then(JobState::parse) else {
        return Ok(CancelOutcome::NotFound);
    };
    if state.after(JobEvent::CancelRequested).is_err() {
        return Ok(CancelOutcome::TooLate(state));
    }
    Ok(CancelOutcome::Accepted(move_job(connection, &job_id, JobEvent::CancelRequested, now).await?))
}

/// Applies an event to a job inside the caller's transaction, with its side effects: leaving `running` releases the
/// lease, a final state sets the end time, a cancellation updates the scene.
pub(super) async fn move_job(
    connection: &mut SqliteConnection,
    job_id: &JobId,
    event: JobEvent,
    now_ms: i64,
) -> Result<JobState, StoreError> {
    let text: String = sqlx::query_scalar("SELECT state FROM jobs WHERE id = ?")
        .bind(job_id.as_str())
        .fetch_one(&mut *connection)
        .await?;
    let corrupt = |reason: String| StoreError::Corrupt { table: "jobs", reason };
    let before = JobState::parse(&text).ok_or_else(|| corrupt(format!("state {text}")))?;
    let after = before.after(event).map_err(|error| corrupt(error.to_string()))?;
    let holds_lease = matches!(after, JobState::Running | JobState::Cancelling);
    sqlx::query(
        "UPDATE jobs SET state = ?1,
                         owner = CASE WHEN ?2 THEN owner END,
                         lease_until = CASE WHEN ?2 THEN lease_until END,
                         finished_at = CASE WHEN ?3 THEN COALESCE(finished_at, ?4) END
         WHERE id = ?5",
    )
    .bind(after.as_str())
    .bind(holds_lease)
    .bind(after.is_final())
    .bind(now_ms)
    .bind(job_id.as_str())
    .execute(&mut *connection)
    .await?;
    if !holds_lease {
        calls::abandon(connection, job_id, now_ms).await?;
    }
    if after != before {
        match after {
            JobState::Cancelling => {
                events::append(connection, job_id, now_ms, "job_cancelling", &json!({})).await?;
            }
            JobState::Cancelled => {
                let message = "the job was cancelled; retry it to go on where it stopped";
                scene_failed(connection, job_id, "cancelled", message, now_ms).await?;
                events::append(connection, job_id, now_ms, "job_cancelled", &json!({})).await?;
            }
            _ => {}
        }
    }
    Ok(after)
}

/// Fails with [`StoreError::LeaseLost`] unless the lease is still valid.
pub(super) async fn guard(connection: &mut SqliteConnection, lease: &Lease) -> Result<(), StoreError> {
    let held: Option<i64> = sqlx::query_scalar(
        "SELECT 1 FROM jobs WHERE id = ? AND owner = ? AND epoch = ? AND state IN ('running', 'cancelling')",
    )
    .bind(lease.job_id.as_str())
    .bind(&lease.owner)
    .bind(lease.epoch)
    .fetch_optional(connection)
    .await?;
    held.map(|_| ()).ok_or_else(|| StoreError::LeaseLost { job_id: lease.job_id.clone() })
}

/// Marks the scene of a job as failed, unless it has been deleted.
async fn scene_failed(
    connection: &mut SqliteConnection,
    job_id: &JobId,
    code: &str,
    message: &str,
    now_ms: i64,
) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE scenes SET state = 'failed', failure_code = ?, failure_message = ?, updated_at = ?
         WHERE id = (SELECT scene_id FROM jobs WHERE id = ?) AND state = 'pending'",
    )
    .bind(code)
    .bind(message)
    .bind(now_ms)
    .bind(job_id.as_str())
    .execute(connection)
    .await?;
    Ok(())
}

fn milliseconds(duration: Duration) -> i64 {
    i64::try_from(duration.as_millis()).unwrap_or(i64::MAX / 4)
}
