//! The durable queue: claim, renew, finish, release, cancel.
//!
//! A claim raises the job's epoch. Everything a worker writes afterwards carries the guard `owner = me
//! AND epoch = mine`, so one that was paused past its lease changes no row. Lease times come from the
//! database's clock. States move only through [`JobState::after`].

use std::time::Duration;

use serde_json::{Value, json};
use sqlx::{Row, SqliteConnection};

use super::artifacts::BuiltRows;
use super::{Store, StoreError, artifacts, calls, database, events};
use scene::job::{Failure, FailureClass, JobEvent, JobState};

/// The right to write about a job: valid while `owner` and `epoch` are those of its row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lease {
    pub job_id: String,
    pub owner: String,
    pub epoch: i64,
}

/// A job a worker has just taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    pub lease: Lease,
    pub tenant_id: String,
    pub scene_id: String,
    /// The scene's request, as JSON.
    pub request: Value,
    /// Claims since the last new checkpoint, this one included.
    pub attempt: i64,
    /// `cancelling` when only the letting go is left to do.
    pub state: JobState,
    /// From this stage on, keys are salted with the second text.
    pub salt: Option<(String, String)>,
}

/// How a worker's turn with a job ended.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// The scene is built (and certified, one way or the other).
    Built(Box<BuiltRows>),
    Failed(Failure),
    /// Back to the queue for at least `delay`; an uncharged attempt does not count. Charged for the
    /// `max_attempts`-th time since the last new checkpoint, it is a failure instead.
    Retry {
        failure: Failure,
        delay: Duration,
        charged: bool,
        max_attempts: u32,
    },
    /// The worker shuts down: back to the queue, uncharged.
    Released,
    /// A cancellation was obeyed.
    Stopped,
}

/// What came of asking to cancel a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CancelRequest {
    /// The job's state now.
    Accepted(JobState),
    /// It had ended already.
    TooLate(JobState),
    NotFound,
}

