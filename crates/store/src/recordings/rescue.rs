//! What becomes of a recording whose process died: its attempts and its assembling are given back, or it fails.
//!
//! A process costs a recording one death, however many of its attempts it was making. Whom a death is blamed on stands
//! in [`crate::deaths`]; a finished attempt is the progress after which deaths count anew.

use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::attempts::fail;
use crate::database::Dialect;
use crate::deaths::Deaths;
use crate::{StoreError, database};
use scene::RecordingId;

/// Recordings of dead processes in one transaction at most.
const MAX_RESCUED: i64 = 16;

/// A process that died, and a recording that it worked on.
struct Orphan {
    id: RecordingId,
    owner: String,
}

/// Gives work of dead processes back; how many recordings failed, as processes died over them too often.
pub(super) async fn rescue(
    connection: &mut AnyConnection,
    owner: &str,
    max_deaths: i64,
    is_shared: bool,
    now_ms: i64,
) -> Result<u64, StoreError> {
    let mut failed = 0;
    for orphan in orphans(connection, owner, is_shared, now_ms).await? {
        failed += u64::from(give_back(connection, &orphan, max_deaths, now_ms).await?);
    }
    Ok(failed)
}

/// Recordings that dead processes worked on.
async fn orphans(
    connection: &mut AnyConnection,
    owner: &str,
    is_shared: bool,
    now_ms: i64,
) -> Result<Vec<Orphan>, StoreError> {
    // In a file of one process the leases of other owners are those of dead ones.
    let dead = if is_shared { "lease_until <= $1" } else { "(lease_until <= $1 OR owner <> $2)" };
    let query = format!(
        "SELECT recording_id, owner FROM recording_attempts WHERE outcome IS NULL AND owner <> '' AND {dead}
         UNION
         SELECT id, owner FROM recordings WHERE state IN ('queued', 'running') AND owner IS NOT NULL AND {dead}
         ORDER BY 1, 2 LIMIT {MAX_RESCUED}"
    );
    let query = sqlx::query(AssertSqlSafe(query)).bind(now_ms);
    let query = if is_shared { query } else { query.bind(owner) };
    let rows = query.fetch_all(connection).await?;
    let orphan = |row| {
        Ok(Orphan { id: database::id(row, "recordings", "recording_id")?, owner: row.try_get("owner")? })
    };
    rows.iter().map(orphan).collect()
}

/// Gives back what a dead process had of a recording. Whether the recording failed.
async fn give_back(
    connection: &mut AnyConnection,
    orphan: &Orphan,
    max_deaths: i64,
    now_ms: i64,
) -> Result<bool, StoreError> {
    let Orphan { id, owner } = orphan;
    let lock = Dialect::of(connection).lock();
    let query = format!(
        "SELECT shared_deaths, lone_deaths,
                CASE WHEN (was_beside = 1 AND owner = $1) OR EXISTS (
                         SELECT 1 FROM recording_attempts
                         WHERE recording_id = recordings.id AND outcome IS NULL
                           AND recording_attempts.owner = $1 AND recording_attempts.was_beside = 1)
                     THEN CAST(1 AS BIGINT) ELSE CAST(0 AS BIGINT) END AS was_beside
         FROM recordings WHERE id = $2 AND state IN ('queued', 'running') {lock}"
    );
    let row = sqlx::query(AssertSqlSafe(query))
        .bind(owner)
        .bind(id.as_str())
        .fetch_optional(&mut *connection)
        .await?;
    let Some(row) = row else { return Ok(false) };
    // With new tokens, a process that was only slow loses what it made.
    let attempts = sqlx::query(
        "UPDATE recording_attempts SET owner = '', token = '', lease_until = 0, was_beside = 0,
                                       tries = CASE WHEN tries > 0 THEN tries - 1 ELSE 0 END
         WHERE recording_id = $1 AND owner = $2 AND outcome IS NULL",
    )
    .bind(id.as_str())
    .bind(owner)
    .execute(&mut *connection)
    .await?
    .rows_affected();
    let assembling = sqlx::query(
        "UPDATE recordings SET owner = NULL, token = NULL, lease_until = 0, was_beside = 0,
                               tries = CASE WHEN tries > 0 THEN tries - 1 ELSE 0 END
         WHERE id = $1 AND owner = $2",
    )
    .bind(id.as_str())
    .bind(owner)
    .execute(&mut *connection)
    .await?
    .rows_affected();
    if attempts + assembling == 0 {
        // Another process was faster.
        return Ok(false);
    }
    let deaths = Deaths::count(connection, Deaths::of(&row)?, owner, id.as_str()).await?;
    if deaths.are_too_many(max_deaths) {
        let message = format!(
            "the process died {} times while it worked on this recording alone, and finished no attempt between; see its \
             log and memory, then order it again",
            deaths.lone
        );
        fail(connection, id, "interrupted_too_often", &message).await?;
        return Ok(true);
    }
    sqlx::query("UPDATE recordings SET shared_deaths = $1, lone_deaths = $2, not_before = $3 WHERE id = $4")
        .bind(deaths.shared)
        .bind(deaths.lone)
        .bind(now_ms + deaths.delay_ms())
        .bind(id.as_str())
        .execute(connection)
        .await?;
    Ok(false)
}
