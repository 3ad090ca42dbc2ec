//! The right of one process to make an attempt, or to assemble a dataset: claimed, renewed, and checked before every
//! write. What becomes of work of dead processes stands in [`super::rescue`]; an operator's pause holds recordings too.

use std::time::Duration;

use serde_json::Map;
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, AssertSqlSafe, Row};
use uuid::Uuid;

use super::events::{append, ends_with};
use super::rescue::rescue;
use super::{RecordingEventKind, RecordingRow, RecordingState, count, recording_of, stored};
use crate::boxed;
use crate::database::Dialect;
use crate::deaths::IS_SUSPECT;
use crate::{Store, StoreError, database, deaths, queue};
use scene::RecordingId;

/// Attempts that are made at once for each episode that is missing: more would mostly be made in vain.
const OPEN_PER_MISSING: u64 = 4;

/// The right to make an attempt: valid while its row has this token and no outcome.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AttemptLease {
    pub id: RecordingId,
    pub number: u64,
    pub token: String,
}

/// The right to assemble the dataset: valid while the recording's row has this token.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AssemblyLease {
    pub id: RecordingId,
    pub token: String,
}

/// What is to be done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordingWork {
    Attempt(AttemptLease),
    /// No attempt is missing: there is to be a dataset, or a failure for too few successes.
    Assembly(AssemblyLease),
}

/// Claimed work.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingClaim {
    pub recording: RecordingRow,
    pub work: RecordingWork,
    /// How often this attempt, or assembling, was begun, this time included.
    pub tries: i64,
}

impl Store {
    /// Claims work of the oldest recording that has some: an attempt that was given back, the next attempt, or
    /// assembling; after work of dead processes was given back. A recording that was alone in its process when that
    /// died, `max_deaths` times without a finished attempt between, fails instead.
    #[boxed]
    pub async fn claim_recording(
        &self,
        owner: &str,
        lease: Duration,
        max_deaths: u32,
    ) -> Result<Option<RecordingClaim>, StoreError> {
        let waiting: Option<i64> = sqlx::query_scalar(
            "SELECT CAST(1 AS BIGINT) FROM recordings WHERE state IN ('queued', 'running') ORDER BY id LIMIT 1",
        )
        .fetch_optional(&self.readers)
        .await?;
        if waiting.is_none() {
            return Ok(None);
        }
        let (owner, is_shared) = (owner.to_owned(), self.is_shared);
        let (claim, is_change) = self
            .writer
            .write("claim work of a recording", move |connection| {
                Box::pin(async move {
                    let now = database::now_ms(connection).await?;
                    let max_deaths = i64::from(max_deaths);
                    let failed = rescue(connection, &owner, max_deaths, is_shared, now).await?;
                    let claimant = Claimant { owner, until_ms: now + milliseconds(lease), now_ms: now };
                    Ok(match claimant.claim(connection).await? {
                        Claimed::Work(claim) => (Some(*claim), failed > 0),
                        Claimed::Change(claim) => (Some(*claim), true),
                        Claimed::Nothing => (None, failed > 0),
                    })
                })
            })
            .await?;
        // Most claims tell nothing, and would only wake up other processes.
        if is_change {
            self.announce();
        }
        Ok(claim)
    }

    /// Extends the lease of an attempt; `false` if it is lost, as by a cancellation.
    #[boxed]
    pub async fn renew_attempt(&self, lease: &AttemptLease, duration: Duration) -> Result<bool, StoreError> {
        let lease = lease.clone();
        self.writer
            .write("renew the lease of an attempt", move |connection| {
                Box::pin(async move {
                    let now = database::now_ms(connection).await?;
                    let renewed = sqlx::query(
                        "UPDATE recording_attempts SET lease_until = $1
                         WHERE recording_id = $2 AND number = $3 AND token = $4 AND outcome IS NULL",
                    )
                    .bind(now + milliseconds(duration))
                    .bind(lease.id.as_str())
                    .bind(stored(lease.number))
                    .bind(&lease.token)
                    .execute(connection)
                    .await?;
                    Ok(renewed.rows_affected() > 0)
                })
            })
            .await
    }

