//! The end of an attempt: the job's next state, and what is recorded about it.

use serde_json::{Value, json};
use sqlx::{AnyConnection, Row};

use super::{AttemptOutcome, Lease, guard, milliseconds, move_job};
use crate::lifecycle::{Failure, JobEvent, JobState};
use crate::{StoreError, artifacts, database, datasets, events, executions, recordings, webhooks};
use scene::JobId;

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
                let data = json!({ "verdict": built.verdict(), "metrics": built.metrics });
                append_success(connection, job_id, &data, now).await?;
            }
            Ok(state)
        }
        AttemptOutcome::Frozen(version) => {
            let state = move_job(connection, job_id, JobEvent::Succeeded, now).await?;
            if state == JobState::Succeeded {
                datasets::record_version(connection, job_id, &version, now).await?;
                append_success(connection, job_id, &json!({}), now).await?;
            }
            Ok(state)
        }
        AttemptOutcome::Verified(found) => {
            let state = move_job(connection, job_id, JobEvent::Succeeded, now).await?;
            if state == JobState::Succeeded {
                datasets::record_verification(connection, job_id, &found).await?;
                append_success(connection, job_id, &json!({}), now).await?;
            }
            Ok(state)
        }
        AttemptOutcome::Executed(answer) => {
            let state = move_job(connection, job_id, JobEvent::Succeeded, now).await?;
            if state == JobState::Succeeded {
                executions::record_answer(connection, job_id, &answer).await?;
                append_success(connection, job_id, &json!({}), now).await?;
            }
            Ok(state)
        }
        AttemptOutcome::Attempted(made) => {
            let state = move_job(connection, job_id, JobEvent::Succeeded, now).await?;
            if state == JobState::Succeeded {
                recordings::keep(connection, job_id, &made, now).await?;
                append_success(connection, job_id, &json!({}), now).await?;
            }
            Ok(state)
        }
        AttemptOutcome::Assembled(summary) => {
            let state = move_job(connection, job_id, JobEvent::Succeeded, now).await?;
            if state == JobState::Succeeded {
                recordings::finish(connection, job_id, &summary, now).await?;
                append_success(connection, job_id, &json!({}), now).await?;
            }
            Ok(state)
        }
        AttemptOutcome::EpisodeLost { number, failure, max_losses } => {
            let row = sqlx::query("SELECT recording_id FROM jobs WHERE id = $1")
                .bind(job_id.as_str())
                .fetch_one(&mut *connection)
                .await?;
            let recording_id = database::id(&row, "jobs", "recording_id")?;
            if !recordings::make_again(connection, &recording_id, number, max_losses, now).await? {
                return fail(connection, job_id, JobEvent::Failed, &failure, None, now).await;
            }
            let state = move_job(connection, job_id, JobEvent::Failed, now).await?;
            record_failure(connection, job_id, &failure).await?;
            events::append(connection, job_id, now, "job_failed", &json!(failure)).await?;
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

/// The event about the success of a job, and what webhooks are sent. It comes after what locks a recording: in
/// PostgreSQL, a second change of a job's row in a transaction shares the lock of the recording's row, and of several
/// that share it none gets it alone.
async fn append_success(
    connection: &mut AnyConnection,
    job_id: &JobId,
    data: &Value,
    now_ms: i64,
) -> Result<(), StoreError> {
    events::append(connection, job_id, now_ms, "job_succeeded", data).await?;
    webhooks::job_ended(connection, job_id, now_ms).await
}

/// Fails a job and what it works on; the event about it carries the diagnosis, if there is one.
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
        // First, as it locks a recording; see `append_success`.
        subject_failed(connection, job_id, &failure.code, &failure.message, now_ms).await?;
        record_failure(connection, job_id, failure).await?;
        let mut data = json!(failure);
        if let Some(diagnosis) = diagnosis {
            data["diagnosis"] = diagnosis;
        }
        events::append(connection, job_id, now_ms, "job_failed", &data).await?;
        webhooks::job_ended(connection, job_id, now_ms).await?;
    }
    Ok(state)
}

async fn record_failure(
    connection: &mut AnyConnection,
    job_id: &JobId,
    failure: &Failure,
) -> Result<(), StoreError> {
    sqlx::query("UPDATE jobs SET failure_class = $1, failure_code = $2, failure_message = $3 WHERE id = $4")
        .bind(failure.class.as_str())
        .bind(&failure.code)
        .bind(&failure.message)
        .bind(job_id.as_str())
        .execute(connection)
        .await?;
    Ok(())
}

/// Marks the scene, the dataset or the recording of a job as failed. A deleted scene stays as it is.
pub(super) async fn subject_failed(
    connection: &mut AnyConnection,
    job_id: &JobId,
    code: &str,
    message: &str,
    now_ms: i64,
) -> Result<(), StoreError> {
    let row = sqlx::query("SELECT scene_id, dataset_id, recording_id FROM jobs WHERE id = $1")
        .bind(job_id.as_str())
        .fetch_one(&mut *connection)
        .await?;
    if row.try_get::<Option<String>, _>("recording_id")?.is_some() {
        return recordings::fail(connection, job_id, code, message, now_ms).await;
    }
    if let Some(id) = database::optional_id(&row, "jobs", "dataset_id")? {
        return datasets::fail(connection, &id, code, message, now_ms).await;
    }
    sqlx::query(
        "UPDATE scenes SET state = 'failed', failure_code = $1, failure_message = $2, updated_at = $3
         WHERE id = $4 AND state = 'pending'",
    )
    .bind(code)
    .bind(message)
    .bind(now_ms)
    .bind(row.try_get::<Option<String>, _>("scene_id")?)
    .execute(connection)
    .await?;
    Ok(())
}

/// The job has made something that stays: the current attempt is the first one since, and deaths count anew.
pub(crate) async fn note_progress(connection: &mut AnyConnection, job_id: &JobId) -> Result<(), StoreError> {
    sqlx::query("UPDATE jobs SET attempt = 1, shared_deaths = 0, lone_deaths = 0 WHERE id = $1")
        .bind(job_id.as_str())
        .execute(connection)
        .await?;
    Ok(())
}
