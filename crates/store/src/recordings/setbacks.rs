//! Work on a recording that failed: an attempt and assembling are tried again after a delay, so often, and end the
//! recording then. Each attempt counts for itself, so that others that go on well do not hide one that cannot be made.

use serde_json::{Map, json};
use sqlx::{AnyConnection, Row};

use super::attempts::{SUCCESS, fail};
use super::claim::{guard_assembly, guard_attempt};
use super::events::append;
use super::{AssemblyLease, AttemptLease, RecordingEventKind, stored};
use crate::boxed;
use crate::{AfterSetback, Setback, Store, StoreError, database};

impl Store {
    /// Ends a try at an attempt that failed.
    ///
    /// # Errors
    ///
    /// [`StoreError::RecordingLeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn set_attempt_back(
        &self,
        lease: &AttemptLease,
        setback: Setback,
    ) -> Result<AfterSetback, StoreError> {
        let lease = lease.clone();
        let after = self
            .writer
            .write("set an attempt back", move |connection| {
                Box::pin(async move {
                    guard_attempt(connection, &lease).await?;
                    set_attempt_back(connection, &lease, &setback).await
                })
            })
            .await?;
        self.announce();
        Ok(after)
    }

    /// Ends a try at assembling that failed.
    ///
    /// # Errors
    ///
    /// [`StoreError::RecordingLeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn set_assembly_back(
        &self,
        lease: &AssemblyLease,
        setback: Setback,
    ) -> Result<AfterSetback, StoreError> {
        let lease = lease.clone();
        let after = self
            .writer
            .write("set assembling back", move |connection| {
                Box::pin(async move { set_assembly_back(connection, &lease, &setback).await })
            })
            .await?;
        self.announce();
        Ok(after)
    }

    /// Has an attempt made again whose episode is lost or damaged; assembling is given back. An attempt whose episode
    /// is lost again and again ends the recording.
    ///
    /// # Errors
    ///
    /// [`StoreError::RecordingLeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn forget_attempt(
        &self,
        lease: &AssemblyLease,
        number: u64,
        setback: Setback,
    ) -> Result<AfterSetback, StoreError> {
        let lease = lease.clone();
        let after = self
            .writer
            .write("forget an attempt", move |connection| {
                Box::pin(async move { forget_attempt(connection, &lease, number, &setback).await })
            })
            .await?;
        self.announce();
        Ok(after)
    }
}

/// Lets an attempt wait, without an owner, or ends the recording. The recording's row is locked.
async fn set_attempt_back(
    connection: &mut AnyConnection,
    lease: &AttemptLease,
    setback: &Setback,
) -> Result<AfterSetback, StoreError> {
    let tries: i64 =
        sqlx::query_scalar("SELECT tries FROM recording_attempts WHERE recording_id = $1 AND number = $2")
            .bind(lease.id.as_str())
            .bind(stored(lease.number))
            .fetch_one(&mut *connection)
            .await?;
    if setback.is_end(tries) {
        fail(connection, &lease.id, setback.code, &setback.message).await?;
        return Ok(AfterSetback::Ended);
    }
    let now = database::now_ms(connection).await?;
    sqlx::query(
        "UPDATE recording_attempts SET owner = '', token = '', lease_until = 0, not_before = $1, tries = $2
         WHERE recording_id = $3 AND number = $4",
    )
    .bind(setback.again_at_ms(now))
    .bind(setback.counted(tries))
    .bind(lease.id.as_str())
    .bind(stored(lease.number))
    .execute(connection)
    .await?;
    Ok(AfterSetback::Again)
}

async fn set_assembly_back(
    connection: &mut AnyConnection,
    lease: &AssemblyLease,
    setback: &Setback,
) -> Result<AfterSetback, StoreError> {
    guard_assembly(connection, lease).await?;
    let tries: i64 = sqlx::query_scalar("SELECT tries FROM recordings WHERE id = $1")
        .bind(lease.id.as_str())
        .fetch_one(&mut *connection)
        .await?;
    if setback.is_end(tries) {
        fail(connection, &lease.id, setback.code, &setback.message).await?;
        return Ok(AfterSetback::Ended);
    }
    let now = database::now_ms(connection).await?;
    sqlx::query(
        "UPDATE recordings SET owner = NULL, token = NULL, lease_until = 0, not_before = $1, tries = $2 WHERE id = $3",
    )
    .bind(setback.again_at_ms(now))
    .bind(setback.counted(tries))
    .bind(lease.id.as_str())
    .execute(connection)
    .await?;
    Ok(AfterSetback::Again)
}

async fn forget_attempt(
    connection: &mut AnyConnection,
    lease: &AssemblyLease,
    number: u64,
    setback: &Setback,
) -> Result<AfterSetback, StoreError> {
    guard_assembly(connection, lease).await?;
    let attempt = sqlx::query(
        "SELECT outcome, tries FROM recording_attempts
         WHERE recording_id = $1 AND number = $2 AND outcome IS NOT NULL",
    )
    .bind(lease.id.as_str())
    .bind(stored(number))
    .fetch_optional(&mut *connection)
    .await?;
    let Some(attempt) = attempt else { return Ok(AfterSetback::Again) };
    let tries: i64 = attempt.try_get("tries")?;
    if setback.is_end(tries) {
        fail(connection, &lease.id, setback.code, &setback.message).await?;
        return Ok(AfterSetback::Ended);
    }
    let now = database::now_ms(connection).await?;
    sqlx::query(
        "UPDATE recording_attempts
         SET outcome = NULL, detail = NULL, unit = NULL, made_at = NULL, owner = '', token = '', lease_until = 0,
             not_before = $1, tries = $2
         WHERE recording_id = $3 AND number = $4",
    )
    .bind(setback.again_at_ms(now))
    .bind(setback.counted(tries))
    .bind(lease.id.as_str())
    .bind(stored(number))
    .execute(&mut *connection)
    .await?;
    // Assembling is not to blame, so this is no try of it.
    sqlx::query(
        "UPDATE recordings SET made = made - 1, successes = successes - $1, owner = NULL, token = NULL, lease_until = 0,
                               tries = CASE WHEN tries > 0 THEN tries - 1 ELSE 0 END
         WHERE id = $2",
    )
    .bind(i64::from(attempt.try_get::<String, _>("outcome")? == SUCCESS))
    .bind(lease.id.as_str())
    .execute(&mut *connection)
    .await?;
    let fields = Map::from_iter([("number".to_owned(), json!(number))]);
    append(connection, &lease.id, now, RecordingEventKind::AttemptLost, fields).await?;
    Ok(AfterSetback::Again)
}
