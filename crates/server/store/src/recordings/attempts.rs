//! Results of attempts. They are the checkpoints of a recording: each is kept as soon as it is made.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};
use sqlx::{AnyConnection, Row};

use super::events::append;
use super::schedule::{self, Locked};
use super::{RecordingEventKind, RecordingRow, count, stored};
use crate::boxed;
use crate::queue::guard;
use crate::{Digest, Lease, Store, StoreError, database};
use scene::{JobId, RecordingId};

/// The outcome of an attempt that succeeded.
pub(super) const SUCCESS: &str = "success";
/// Maximum number of times that all attempts are dropped because a process with another identity takes over; more is a
/// dispute.
const MAX_RESTARTS: i64 = 3;

/// An attempt to be made.
#[derive(Clone, Debug, PartialEq)]
pub struct AttemptWork {
    pub recording: RecordingRow,
    /// From 0.
    pub number: u64,
}

/// An attempt that was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MadeAttempt {
    /// `success`, or the reason of the failure.
    pub outcome: String,
    /// Details of the outcome, for people.
    pub detail: String,
    /// The blob of the episode, if there is one.
    pub unit: Option<Digest>,
}

/// An attempt that was made, and its number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeptAttempt {
    pub number: u64,
    pub made: MadeAttempt,
}

impl MadeAttempt {
    pub fn is_success(&self) -> bool {
        self.outcome == SUCCESS
    }

    /// Fields of the event of the attempt.
    fn event_fields(&self, number: u64) -> Map<String, Value> {
        let mut fields = Map::new();
        fields.insert("number".to_owned(), json!(number));
        fields.insert("outcome".to_owned(), json!(self.outcome));
        if !self.is_success() {
            fields.insert("detail".to_owned(), json!(self.detail));
        }
        fields
    }
}

/// Whether a process may make attempts of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begun {
    /// The attempts so far are of the same identity.
    Agreed,
    /// The attempts so far were of another identity, and are made again.
    Restarted,
    /// The identity changed too often: the attempts of different processes will never agree.
    Disputed,
}

impl Store {
    /// Agrees on what attempts of a recording depend on. Attempts of another version or machine could not be parts of
    /// one dataset, so all but the one of this job are made again.
    ///
    /// # Errors
    ///
    /// [`StoreError::LeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn begin_recording(&self, lease: &Lease, identity: &str) -> Result<Begun, StoreError> {
        let (lease, identity) = (lease.clone(), identity.to_owned());
        let begun = self
            .writer
            .write("begin a recording", move |connection| {
                Box::pin(async move { begin(connection, &lease, &identity).await })
            })
            .await?;
        if begun == Begun::Restarted {
            // Other processes hold attempts that are none any more.
            self.announce_cancellation();
        }
        Ok(begun)
    }

    /// The attempts of a recording that were made, by number. The caller checks the tenant.
    #[boxed]
    pub async fn kept_attempts(&self, id: &RecordingId) -> Result<Vec<KeptAttempt>, StoreError> {
        let rows = sqlx::query(
            "SELECT number, outcome, detail, unit FROM recording_attempts
             WHERE recording_id = $1 AND outcome IS NOT NULL ORDER BY number",
        )
        .bind(id.as_str())
        .fetch_all(&self.readers)
        .await?;
        let kept = rows.iter().map(|row| {
            let unit: Option<String> = row.try_get("unit")?;
            let made = MadeAttempt {
                outcome: row.try_get("outcome")?,
                detail: row.try_get::<Option<String>, _>("detail")?.unwrap_or_default(),
                unit: unit.map(|digest| Digest::parse(&digest)).transpose()?,
            };
            Ok(KeptAttempt { number: count(row, "number")?, made })
        });
        kept.collect()
    }

    /// Number of attempts of a recording by outcome, so far. The caller checks the tenant.
    #[boxed]
    pub async fn attempt_outcomes(&self, id: &RecordingId) -> Result<BTreeMap<String, u64>, StoreError> {
        let rows = sqlx::query(OUTCOMES).bind(id.as_str()).fetch_all(&self.readers).await?;
        rows.iter().map(|row| Ok((row.try_get("outcome")?, count(row, "attempts")?))).collect()
    }
}

const OUTCOMES: &str = "SELECT outcome, COUNT(*) AS attempts FROM recording_attempts
                        WHERE recording_id = $1 AND outcome IS NOT NULL GROUP BY outcome";

