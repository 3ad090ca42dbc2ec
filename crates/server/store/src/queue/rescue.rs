//! Treatment of jobs whose lease has run out, or whose deadline has passed while they waited.
//!
//! Whom a death is blamed on stands in [`crate::deaths`]; a job that its process died over too often fails with the
//! code `worker_crashed` and a diagnosis.

use serde_json::{Value, json};
use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::move_job;
use super::outcome::fail;
use crate::database::Dialect;
use crate::deaths::Deaths;
use crate::lifecycle::{Failure, FailureClass, JobEvent, JobState};
use crate::{StoreError, database, events};
use scene::JobId;

/// Maximum number of jobs of each sort in one transaction.
const BATCH: i64 = 16;

/// Returns jobs with expired leases to the queue, and fails waiting jobs whose deadline has passed. Returns the number
/// of jobs whose state changed.
pub(super) async fn rescue(
    connection: &mut AnyConnection,
    max_deaths: i64,
    only: Option<&JobId>,
    now_ms: i64,
) -> Result<u64, StoreError> {
    let lock = Dialect::of(connection).lock_free_rows();
    let only = only.map(|id| id.as_str().to_owned());
    let query = format!(
        "SELECT id FROM jobs
         WHERE state IN ('running', 'cancelling') AND lease_until <= $1 AND id = COALESCE($2, id)
         ORDER BY lease_until, id LIMIT $3 {lock}"
    );
    let orphans: Vec<String> = sqlx::query_scalar(AssertSqlSafe(query))
        .bind(now_ms)
        .bind(only.as_deref())
        .bind(BATCH)
        .fetch_all(&mut *connection)
        .await?;
    let mut rescued = 0;
    for id in orphans {
        requeue(connection, &database::parse_id(&id, "jobs")?, max_deaths, now_ms).await?;
        rescued += 1;
    }
    let query = format!(
        "SELECT id FROM jobs
         WHERE state = 'queued' AND deadline_at <= $1 AND id = COALESCE($2, id)
         ORDER BY deadline_at, id LIMIT $3 {lock}"
    );
    let late: Vec<String> = sqlx::query_scalar(AssertSqlSafe(query))
        .bind(now_ms)
        .bind(only.as_deref())
        .bind(BATCH)
        .fetch_all(&mut *connection)
        .await?;
    for id in late {
        let job_id = database::parse_id(&id, "jobs")?;
        let failure = Failure::deadline_passed();
        fail(connection, &job_id, JobEvent::DeadlinePassed, &failure, None, now_ms).await?;
        count_failed(&failure);
        rescued += 1;
    }
    Ok(rescued)
}

/// Returns a job whose lease has run out to the queue, or ends it. The job is read as it is now: the rescue of other
/// work of its owner may have marked it.
async fn requeue(
    connection: &mut AnyConnection,
    job_id: &JobId,
    max_deaths: i64,
    now_ms: i64,
) -> Result<(), StoreError> {
    let row = sqlx::query("SELECT owner, was_beside, shared_deaths, lone_deaths FROM jobs WHERE id = $1")
        .bind(job_id.as_str())
        .fetch_one(&mut *connection)
        .await?;
    let owner: Option<String> = row.try_get("owner")?;
    let owner = owner.unwrap_or_default();
    let deaths = Deaths::count(connection, Deaths::of(&row)?, &owner, job_id).await?;
    let Deaths { shared, lone, alone } = deaths;
    let mut diagnosis = json!({ "alone": alone, "shared_deaths": shared, "lone_deaths": lone });
    diagnosis["stages"] = stages_in_progress(connection, job_id).await?;
    sqlx::query(
        "UPDATE jobs SET shared_deaths = $1, lone_deaths = $2, attempt = CASE WHEN attempt > 0 THEN attempt - 1 ELSE 0 END
         WHERE id = $3",
    )
    .bind(shared)
    .bind(lone)
    .bind(job_id.as_str())
    .execute(&mut *connection)
    .await?;
    if deaths.are_too_many(max_deaths) {
        let failure = worker_crashed(lone, &diagnosis["stages"]);
        diagnosis["events"] = last_events(connection, job_id).await?;
        fail(connection, job_id, JobEvent::Failed, &failure, Some(diagnosis), now_ms).await?;
        count_failed(&failure);
        return Ok(());
    }
    if move_job(connection, job_id, JobEvent::Orphaned, now_ms).await? != JobState::Queued {
        return Ok(());
    }
    let delay_ms = deaths.delay_ms();
    sqlx::query("UPDATE jobs SET not_before = $1 WHERE id = $2")
        .bind(now_ms + delay_ms)
        .bind(job_id.as_str())
        .execute(&mut *connection)
        .await?;
    diagnosis["delay_ms"] = json!(delay_ms);
    events::append(connection, job_id, now_ms, "job_orphaned", &diagnosis).await
}

/// Counts a job that no worker ended. A transaction that is repeated counts it again.
fn count_failed(failure: &Failure) {
    metrics::counter!("tabletopgen_jobs_finished_total", "outcome" => "failed", "class" => failure.class.as_str())
        .increment(1);
}

fn worker_crashed(lone_deaths: i64, stages: &Value) -> Failure {
    let names: Vec<&str> =
        stages.as_array().into_iter().flatten().filter_map(|stage| stage["stage"].as_str()).collect();
    let place = if names.is_empty() { "between two stages".to_owned() } else { names.join(", ") };
    Failure {
        class: FailureClass::Crashed,
        code: "worker_crashed".into(),
        message: format!(
            "the worker died {lone_deaths} times while it ran this job alone, last in {place}; the job's last event has \
             the details. Read the worker's log and check its memory, then retry the job"
        ),
    }
}

/// Stages that the job had begun and not finished.
async fn stages_in_progress(connection: &mut AnyConnection, job_id: &JobId) -> Result<Value, StoreError> {
    let rows = sqlx::query(
        "SELECT stage, instance, runs FROM stages
         WHERE job_id = $1 AND state = 'running' ORDER BY started_at, stage, instance LIMIT 16",
    )
    .bind(job_id.as_str())
    .fetch_all(connection)
    .await?;
    let stages = rows.iter().map(|row| {
        Ok(json!({
            "stage": row.try_get::<String, _>("stage")?,
            "instance": row.try_get::<String, _>("instance")?,
            "runs": row.try_get::<i64, _>("runs")?,
        }))
    });
    Ok(Value::Array(stages.collect::<Result<_, StoreError>>()?))
}

/// The job's last events, newest first.
async fn last_events(connection: &mut AnyConnection, job_id: &JobId) -> Result<Value, StoreError> {
    let rows = sqlx::query("SELECT seq, kind FROM events WHERE job_id = $1 ORDER BY seq DESC LIMIT 8")
        .bind(job_id.as_str())
        .fetch_all(connection)
        .await?;
    let events = rows.iter().map(|row| {
        Ok(json!({
            "seq": row.try_get::<i64, _>("seq")?,
            "kind": row.try_get::<String, _>("kind")?,
        }))
    });
    Ok(Value::Array(events.collect::<Result<_, StoreError>>()?))
}
