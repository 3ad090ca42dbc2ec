//! The durable job queue: claim, renew, finish, release, cancel.
//!
//! A claim increments the job's epoch (a fencing token). Every later write of the worker is guarded by owner and epoch,
//! so a worker that was paused past its lease changes no row. Lease times use the database's clock. State changes go
//! through [`JobState::after`] only.
//!
//! Whose turn it is stands in `turns`, what becomes of a dead worker's jobs in `rescue`.

mod schedule;
mod new_job;
mod claimed;
mod turns;
mod rescue;
mod outcome;
mod switch;
mod overview;

use std::time::Duration;

use serde_json::{Value, json};
use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::artifacts::BuiltScene;
use super::database::Dialect;
use super::datasets::FrozenVersion;
use super::executions::ExecutionAnswer;
use super::recordings::MadeAttempt;
use super::{Store, StoreError, calls, database, datasets, events, recordings, stage_claims, webhooks};
use crate::boxed;
use crate::lifecycle::{Failure, JobEvent, JobState};
use scene::{DatasetId, JobId, TenantId};

pub use claimed::{Claim, ClaimedWork, SceneWork};
pub(crate) use new_job::{JobSubject, NewJob};
pub(crate) use outcome::note_progress;
pub use overview::{ActiveJob, QueueOverview};
pub(crate) use schedule::QueueColumns;
pub use schedule::{Schedule, Settings};
pub use switch::{BackgroundWork, Pause, QueueStatus};
use switch::{set_paused, status};
pub use turns::Scope;

/// The right to write rows of a job: valid while `owner` and `epoch` equal those of its row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lease {
    pub job_id: JobId,
    pub owner: String,
    pub epoch: i64,
}

/// Result of a job attempt.
#[derive(Clone, Debug)]
pub enum AttemptOutcome {
    /// The scene is built and certified (pass or quarantine).
    Built(Box<BuiltScene>),
    /// The version of a dataset is frozen.
    Frozen(FrozenVersion),
    /// The findings of the verification of a version, as JSON.
    Verified(Value),
    /// A task was executed, done or failed.
    Executed(ExecutionAnswer),
    /// An attempt of a recording is made, with success or without.
    Attempted(MadeAttempt),
    /// The dataset of a recording is recorded; with a summary as JSON.
    Assembled(Value),
    /// The dataset cannot be assembled, as the episode of an attempt is lost: the attempt is made again, unless that
    /// was its `max_losses`-th loss.
    EpisodeLost {
        number: u64,
        failure: Failure,
        max_losses: u32,
    },
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
    /// Claims the job whose turn it is, after jobs with expired leases have returned to the queue. A job that was
    /// alone in its process when it died, `max_deaths` times without progress, fails instead. A scope of one
    /// job restricts both to that.
    #[boxed]
    pub async fn claim(
        &self,
        owner: &str,
        lease: Duration,
        max_deaths: u32,
        scope: &Scope,
    ) -> Result<Option<Claim>, StoreError> {
        let (owner, scope) = (owner.to_owned(), scope.clone());
        let usual_running = self.admission.settings().running_jobs;
        let claim = self
            .writer
            .write("claim a job", move |connection| {
                let max_deaths = i64::from(max_deaths);
                Box::pin(claimed::claim(connection, owner, lease, max_deaths, scope, usual_running))
            })
            .await?;
        if claim.is_some() {
            self.admission.made_room();
            self.announce();
        }
        Ok(claim)
    }

    /// Whether a claim may succeed: a cheap question for workers that are woken by changes of other jobs.
    #[boxed]
    pub async fn has_work(&self, scope: &Scope) -> Result<bool, StoreError> {
        let now = self.readers.now_ms().await?;
        let query = format!(
            "SELECT CAST(1 AS BIGINT) FROM jobs WHERE state = 'queued' AND not_before <= $1 AND {} LIMIT 1",
            scope.kinds()
        );
        let found: Option<i64> =
            sqlx::query_scalar(AssertSqlSafe(query)).bind(now).fetch_optional(&self.readers).await?;
        Ok(found.is_some())
    }

