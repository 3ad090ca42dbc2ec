//! The jobs of a recording: which attempts are enqueued, and when the dataset is assembled. Every function is a part of
//! a transaction that holds the recording's row.

use serde_json::Map;
use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::events::{append, ends_with};
use super::{RecordingEventKind, RecordingRow, RecordingState, recording_of, stored};
use crate::database::Dialect;
use crate::lifecycle::JobKind;
use crate::queue::{JobSubject, NewJob, QueueColumns};
use crate::{StoreError, database};
use scene::{JobId, RecordingId};

/// Attempts that wait or are made at once for each episode that is missing: more would mostly be made in vain.
const OPEN_PER_MISSING: u64 = 4;
/// Attempts of one recording that wait or are made at once.
const MAX_OPEN: u64 = 64;

/// The recording of a job, locked.
pub(super) struct Locked {
    pub(super) recording: RecordingRow,
    /// Of an attempt.
    pub(super) number: Option<u64>,
}

/// Locks the recording that a job works on.
pub(super) async fn lock(connection: &mut AnyConnection, job_id: &JobId) -> Result<Locked, StoreError> {
    let part = part_of(connection, job_id).await?;
    Ok(Locked { recording: lock_recording(connection, &part.id).await?, number: part.number })
}

/// The part of a recording that a job is.
struct Part {
    id: RecordingId,
    kind: JobKind,
    number: Option<u64>,
}

async fn part_of(connection: &mut AnyConnection, job_id: &JobId) -> Result<Part, StoreError> {
    let row = sqlx::query("SELECT kind, recording_id, attempt_number FROM jobs WHERE id = $1")
        .bind(job_id.as_str())
        .fetch_one(connection)
        .await?;
    let kind: String = row.try_get("kind")?;
    let corrupt = || StoreError::Corrupt { table: "jobs", reason: format!("kind {kind}") };
    let number: Option<i64> = row.try_get("attempt_number")?;
    Ok(Part {
        id: database::id(&row, "jobs", "recording_id")?,
        kind: JobKind::parse(&kind).ok_or_else(corrupt)?,
        number: number.and_then(|number| u64::try_from(number).ok()),
    })
}

/// Locks a recording.
pub(super) async fn lock_recording(
    connection: &mut AnyConnection,
    id: &RecordingId,
) -> Result<RecordingRow, StoreError> {
    let lock = Dialect::of(connection).lock();
    read(connection, id, lock).await
}

async fn read(
    connection: &mut AnyConnection,
    id: &RecordingId,
    lock: &str,
) -> Result<RecordingRow, StoreError> {
    let found = find(connection, id, lock).await?;
    found.ok_or_else(|| super::corrupt(format!("{id} is missing, and a job records it")))
}

async fn find(
    connection: &mut AnyConnection,
    id: &RecordingId,
    lock: &str,
) -> Result<Option<RecordingRow>, StoreError> {
    let query = format!("SELECT * FROM recordings WHERE id = $1 {lock}");
    let row = sqlx::query(AssertSqlSafe(query)).bind(id.as_str()).fetch_optional(connection).await?;
    row.as_ref().map(recording_of).transpose()
}

/// Enqueues attempts while episodes are missing, and assembling when nothing else is.
pub(super) async fn enqueue_missing(
    connection: &mut AnyConnection,
    id: &RecordingId,
    now_ms: i64,
) -> Result<(), StoreError> {
    let mut recording = lock_recording(connection, id).await?;
    let missing = recording.wanted.saturating_sub(recording.successes);
    if missing == 0 {
        recording.begun -= drop_surplus(connection, id).await?;
    }
    let first = recording.begun;
    let limit = (OPEN_PER_MISSING * missing).min(MAX_OPEN);
    while recording.begun < recording.max_attempts && recording.begun - recording.made < limit {
        enqueue_attempt(connection, &recording, recording.begun, now_ms).await?;
        recording.begun += 1;
    }
    if first != recording.begun || missing == 0 {
        sqlx::query("UPDATE recordings SET begun = $1 WHERE id = $2")
            .bind(stored(recording.begun))
            .bind(id.as_str())
            .execute(&mut *connection)
            .await?;
    }
    if recording.begun > recording.made {
        return Ok(());
    }
    let assembly = new_job(&recording, JobKind::AssembleRecording, None);
    assembly.insert(connection, now_ms).await?;
    Ok(())
}