    /// Gives an attempt back, for another process to make it.
    #[boxed]
    pub async fn release_attempt(&self, lease: &AttemptLease) -> Result<(), StoreError> {
        let lease = lease.clone();
        self.writer
            .write("give an attempt back", move |connection| {
                Box::pin(async move {
                    sqlx::query(
                        "UPDATE recording_attempts
                         SET owner = '', token = '', lease_until = 0, tries = CASE WHEN tries > 0 THEN tries - 1 ELSE 0 END
                         WHERE recording_id = $1 AND number = $2 AND token = $3 AND outcome IS NULL",
                    )
                    .bind(lease.id.as_str())
                    .bind(stored(lease.number))
                    .bind(&lease.token)
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            })
            .await?;
        self.announce();
        Ok(())
    }

    /// Extends the lease of assembling; `false` if it is lost.
    #[boxed]
    pub async fn renew_assembly(
        &self,
        lease: &AssemblyLease,
        duration: Duration,
    ) -> Result<bool, StoreError> {
        let lease = lease.clone();
        self.writer
            .write("renew the lease of assembling", move |connection| {
                Box::pin(async move {
                    let now = database::now_ms(connection).await?;
                    let renewed =
                        sqlx::query("UPDATE recordings SET lease_until = $1 WHERE id = $2 AND token = $3")
                            .bind(now + milliseconds(duration))
                            .bind(lease.id.as_str())
                            .bind(&lease.token)
                            .execute(connection)
                            .await?;
                    Ok(renewed.rows_affected() > 0)
                })
            })
            .await
    }

    /// Gives assembling back, for another process to begin it again.
    #[boxed]
    pub async fn release_assembly(&self, lease: &AssemblyLease) -> Result<(), StoreError> {
        let lease = lease.clone();
        self.writer
            .write("give assembling back", move |connection| {
                Box::pin(async move {
                    sqlx::query(
                        "UPDATE recordings
                         SET owner = NULL, token = NULL, lease_until = 0, tries = CASE WHEN tries > 0 THEN tries - 1 ELSE 0 END
                         WHERE id = $1 AND token = $2",
                    )
                    .bind(lease.id.as_str())
                    .bind(&lease.token)
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            })
            .await?;
        self.announce();
        Ok(())
    }
}

enum Claimed {
    Work(Box<RecordingClaim>),
    /// The same, which an event tells of.
    Change(Box<RecordingClaim>),
    Nothing,
}

struct Claimant {
    owner: String,
    now_ms: i64,
    /// The end of what it claims.
    until_ms: i64,
}

impl Claimant {
    async fn claim(&self, connection: &mut AnyConnection) -> Result<Claimed, StoreError> {
        if queue::is_paused(connection).await? {
            return Ok(Claimed::Nothing);
        }
        let hands = deaths::hands(connection, &self.owner, self.now_ms).await?;
        if hands.are_bound {
            return Ok(Claimed::Nothing);
        }
        if let Some(row) = self.waiting(connection, IS_SUSPECT).await? {
            if hands.are_empty {
                return self.take(connection, &row).await;
            }
            let id: RecordingId = database::id(&row, "recordings", "id")?;
            if deaths::reserve(connection, "recordings", id.as_str(), &self.owner, self.now_ms).await? {
                return Ok(Claimed::Nothing);
            }
        }
        if hands.keep_free {
            return Ok(Claimed::Nothing);
        }
        match self.waiting(connection, "shared_deaths + lone_deaths < 2").await? {
            Some(row) => self.take(connection, &row).await,
            None => Ok(Claimed::Nothing),
        }
    }

    /// The oldest recording that has work to be taken, locked.
    async fn waiting(
        &self,
        connection: &mut AnyConnection,
        condition: &str,
    ) -> Result<Option<AnyRow>, StoreError> {
        let lock = Dialect::of(connection).lock();
        let query = format!(
            "SELECT * FROM recordings
             WHERE state IN ('queued', 'running') AND not_before <= $1 AND {condition}
               AND ((successes < wanted AND begun < max_attempts
                     AND begun - made < {OPEN_PER_MISSING} * (wanted - successes))
                    OR (made = begun AND token IS NULL)
                    OR EXISTS (SELECT 1 FROM recording_attempts AS attempt
                               WHERE attempt.recording_id = recordings.id AND attempt.outcome IS NULL
                                 AND attempt.owner = '' AND attempt.not_before <= $1))
             ORDER BY id LIMIT 1 {lock}"
        );
        Ok(sqlx::query(AssertSqlSafe(query)).bind(self.now_ms).fetch_optional(connection).await?)
    }

    /// Work of a recording, if there is some.
    async fn take(&self, connection: &mut AnyConnection, row: &AnyRow) -> Result<Claimed, StoreError> {
        let recording = recording_of(row)?;
        if let Some(claimed) = self.given_back(connection, &recording).await? {
            return Ok(claimed);
        }
        let begun = count(row, "begun")?;
        let open = begun.saturating_sub(recording.made);
        let missing = recording.wanted.saturating_sub(recording.successes);
        if missing > 0 && begun < recording.max_attempts {
            return match open < OPEN_PER_MISSING * missing {
                true => self.next(connection, recording, begun).await,
                false => Ok(Claimed::Nothing),
            };
        }
        // What was read first may have changed since, until the lock was there.
        let is_assembled = row.try_get::<Option<String>, _>("token")?.is_some();
        if open > 0 || is_assembled {
            return Ok(Claimed::Nothing);
        }
        self.assembly(connection, recording).await
    }

    /// An attempt that was given back.
    async fn given_back(
        &self,
        connection: &mut AnyConnection,
        recording: &RecordingRow,
    ) -> Result<Option<Claimed>, StoreError> {
        let row = sqlx::query(
            "SELECT number, tries FROM recording_attempts
             WHERE recording_id = $1 AND outcome IS NULL AND owner = '' AND not_before <= $2 ORDER BY number LIMIT 1",
        )
        .bind(recording.id.as_str())
        .bind(self.now_ms)
        .fetch_optional(&mut *connection)
        .await?;
        let Some(row) = row else { return Ok(None) };
        let number = count(&row, "number")?;
        let token = Uuid::new_v4().to_string();
        sqlx::query(
            "UPDATE recording_attempts SET owner = $1, token = $2, lease_until = $3, tries = tries + 1, was_beside = 0
             WHERE recording_id = $4 AND number = $5",
        )
        .bind(&self.owner)
        .bind(&token)
        .bind(self.until_ms)
        .bind(recording.id.as_str())
        .bind(stored(number))
        .execute(&mut *connection)
        .await?;
        self.note_taken(connection, &recording.id).await?;
        let lease = AttemptLease { id: recording.id.clone(), number, token };
        let (work, tries) = (RecordingWork::Attempt(lease), row.try_get::<i64, _>("tries")? + 1);
        Ok(Some(Claimed::Work(Box::new(RecordingClaim { recording: recording.clone(), work, tries }))))
    }

    /// Ends the reservation of a recording that was taken.
    async fn note_taken(&self, connection: &mut AnyConnection, id: &RecordingId) -> Result<(), StoreError> {
        sqlx::query("UPDATE recordings SET reserved_by = NULL WHERE id = $1 AND reserved_by IS NOT NULL")
            .bind(id.as_str())
            .execute(connection)
            .await?;
        Ok(())
    }

    /// The next attempt.
    async fn next(
        &self,
        connection: &mut AnyConnection,
        recording: RecordingRow,
        number: u64,
    ) -> Result<Claimed, StoreError> {
        let token = Uuid::new_v4().to_string();
        sqlx::query(
            "INSERT INTO recording_attempts (recording_id, number, owner, token, lease_until, tries)
             VALUES ($1, $2, $3, $4, $5, 1)",
        )
        .bind(recording.id.as_str())
        .bind(stored(number))
        .bind(&self.owner)
        .bind(&token)
        .bind(self.until_ms)
        .execute(&mut *connection)
        .await?;
        let row = sqlx::query(
            "UPDATE recordings SET begun = begun + 1, state = 'running', started_at = COALESCE(started_at, $1),
                                   reserved_by = NULL
             WHERE id = $2 RETURNING *",
        )
        .bind(self.now_ms)
        .bind(recording.id.as_str())
        .fetch_one(&mut *connection)
        .await?;
        let is_first = recording.state == RecordingState::Queued;
        if is_first {
            append(connection, &recording.id, self.now_ms, RecordingEventKind::Running, Map::new()).await?;
        }
        let lease = AttemptLease { id: recording.id, number, token };
        let claim =
            RecordingClaim { recording: recording_of(&row)?, work: RecordingWork::Attempt(lease), tries: 1 };
        Ok(if is_first { Claimed::Change(Box::new(claim)) } else { Claimed::Work(Box::new(claim)) })
    }

    async fn assembly(
        &self,
        connection: &mut AnyConnection,
        recording: RecordingRow,
    ) -> Result<Claimed, StoreError> {
        let token = Uuid::new_v4().to_string();
        let tries: i64 = sqlx::query_scalar(
            "UPDATE recordings
             SET owner = $1, token = $2, lease_until = $3, tries = tries + 1, was_beside = 0, reserved_by = NULL
             WHERE id = $4 RETURNING tries",
        )
        .bind(&self.owner)
        .bind(&token)
        .bind(self.until_ms)
        .bind(recording.id.as_str())
        .fetch_one(&mut *connection)
        .await?;
        // Which process assembles is of no interest: one event tells of it, however often it is begun.
        let is_repetition = ends_with(connection, &recording.id, RecordingEventKind::Assembling).await?;
        if !is_repetition {
            append(connection, &recording.id, self.now_ms, RecordingEventKind::Assembling, Map::new())
                .await?;
        }
        let lease = AssemblyLease { id: recording.id.clone(), token };
        let claim = Box::new(RecordingClaim { recording, work: RecordingWork::Assembly(lease), tries });
        Ok(if is_repetition { Claimed::Work(claim) } else { Claimed::Change(claim) })
    }
}

/// Fails with [`StoreError::RecordingLeaseLost`] unless the attempt is still this process's; locks the recording's
/// row.
pub(super) async fn guard_attempt(
    connection: &mut AnyConnection,
    lease: &AttemptLease,
) -> Result<AnyRow, StoreError> {
    let lost = || StoreError::RecordingLeaseLost { id: lease.id.clone() };
    let lock = Dialect::of(connection).lock();
    let query = format!("SELECT * FROM recordings WHERE id = $1 {lock}");
    let row = sqlx::query(AssertSqlSafe(query))
        .bind(lease.id.as_str())
        .fetch_optional(&mut *connection)
        .await?
        .ok_or_else(lost)?;
    let held = sqlx::query(
        "SELECT 1 FROM recording_attempts
         WHERE recording_id = $1 AND number = $2 AND token = $3 AND outcome IS NULL",
    )
    .bind(lease.id.as_str())
    .bind(stored(lease.number))
    .bind(&lease.token)
    .fetch_optional(connection)
    .await?;
    held.map(|_| row).ok_or_else(lost)
}

/// Fails with [`StoreError::RecordingLeaseLost`] unless assembling is still this process's; locks the recording's row.
pub(super) async fn guard_assembly(
    connection: &mut AnyConnection,
    lease: &AssemblyLease,
) -> Result<(), StoreError> {
    let lock = Dialect::of(connection).lock();
    let query = format!("SELECT 1 FROM recordings WHERE id = $1 AND token = $2 {lock}");
    let held = sqlx::query(AssertSqlSafe(query))
        .bind(lease.id.as_str())
        .bind(&lease.token)
        .fetch_optional(connection)
        .await?;
    held.map(|_| ()).ok_or_else(|| StoreError::RecordingLeaseLost { id: lease.id.clone() })
}

fn milliseconds(duration: Duration) -> i64 {
    i64::try_from(duration.as_millis()).unwrap_or(i64::MAX / 4)
}
