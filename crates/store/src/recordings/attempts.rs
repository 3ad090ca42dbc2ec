//! What came of attempts. They are the checkpoints of a recording: each is kept as soon as it is made.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};
use sqlx::{AnyConnection, Row};

use super::claim::guard_attempt;
use super::events::append;
use super::{AttemptLease, RecordingEventKind, count, stored};
use crate::boxed;
use crate::{Digest, Store, StoreError, database};
use scene::RecordingId;

/// The outcome of an attempt that succeeded.
pub(super) const SUCCESS: &str = "success";
/// How often all attempts are dropped because a process with another identity takes over; more is a dispute.
const MAX_RESTARTS: i64 = 3;

/// An attempt that was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MadeAttempt {
    /// `success`, or the reason of the failure.
    pub outcome: String,
    /// What happened, in words.
    pub detail: String,
    /// The blob of the episode, if there is one.
    pub unit: Option<Digest>,
}

/// An attempt that was made, and its number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeptAttempt {
    pub number: u64,
    pub made: MadeAttempt,
    /// How often it was begun, without those that were given back and those whose process died.
    pub tries: u64,
}

impl MadeAttempt {
    pub fn is_success(&self) -> bool {
        self.outcome == SUCCESS
    }

    /// What the event of the attempt tells of it.
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
    /// They were of another; they are dropped, also the one that is claimed.
    Restarted,
    /// They were of another too often: the recording failed.
    Failed,
}

impl Store {
    /// Agrees on what attempts of a recording depend on. Attempts of another version or machine could not be parts of
    /// one dataset, so those that are there are dropped.
    ///
    /// # Errors
    ///
    /// [`StoreError::RecordingLeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn begin_recording(&self, lease: &AttemptLease, identity: &str) -> Result<Begun, StoreError> {
        let (lease, identity) = (lease.clone(), identity.to_owned());
        let begun = self
            .writer
            .write("begin a recording", move |connection| {
                Box::pin(async move { begin(connection, &lease, &identity).await })
            })
            .await?;
        if begun != Begun::Agreed {
            self.announce();
        }
        Ok(begun)
    }

    /// Keeps an attempt whose blob was put.
    ///
    /// # Errors
    ///
    /// [`StoreError::RecordingLeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn keep_attempt(&self, lease: &AttemptLease, made: MadeAttempt) -> Result<(), StoreError> {
        let lease = lease.clone();
        self.writer
            .write("keep an attempt", move |connection| {
                Box::pin(async move {
                    guard_attempt(connection, &lease).await?;
                    let now = database::now_ms(connection).await?;
                    sqlx::query(
                        "UPDATE recording_attempts SET outcome = $1, detail = $2, unit = $3, made_at = $4
                         WHERE recording_id = $5 AND number = $6",
                    )
                    .bind(&made.outcome)
                    .bind(&made.detail)
                    .bind(made.unit.as_ref().map(Digest::to_string))
                    .bind(now)
                    .bind(lease.id.as_str())
                    .bind(stored(lease.number))
                    .execute(&mut *connection)
                    .await?;
                    sqlx::query(
                        "UPDATE recordings SET made = made + 1, successes = successes + $1, shared_deaths = 0, lone_deaths = 0
                         WHERE id = $2",
                    )
                    .bind(i64::from(made.is_success()))
                    .bind(lease.id.as_str())
                    .execute(&mut *connection)
                    .await?;
                    let fields = made.event_fields(lease.number);
                    append(connection, &lease.id, now, RecordingEventKind::Attempt, fields).await
                })
            })
            .await?;
        self.announce();
        Ok(())
    }

    /// Ends a recording that cannot be made.
    ///
    /// # Errors
    ///
    /// [`StoreError::RecordingLeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn fail_recording(
        &self,
        lease: &AttemptLease,
        code: &str,
        message: &str,
    ) -> Result<(), StoreError> {
        let (lease, code, message) = (lease.clone(), code.to_owned(), message.to_owned());
        self.writer
            .write("fail a recording", move |connection| {
                Box::pin(async move {
                    guard_attempt(connection, &lease).await?;
                    fail(connection, &lease.id, &code, &message).await
                })
            })
            .await?;
        self.announce();
        Ok(())
    }

    /// The attempts of a recording that were made, by number. The caller checks the tenant.
    #[boxed]
    pub async fn kept_attempts(&self, id: &RecordingId) -> Result<Vec<KeptAttempt>, StoreError> {
        let rows = sqlx::query(
            "SELECT number, outcome, detail, unit, tries FROM recording_attempts
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
            Ok(KeptAttempt { number: count(row, "number")?, made, tries: count(row, "tries")? })
        });
        kept.collect()
    }

    /// How often attempts of a recording ended how so far. The caller checks the tenant.
    #[boxed]
    pub async fn attempt_outcomes(&self, id: &RecordingId) -> Result<BTreeMap<String, u64>, StoreError> {
        let rows = sqlx::query(OUTCOMES).bind(id.as_str()).fetch_all(&self.readers).await?;
        rows.iter().map(|row| Ok((row.try_get("outcome")?, count(row, "attempts")?))).collect()
    }
}

