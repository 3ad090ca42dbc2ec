//! What becomes of a job whose lease has run out, or whose deadline has passed while it waited.
//!
//! A process dies because of one of its jobs, or because of something else: a signal, a power cut, the kernel. The
//! store cannot tell, so a job is blamed only for what no other job can have caused:
//!
//! - If the process held several jobs, none is blamed: each counts a shared death.
//! - If it held one job, that job counts a lone death.
//! - Both counts start again at the job's next new checkpoint, and neither counts as an attempt.
//! - After two deaths a job runs alone in its process (see `turns`), so that a third death is certain to be its own.
//! - After `max_deaths` lone deaths the job fails with the code `worker_crashed` and a diagnosis.
//!
//! After its first death a job returns to the queue at once. After each further lone death it waits: 1 s, 2 s, 4 s,
//! up to a minute. So a job that is hit by a series of kills outlasts it, and a job that kills processes does so
//! rarely.

use serde_json::{Value, json};
use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::move_job;
use super::outcome::fail;
use crate::database::Dialect;
use crate::{StoreError, database, events};
use scene::JobId;
use scene::job::{Failure, FailureClass, JobEvent, JobState};

/// Maximum number of jobs of each sort in one transaction.
const BATCH: i64 = 16;

const FIRST_DELAY_MS: i64 = 1_000;
const MAX_DELAY_MS: i64 = 60_000;

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
        let orphan = orphan(connection, database::parse_id(&id, "jobs")?).await?;
        requeue(connection, orphan, max_deaths, now_ms).await?;
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

/// A job whose lease has run out.
struct Orphan {
    job_id: JobId,
    owner: String,
    /// Another job of the owner was rescued before this one.
    was_beside: bool,
    shared_deaths: i64,
    lone_deaths: i64,
}

/// The job as it is now: the rescue of another job of its owner may have marked it.
async fn orphan(connection: &mut AnyConnection, job_id: JobId) -> Result<Orphan, StoreError> {
    let row = sqlx::query("SELECT owner, was_beside, shared_deaths, lone_deaths FROM jobs WHERE id = $1")
        .bind(job_id.as_str())
        .fetch_one(connection)
        .await?;
    let owner: Option<String> = row.try_get("owner")?;
    Ok(Orphan {
        job_id,
        owner: owner.unwrap_or_default(),
        was_beside: row.try_get::<i64, _>("was_beside")? != 0,
        shared_deaths: row.try_get("shared_deaths")?,
        lone_deaths: row.try_get("lone_deaths")?,
    })
}

async fn requeue(
    connection: &mut AnyConnection,
    orphan: Orphan,
    max_deaths: i64,
    now_ms: i64,
) -> Result<(), StoreError> {
    let job_id = &orphan.job_id;
    // Jobs of the owner whose leases run out a little later must know that they were not alone.
    let others = sqlx::query(
        "UPDATE jobs SET was_beside = 1
         WHERE owner = $1 AND id <> $2 AND state IN ('running', 'cancelling')",
    )
    .bind(&orphan.owner)
    .bind(job_id.as_str())
    .execute(&mut *connection)
    .await?
    .rows_affected();
    let alone = others == 0 && !orphan.was_beside;
    let lone_deaths = orphan.lone_deaths + i64::from(alone);
    let shared_deaths = orphan.shared_deaths + i64::from(!alone);
    let mut diagnosis = json!({ "alone": alone, "shared_deaths": shared_deaths, "lone_deaths": lone_deaths });
    diagnosis["stages"] = stages_in_progress(connection, job_id).await?;
    sqlx::query(
        "UPDATE jobs SET shared_deaths = $1, lone_deaths = $2, attempt = CASE WHEN attempt > 0 THEN attempt - 1 ELSE 0 END
         WHERE id = $3",
    )
    .bind(shared_deaths)
    .bind(lone_deaths)
    .bind(job_id.as_str())
    .execute(&mut *connection)
    .await?;
    if alone && lone_deaths >= max_deaths {
        let failure = worker_crashed(lone_deaths, &diagnosis["stages"]);
        diagnosis["events"] = last_events(connection, job_id).await?;
        fail(connection, job_id, JobEvent::Failed, &failure, Some(diagnosis), now_ms).await?;
        count_failed(&failure);
        return Ok(());
    }
    if move_job(connection, job_id, JobEvent::Orphaned, now_ms).await? != JobState::Queued {
        return Ok(());
    }
    let delay_ms = if alone { delay_ms(lone_deaths) } else { 0 };
    sqlx::query("UPDATE jobs SET not_before = $1 WHERE id = $2")
        .bind(now_ms + delay_ms)
        .bind(job_id.as_str())
        .execute(&mut *connection)
        .await?;
    diagnosis["delay_ms"] = json!(delay_ms);
    events::append(connection, job_id, now_ms, "job_orphaned", &diagnosis).await
}

/// Delay after the n-th lone death: none, then 1 s, 2 s, 4 s, ... 60 s.
fn delay_ms(lone_deaths: i64) -> i64 {
    match u32::try_from(lone_deaths - 2) {
        Ok(doublings) => FIRST_DELAY_MS.saturating_mul(1 << doublings.min(16)).min(MAX_DELAY_MS),
        Err(_) => 0,
    }
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
             the details. Look at the worker's log and memory, then retry the job"
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_death_costs_no_time_and_later_ones_double() {
        assert_eq!([1, 2, 3, 4, 8, 9, 99].map(delay_ms), [0, 1_000, 2_000, 4_000, 60_000, 60_000, 60_000]);
    }
}