/// Enqueues an attempt. Attempts have the place of their recording in the queue, and come in the order of their
/// numbers.
pub(super) async fn enqueue_attempt(
    connection: &mut AnyConnection,
    recording: &RecordingRow,
    number: u64,
    now_ms: i64,
) -> Result<(), StoreError> {
    new_job(recording, JobKind::RecordAttempt, Some(number)).insert(connection, now_ms).await?;
    Ok(())
}

fn new_job(recording: &RecordingRow, kind: JobKind, number: Option<u64>) -> NewJob<'_> {
    let columns = QueueColumns::of_new(None, &recording.request, recording.created_at_ms);
    NewJob::new(&recording.tenant_id, kind, JobSubject::Recording(&recording.id, number), columns)
}

/// Drops the attempts that no worker has begun and that no later attempt follows. Returns their number.
async fn drop_surplus(connection: &mut AnyConnection, id: &RecordingId) -> Result<u64, StoreError> {
    const SURPLUS: &str = "SELECT id FROM jobs
        WHERE recording_id = $1 AND kind = 'record_attempt' AND state = 'queued' AND epoch = 0
          AND attempt_number > COALESCE((SELECT MAX(attempt_number) FROM jobs
                                         WHERE recording_id = $1 AND (epoch > 0 OR state <> 'queued')), -1)
          AND attempt_number > COALESCE((SELECT MAX(number) FROM recording_attempts WHERE recording_id = $1), -1)";
    let surplus: Vec<String> =
        sqlx::query_scalar(SURPLUS).bind(id.as_str()).fetch_all(&mut *connection).await?;
    for job_id in &surplus {
        drop_job(connection, job_id).await?;
    }
    Ok(surplus.len() as u64)
}

/// Drops the jobs of a recording but one, with their events: a worker that holds one loses its lease.
pub(super) async fn drop_jobs(
    connection: &mut AnyConnection,
    id: &RecordingId,
    but: Option<&JobId>,
) -> Result<(), StoreError> {
    let jobs: Vec<String> = sqlx::query_scalar("SELECT id FROM jobs WHERE recording_id = $1 AND id <> $2")
        .bind(id.as_str())
        .bind(but.map_or("", JobId::as_str))
        .fetch_all(&mut *connection)
        .await?;
    for job_id in &jobs {
        drop_job(connection, job_id).await?;
    }
    Ok(())
}

async fn drop_job(connection: &mut AnyConnection, job_id: &str) -> Result<(), StoreError> {
    for query in ["DELETE FROM events WHERE job_id = $1", "DELETE FROM jobs WHERE id = $1"] {
        sqlx::query(query).bind(job_id).execute(&mut *connection).await?;
    }
    Ok(())
}

/// The recording of a claimed job, with the event of its first attempt and that of assembling.
pub(crate) async fn begun(
    connection: &mut AnyConnection,
    job_id: &JobId,
    now_ms: i64,
) -> Result<(RecordingRow, Option<u64>), StoreError> {
    let Part { id, kind, number } = part_of(connection, job_id).await?;
    let recording = read(connection, &id, "").await?;
    if recording.state != RecordingState::Queued && kind == JobKind::RecordAttempt {
        return Ok((recording, number));
    }
    // Claims of many attempts at once do not wait for each other: one of them begins the recording.
    let free = Dialect::of(connection).lock_free_rows();
    let locked = match kind {
        JobKind::RecordAttempt => find(connection, &id, free).await?,
        _ => Some(lock_recording(connection, &id).await?),
    };
    let Some(recording) = locked else { return Ok((recording, number)) };
    ensure_running(connection, &recording, now_ms).await?;
    // Which process assembles is of no interest: one event tells of it, however often it is begun.
    if kind == JobKind::AssembleRecording
        && !ends_with(connection, &recording.id, RecordingEventKind::Assembling).await?
    {
        append(connection, &recording.id, now_ms, RecordingEventKind::Assembling, Map::new()).await?;
    }
    Ok((lock_recording(connection, &recording.id).await?, number))
}

/// Notes that a recording has begun, with its event.
pub(super) async fn ensure_running(
    connection: &mut AnyConnection,
    recording: &RecordingRow,
    now_ms: i64,
) -> Result<(), StoreError> {
    if recording.state != RecordingState::Queued {
        return Ok(());
    }
    sqlx::query("UPDATE recordings SET state = 'running', started_at = $1 WHERE id = $2")
        .bind(now_ms)
        .bind(recording.id.as_str())
        .execute(&mut *connection)
        .await?;
    append(connection, &recording.id, now_ms, RecordingEventKind::Running, Map::new()).await
}