const OUTCOMES: &str = "SELECT outcome, COUNT(*) AS attempts FROM recording_attempts
                        WHERE recording_id = $1 AND outcome IS NOT NULL GROUP BY outcome";

async fn begin(
    connection: &mut AnyConnection,
    lease: &AttemptLease,
    identity: &str,
) -> Result<Begun, StoreError> {
    let row = guard_attempt(connection, lease).await?;
    let known: Option<String> = row.try_get("identity")?;
    let restarts: i64 = row.try_get("restarts")?;
    let restarted = match known.as_deref() {
        Some(known) if known == identity => return Ok(Begun::Agreed),
        None => false,
        Some(_) if restarts >= MAX_RESTARTS => {
            let message = "processes of different versions, or on machines of different types, work on recordings at the \
                           same time; update all of them, then order it again";
            fail(connection, &lease.id, "versions_differ", message).await?;
            return Ok(Begun::Failed);
        }
        Some(_) => true,
    };
    if restarted {
        sqlx::query("DELETE FROM recording_attempts WHERE recording_id = $1")
            .bind(lease.id.as_str())
            .execute(&mut *connection)
            .await?;
        sqlx::query(
            "UPDATE recordings SET begun = 0, made = 0, successes = 0, tries = 0, restarts = restarts + 1 WHERE id = $1",
        )
        .bind(lease.id.as_str())
        .execute(&mut *connection)
        .await?;
        let now = database::now_ms(connection).await?;
        append(connection, &lease.id, now, RecordingEventKind::Restarted, Map::new()).await?;
    }
    sqlx::query("UPDATE recordings SET identity = $1 WHERE id = $2")
        .bind(identity)
        .bind(lease.id.as_str())
        .execute(connection)
        .await?;
    Ok(if restarted { Begun::Restarted } else { Begun::Agreed })
}

/// Ends a recording without a dataset.
pub(super) async fn fail(
    connection: &mut AnyConnection,
    id: &RecordingId,
    code: &str,
    message: &str,
) -> Result<(), StoreError> {
    let outcomes = drop_attempts(connection, id).await?;
    let now = database::now_ms(connection).await?;
    sqlx::query(
        "UPDATE recordings SET state = 'failed', failure_code = $1, failure_message = $2, summary = $3, finished_at = $4,
                               owner = NULL, token = NULL, lease_until = 0
         WHERE id = $5",
    )
    .bind(code)
    .bind(message)
    .bind(json!({ "attempts": outcomes }).to_string())
    .bind(now)
    .bind(id.as_str())
    .execute(&mut *connection)
    .await?;
    super::dataset::drop_dataset(connection, id).await?;
    let failure = json!({ "code": code, "message": message });
    let fields = Map::from_iter([("failure".to_owned(), failure)]);
    append(connection, id, now, RecordingEventKind::Failed, fields).await
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