impl Store {
    /// Takes the next job: one whose lease ran out, else the queue's first by priority and age. A job
    /// whose worker died `max_attempts` times without reaching a new checkpoint is failed instead. With
    /// `only`, no other job is looked at.
    pub async fn claim(
        &self,
        owner: &str,
        lease: Duration,
        max_attempts: u32,
        only: Option<&str>,
    ) -> Result<Option<Claim>, StoreError> {
        let (owner, only) = (owner.to_owned(), only.map(str::to_owned));
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

    /// Extends leases; the answer has each job's state, or `None` where the lease is lost.
    pub async fn renew(
        &self,
        leases: Vec<Lease>,
        lease: Duration,
    ) -> Result<Vec<(Lease, Option<JobState>)>, StoreError> {
        self.writer.write("renew leases", move |connection| Box::pin(renew(connection, leases, lease))).await
    }

    /// Ends a worker's turn. The answer is the job's state, which may be `cancelled` for work that
    /// succeeded after somebody cancelled it.
    pub async fn finish(&self, lease: &Lease, outcome: Outcome) -> Result<JobState, StoreError> {
        let lease = lease.clone();
        let state = self
            .writer
            .write("finish a job", move |connection| Box::pin(finish(connection, lease, outcome)))
            .await?;
        self.announce();
        Ok(state)
    }

    /// Asks that a job stops.
    pub async fn cancel(&self, tenant_id: &str, job_id: &str) -> Result<CancelRequest, StoreError> {
        let (tenant_id, job_id) = (tenant_id.to_owned(), job_id.to_owned());
        let answer = self
            .writer
            .write("cancel a job", move |connection| Box::pin(cancel(connection, tenant_id, job_id)))
            .await?;
        self.announce();
        self.cancelled.send_modify(|tick| *tick += 1);
        Ok(answer)
    }

    /// Ends at once the leases of every owner but `owner`. Right only because one process holds the
    /// data directory: the others are dead. Returns how many there were.
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
    only: Option<String>,
) -> Result<Option<Claim>, StoreError> {
    let now = database::now_ms(connection).await?;
    loop {
        let orphan: Option<(String, i64)> = sqlx::query_as(
            "SELECT id, attempt FROM jobs
             WHERE state IN ('running', 'cancelling') AND lease_until <= ?1 AND (?2 IS NULL OR id = ?2)
             ORDER BY lease_until LIMIT 1",
        )
        .bind(now)
        .bind(&only)
        .fetch_optional(&mut *connection)
        .await?;
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
                sqlx::query_scalar(
                    "SELECT id FROM jobs
                     WHERE state = 'queued' AND not_before <= ?1 AND (?2 IS NULL OR id = ?2)
                     ORDER BY priority DESC, id LIMIT 1",
                )
                .bind(now)
                .bind(&only)
                .fetch_optional(&mut *connection)
                .await?
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
        .bind(&job_id)
        .fetch_one(&mut *connection)
        .await?;
        let attempt: i64 = row.try_get("attempt")?;
        let epoch: i64 = row.try_get("epoch")?;
        let started = json!({ "attempt": attempt, "epoch": epoch });
        events::append(connection, &job_id, now, "job_started", &started).await?;
        let request: String = row.try_get("request")?;
        return Ok(Some(Claim {
            lease: Lease { job_id, owner, epoch },
            tenant_id: row.try_get("tenant_id")?,
            scene_id: row.try_get("scene_id")?,
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
        .bind(&lease.job_id)
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
    outcome: Outcome,
) -> Result<JobState, StoreError> {
    let now = database::now_ms(connection).await?;
    guard(connection, &lease).await?;
    let job_id = lease.job_id.as_str();
    match outcome {
        Outcome::Built(built) => {
            let state = move_job(connection, job_id, JobEvent::Succeeded, now).await?;
            if state == JobState::Succeeded {
                artifacts::record_built(connection, job_id, &built, now).await?;
            }
            Ok(state)
        }
        Outcome::Failed(failure) => fail(connection, job_id, &failure, now).await,
        Outcome::Retry { failure, delay, charged, max_attempts } => {
            let attempt: i64 = sqlx::query_scalar("SELECT attempt FROM jobs WHERE id = ?")
                .bind(job_id)
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
                    .bind(job_id)
                    .execute(&mut *connection)
                    .await?;
                let data = json!({ "failure": failure, "delay_ms": milliseconds(delay) });
                events::append(connection, job_id, now, "job_retrying", &data).await?;
            }
            Ok(state)
        }
        Outcome::Released => {
            let state = move_job(connection, job_id, JobEvent::Released, now).await?;
            if state == JobState::Queued {
                sqlx::query("UPDATE jobs SET attempt = MAX(attempt - 1, 0) WHERE id = ?")
                    .bind(job_id)
                    .execute(&mut *connection)
                    .await?;
                events::append(connection, job_id, now, "job_released", &json!({})).await?;
            }
            Ok(state)
        }
        Outcome::Stopped => move_job(connection, job_id, JobEvent::Stopped, now).await,
    }
}

async fn fail(
    connection: &mut SqliteConnection,
    job_id: &str,
    failure: &Failure,
    now_ms: i64,
) -> Result<JobState, StoreError> {
    let state = move_job(connection, job_id, JobEvent::Failed, now_ms).await?;
    if state == JobState::Failed {
        sqlx::query("UPDATE jobs SET failure_class = ?, failure_code = ?, failure_message = ? WHERE id = ?")
            .bind(failure.class.as_str())
            .bind(&failure.code)
            .bind(&failure.message)
            .bind(job_id)
            .execute(&mut *connection)
            .await?;
        scene_failed(connection, job_id, &failure.code, &failure.message, now_ms).await?;
        events::append(connection, job_id, now_ms, "job_failed", &json!(failure)).await?;
    }
    Ok(state)
}

async fn cancel(
    connection: &mut SqliteConnection,
    tenant_id: String,
    job_id: String,
) -> Result<CancelRequest, StoreError> {
    let now = database::now_ms(connection).await?;
    let state: Option<String> = sqlx::query_scalar("SELECT state FROM jobs WHERE id = ? AND tenant_id = ?")
        .bind(&job_id)
        .bind(&tenant_id)
        .fetch_optional(&mut *connection)
        .await?;
    let Some(state) = state.as_deref().and_then(JobState::parse) else {
        return Ok(CancelRequest::NotFound);
    };
    if state.after(JobEvent::CancelRequested).is_err() {
        return Ok(CancelRequest::TooLate(state));
    }
    Ok(CancelRequest::Accepted(move_job(connection, &job_id, JobEvent::CancelRequested, now).await?))
}

/// Moves a job's state by the table, inside the caller's transaction, with what every such move brings:
/// leaving `running` gives up the lease, ending stamps the time, cancelling tells the scene.
pub(super) async fn move_job(
    connection: &mut SqliteConnection,
    job_id: &str,
    event: JobEvent,
    now_ms: i64,
) -> Result<JobState, StoreError> {
    let text: String = sqlx::query_scalar("SELECT state FROM jobs WHERE id = ?")
        .bind(job_id)
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
    .bind(job_id)
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

/// Fails unless the lease is still the job's.
pub(super) async fn guard(connection: &mut SqliteConnection, lease: &Lease) -> Result<(), StoreError> {
    let held: Option<i64> = sqlx::query_scalar(
        "SELECT 1 FROM jobs WHERE id = ? AND owner = ? AND epoch = ? AND state IN ('running', 'cancelling')",
    )
    .bind(&lease.job_id)
    .bind(&lease.owner)
    .bind(lease.epoch)
    .fetch_optional(connection)
    .await?;
    held.map(|_| ()).ok_or_else(|| StoreError::LeaseLost { job_id: lease.job_id.clone() })
}

/// The scene of a job that will not finish, unless it was deleted meanwhile.
async fn scene_failed(
    connection: &mut SqliteConnection,
    job_id: &str,
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
    .bind(job_id)
    .execute(connection)
    .await?;
    Ok(())
}

fn milliseconds(duration: Duration) -> i64 {
    i64::try_from(duration.as_millis()).unwrap_or(i64::MAX / 4)
}
