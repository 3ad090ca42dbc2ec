//! The end of an attempt: the job's next state, and what is recorded about it.

use serde_json::{Value, json};
use sqlx::AnyConnection;

use super::{AttemptOutcome, Lease, guard, milliseconds, move_job};
use crate::{StoreError, artifacts, database, events};
use scene::JobId;
use scene::job::{Failure, JobEvent, JobState};

/// Ends an attempt at a job.
pub(super) async fn finish(
    connection: &mut AnyConnection,
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
        AttemptOutcome::Failed(failure) => {
            fail(connection, job_id, JobEvent::Failed, &failure, None, now).await
        }
        AttemptOutcome::Retry { failure, delay, charged, max_attempts } => {
            let attempt: i64 = sqlx::query_scalar("SELECT attempt FROM jobs WHERE id = $1")
                .bind(job_id.as_str())
                .fetch_one(&mut *connection)
                .await?;
            if charged && attempt >= i64::from(max_attempts) {
                return fail(connection, job_id, JobEvent::Failed, &failure, None, now).await;
            }
            let state = move_job(connection, job_id, JobEvent::RetryScheduled, now).await?;
            if state == JobState::Queued {
                sqlx::query(
                    "UPDATE jobs SET not_before = $1,
                                     attempt = CASE WHEN attempt > $2 THEN attempt - $2 ELSE 0 END
                     WHERE id = $3",
                )
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
                sqlx::query(
                    "UPDATE jobs SET attempt = CASE WHEN attempt > 0 THEN attempt - 1 ELSE 0 END WHERE id = $1",
                )
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

/// Fails a job and its scene; the event about it carries the diagnosis, if there is one.
pub(super) async fn fail(
    connection: &mut AnyConnection,
    job_id: &JobId,
    event: JobEvent,
    failure: &Failure,
    diagnosis: Option<Value>,
    now_ms: i64,
) -> Result<JobState, StoreError> {
    let state = move_job(connection, job_id, event, now_ms).await?;
    if state == JobState::Failed {
        sqlx::query(
            "UPDATE jobs SET failure_class = $1, failure_code = $2, failure_message = $3 WHERE id = $4",
        )
        .bind(failure.class.as_str())
        .bind(&failure.code)
        .bind(&failure.message)
        .bind(job_id.as_str())
        .execute(&mut *connection)
        .await?;
        scene_failed(connection, job_id, &failure.code, &failure.message, now_ms).await?;
        let mut data = json!(failure);
        if let Some(diagnosis) = diagnosis {
            data["diagnosis"] = diagnosis;
        }
        events::append(connection, job_id, now_ms, "job_failed", &data).await?;
    }
    Ok(state)
}

/// Marks the scene of a job as failed, unless it has been deleted.
pub(super) async fn scene_failed(
    connection: &mut AnyConnection,
    job_id: &JobId,
    code: &str,
    message: &str,
    now_ms: i64,
) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE scenes SET state = 'failed', failure_code = $1, failure_message = $2, updated_at = $3
         WHERE id = (SELECT scene_id FROM jobs WHERE id = $4) AND state = 'pending'",
    )
    .bind(code)
    .bind(message)
    .bind(now_ms)
    .bind(job_id.as_str())
    .execute(connection)
    .await?;
    Ok(())
}