async fn begin(connection: &mut AnyConnection, lease: &Lease, identity: &str) -> Result<Begun, StoreError> {
    guard(connection, lease).await?;
    let Locked { recording, number, .. } = schedule::lock(connection, &lease.job_id).await?;
    match recording.identity.as_deref() {
        Some(known) if known == identity => return Ok(Begun::Agreed),
        Some(_) if recording.restarts >= MAX_RESTARTS => return Ok(Begun::Disputed),
        _ => {}
    }
    sqlx::query("UPDATE recordings SET identity = $1 WHERE id = $2")
        .bind(identity)
        .bind(recording.id.as_str())
        .execute(&mut *connection)
        .await?;
    if recording.identity.is_none() {
        return Ok(Begun::Agreed);
    }
    let now = database::now_ms(connection).await?;
    schedule::drop_jobs(connection, &recording.id, Some(&lease.job_id)).await?;
    drop_attempts(connection, &recording.id).await?;
    sqlx::query("UPDATE recordings SET made = 0, successes = 0, restarts = restarts + 1 WHERE id = $1")
        .bind(recording.id.as_str())
        .execute(&mut *connection)
        .await?;
    for other in (0..recording.begun).filter(|other| Some(*other) != number) {
        schedule::enqueue_attempt(connection, &recording, other, now).await?;
    }
    append(connection, &recording.id, now, RecordingEventKind::Restarted, Map::new()).await?;
    Ok(Begun::Restarted)
}

/// Keeps the attempt of a job that has succeeded, and enqueues what is missing.
pub(crate) async fn keep(
    connection: &mut AnyConnection,
    job_id: &JobId,
    made: &MadeAttempt,
    now_ms: i64,
) -> Result<(), StoreError> {
    let Locked { recording, number, .. } = schedule::lock(connection, job_id).await?;
    let number = number.ok_or_else(|| super::corrupt(format!("job {job_id} has no number")))?;
    schedule::ensure_running(connection, &recording, now_ms).await?;
    sqlx::query(
        "INSERT INTO recording_attempts (recording_id, number, outcome, detail, unit, made_at)
         VALUES ($1, $2, $3, $4, $5, $6)
         ON CONFLICT (recording_id, number) DO UPDATE
         SET outcome = excluded.outcome, detail = excluded.detail, unit = excluded.unit, made_at = excluded.made_at",
    )
    .bind(recording.id.as_str())
    .bind(stored(number))
    .bind(&made.outcome)
    .bind(&made.detail)
    .bind(made.unit.as_ref().map(Digest::to_string))
    .bind(now_ms)
    .execute(&mut *connection)
    .await?;
    sqlx::query("UPDATE recordings SET made = made + 1, successes = successes + $1 WHERE id = $2")
        .bind(i64::from(made.is_success()))
        .bind(recording.id.as_str())
        .execute(&mut *connection)
        .await?;
    append(connection, &recording.id, now_ms, RecordingEventKind::Attempt, made.event_fields(number)).await?;
    schedule::enqueue_missing(connection, &recording.id, now_ms).await
}

/// Has an attempt made again whose episode is lost or damaged; assembling follows again. Whether its episode was lost
/// less than `max_losses` times; otherwise nothing changes.
pub(crate) async fn make_again(
    connection: &mut AnyConnection,
    id: &RecordingId,
    number: u64,
    max_losses: u32,
    now_ms: i64,
) -> Result<bool, StoreError> {
    let recording = schedule::lock_recording(connection, id).await?;
    let lost = sqlx::query(
        "SELECT outcome, losses FROM recording_attempts
         WHERE recording_id = $1 AND number = $2 AND outcome IS NOT NULL",
    )
    .bind(id.as_str())
    .bind(stored(number))
    .fetch_optional(&mut *connection)
    .await?;
    let Some(lost) = lost else { return Ok(true) };
    if lost.try_get::<i64, _>("losses")? + 1 >= i64::from(max_losses) {
        return Ok(false);
    }
    sqlx::query(
        "UPDATE recording_attempts
         SET outcome = NULL, detail = NULL, unit = NULL, made_at = NULL, losses = losses + 1
         WHERE recording_id = $1 AND number = $2",
    )
    .bind(id.as_str())
    .bind(stored(number))
    .execute(&mut *connection)
    .await?;
    sqlx::query("UPDATE recordings SET made = made - 1, successes = successes - $1 WHERE id = $2")
        .bind(i64::from(lost.try_get::<String, _>("outcome")? == SUCCESS))
        .bind(id.as_str())
        .execute(&mut *connection)
        .await?;
    let fields = Map::from_iter([("number".to_owned(), json!(number))]);
    append(connection, id, now_ms, RecordingEventKind::AttemptLost, fields).await?;
    schedule::enqueue_attempt(connection, &recording, number, now_ms).await?;
    Ok(true)
}

/// Drops the attempts of a recording, so that a sweep takes their blobs; how often they ended how.
pub(super) async fn drop_attempts(
    connection: &mut AnyConnection,
    id: &RecordingId,
) -> Result<BTreeMap<String, u64>, StoreError> {
    let rows = sqlx::query(OUTCOMES).bind(id.as_str()).fetch_all(&mut *connection).await?;
    let outcomes = rows.iter().map(|row| Ok((row.try_get("outcome")?, count(row, "attempts")?))).collect();
    sqlx::query("DELETE FROM recording_attempts WHERE recording_id = $1")
        .bind(id.as_str())
        .execute(connection)
        .await?;
    outcomes
}