    /// Returns jobs with expired leases to the queue, and fails waiting jobs whose deadline has passed. Returns their
    /// number.
    #[boxed]
    pub async fn rescue(&self, max_deaths: u32) -> Result<u64, StoreError> {
        let now = self.readers.now_ms().await?;
        let found: i64 = sqlx::query_scalar(
            "SELECT (SELECT COUNT(*) FROM jobs WHERE state IN ('running', 'cancelling') AND lease_until <= $1)
                  + (SELECT COUNT(*) FROM jobs WHERE state = 'queued' AND deadline_at <= $1)",
        )
        .bind(now)
        .fetch_one(&self.readers)
        .await?;
        if found == 0 {
            return Ok(0);
        }
        let rescued = self
            .writer
            .write("rescue jobs", move |connection| {
                Box::pin(async move {
                    let now = database::now_ms(connection).await?;
                    rescue::rescue(connection, i64::from(max_deaths), None, now).await
                })
            })
            .await?;
        self.announce();
        Ok(rescued)
    }

    /// Pauses or resumes claiming, in all processes that work on the database.
    #[boxed]
    pub async fn set_paused(&self, paused: bool, reason: &str) -> Result<(), StoreError> {
        let reason = reason.to_owned();
        self.writer
            .write("pause or resume claiming", move |connection| {
                Box::pin(async move { set_paused(connection, paused, &reason).await })
            })
            .await?;
        self.announce();
        Ok(())
    }

    /// The state of the queue.
    #[boxed]
    pub async fn queue_status(&self) -> Result<QueueStatus, StoreError> {
        let read = async { status(&mut *self.readers.acquire().await?).await };
        self.readers.within_limit(read).await
    }

    /// Extends leases. Returns the state of each job, or `None` if its lease is lost.
    #[boxed]
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
    #[boxed]
    pub async fn finish(&self, lease: &Lease, outcome: AttemptOutcome) -> Result<JobState, StoreError> {
        let lease = lease.clone();
        let state = self
            .writer
            .write("finish a job", move |connection| Box::pin(outcome::finish(connection, lease, outcome)))
            .await?;
        self.announce();
        Ok(state)
    }

    /// Requests the cancellation of a job.
    #[boxed]
    pub async fn cancel(&self, tenant_id: &TenantId, job_id: &JobId) -> Result<CancelOutcome, StoreError> {
        let (tenant_id, job_id) = (tenant_id.clone(), job_id.clone());
        let answer = self
            .writer
            .write("cancel a job", move |connection| Box::pin(cancel(connection, tenant_id, job_id)))
            .await?;
        self.announce_cancellation();
        Ok(answer)
    }

    /// Expires the leases of all other owners of a SQLite file and returns their number. This is correct because one
    /// process locks the data directory, so all other owners are dead. In a shared database other owners may be alive;
    /// nothing changes there, and the leases of dead workers end by their time.
    #[boxed]
    pub async fn expire_leases_of_others(&self, owner: &str) -> Result<u64, StoreError> {
        if self.is_shared {
            return Ok(0);
        }
        let owner = owner.to_owned();
        self.writer
            .write("expire the leases of dead workers", move |connection| {
                Box::pin(async move {
                    let done = sqlx::query(
                        "UPDATE jobs SET lease_until = 0
                         WHERE state IN ('running', 'cancelling') AND (owner IS NULL OR owner <> $1)",
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

async fn renew(
    connection: &mut AnyConnection,
    leases: Vec<Lease>,
    duration: Duration,
) -> Result<Vec<(Lease, Option<JobState>)>, StoreError> {
    let now = database::now_ms(connection).await?;
    let mut answers = Vec::with_capacity(leases.len());
    for lease in leases {
        let state: Option<String> = sqlx::query_scalar(
            "UPDATE jobs SET lease_until = $1 WHERE id = $2 AND owner = $3 AND epoch = $4
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

pub(super) async fn cancel(
    connection: &mut AnyConnection,
    tenant_id: TenantId,
    job_id: JobId,
) -> Result<CancelOutcome, StoreError> {
    let now = database::now_ms(connection).await?;
    let lock = Dialect::of(connection).lock();
    let query = AssertSqlSafe(format!("SELECT state FROM jobs WHERE id = $1 AND tenant_id = $2 {lock}"));
    let state: Option<String> = sqlx::query_scalar(query)
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

/// Requests the cancellation of every active job with this id in a column such as `scene_id`.
pub(super) async fn cancel_jobs_of(
    connection: &mut AnyConnection,
    column: &'static str,
    id: &str,
    now_ms: i64,
) -> Result<(), StoreError> {
    let query = format!(
        "SELECT id FROM jobs WHERE {column} = $1 AND state IN ('queued', 'running', 'cancelling') ORDER BY id"
    );
    let jobs: Vec<String> =
        sqlx::query_scalar(AssertSqlSafe(query)).bind(id).fetch_all(&mut *connection).await?;
    for job in jobs {
        move_job(connection, &database::parse_id(&job, "jobs")?, JobEvent::CancelRequested, now_ms).await?;
    }
    Ok(())
}

/// Applies an event to a job inside the caller's transaction, with its side effects: leaving `running` releases the
/// lease, a final state sets the end time, a dataset follows its job, a cancellation ends what the job works on.
pub(super) async fn move_job(
    connection: &mut AnyConnection,
    job_id: &JobId,
    event: JobEvent,
    now_ms: i64,
) -> Result<JobState, StoreError> {
    let lock = Dialect::of(connection).lock();
    let query = format!("SELECT state, dataset_id, recording_id FROM jobs WHERE id = $1 {lock}");
    let row = sqlx::query(AssertSqlSafe(query)).bind(job_id.as_str()).fetch_one(&mut *connection).await?;
    let text: String = row.try_get("state")?;
    let dataset_id: Option<DatasetId> = database::optional_id(&row, "jobs", "dataset_id")?;
    let corrupt = |reason: String| StoreError::Corrupt { table: "jobs", reason };
    let before = JobState::parse(&text).ok_or_else(|| corrupt(format!("state {text}")))?;
    let after = before.after(event).map_err(|error| corrupt(error.to_string()))?;
    let holds_lease = matches!(after, JobState::Running | JobState::Cancelling);
    sqlx::query(
        "UPDATE jobs SET state = $1,
                         owner = CASE WHEN $2 THEN owner END,
                         lease_until = CASE WHEN $2 THEN lease_until END,
                         finished_at = CASE WHEN $3 THEN COALESCE(finished_at, $4) END
         WHERE id = $5",
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
        stage_claims::release_all(connection, job_id).await?;
    }
    if let Some(dataset_id) = &dataset_id {
        datasets::follow(connection, dataset_id, after).await?;
    }
    if after != before {
        match after {
            JobState::Cancelling => {
                events::append(connection, job_id, now_ms, "job_cancelling", &json!({})).await?;
            }
            JobState::Cancelled if row.try_get::<Option<String>, _>("recording_id")?.is_some() => {
                recordings::cancel_by_job(connection, job_id, now_ms).await?;
                events::append(connection, job_id, now_ms, "job_cancelled", &json!({})).await?;
            }
            JobState::Cancelled => {
                let message = "the job was cancelled; retry it to go on where it stopped";
                outcome::subject_failed(connection, job_id, "cancelled", message, now_ms).await?;
                events::append(connection, job_id, now_ms, "job_cancelled", &json!({})).await?;
                webhooks::job_ended(connection, job_id, now_ms).await?;
            }
            _ => {}
        }
    }
    Ok(after)
}

/// Fails with [`StoreError::LeaseLost`] unless the lease is still valid; locks the job's row.
pub(super) async fn guard(connection: &mut AnyConnection, lease: &Lease) -> Result<(), StoreError> {
    let lock = Dialect::of(connection).lock();
    let held: Option<i64> = sqlx::query_scalar(AssertSqlSafe(format!(
        "SELECT 1 FROM jobs
         WHERE id = $1 AND owner = $2 AND epoch = $3 AND state IN ('running', 'cancelling') {lock}",
    )))
    .bind(lease.job_id.as_str())
    .bind(&lease.owner)
    .bind(lease.epoch)
    .fetch_optional(connection)
    .await?;
    held.map(|_| ()).ok_or_else(|| StoreError::LeaseLost { job_id: lease.job_id.clone() })
}

fn milliseconds(duration: Duration) -> i64 {
    i64::try_from(duration.as_millis()).unwrap_or(i64::MAX / 4)
}
