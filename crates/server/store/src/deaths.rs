//! Deaths of processes: which job is blamed, which runs alone, and how long it waits.
//!
//! A process dies because of some of its work, or because of something else: a signal, a power cut, the kernel. The
//! store cannot tell, so work is blamed only for what no other work can have caused:
//!
//! - If the process held several jobs, none is blamed: each counts a shared death.
//! - If it held one, that one counts a lone death.
//! - Both counts start again at the next progress (a new checkpoint, a new file of a version, a finished attempt), and
//!   neither counts as a failed attempt.
//! - After two deaths work runs alone in its process, so that a third death is certain to be its own.
//! - After `worker.max_deaths` lone deaths it fails with a diagnosis.
//!
//! After its first death work returns to the queue at once. After each further lone death it waits: 1 s, 2 s, 4 s, up
//! to a minute. So work that is hit by a series of kills outlasts it, and work that kills processes does so rarely.
//!
//! A process that is busy reserves work that has to run alone, takes no other, and gets to it when its other work has
//! ended. Other busy processes go on meanwhile; an idle one takes it at once.

use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::StoreError;
use scene::JobId;

const FIRST_DELAY_MS: i64 = 1_000;
const MAX_DELAY_MS: i64 = 60_000;
/// Time that a reservation lasts unless the process asks again, milliseconds.
const RESERVATION_MS: i64 = 10_000;

/// Condition on a job that has to run alone.
pub(crate) const IS_SUSPECT: &str = "shared_deaths + lone_deaths >= 2";

/// Jobs that the process `$1` holds.
const HELD: &str = "owner = $1 AND state IN ('running', 'cancelling')";

/// Work that a process may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Hands {
    /// Whether it holds nothing, so that it may take work that has to run alone.
    pub(crate) are_empty: bool,
    /// Whether it holds work that has to run alone, so that it may take nothing.
    pub(crate) are_bound: bool,
    /// Whether it has reserved work that has to run alone, so that it may take no other.
    pub(crate) keep_free: bool,
}

/// Work that the process may take now.
pub(crate) async fn hands(
    connection: &mut AnyConnection,
    owner: &str,
    now_ms: i64,
) -> Result<Hands, StoreError> {
    let held = format!(
        "SELECT COUNT(*) AS held, COUNT(CASE WHEN {IS_SUSPECT} THEN 1 END) AS alone FROM jobs WHERE {HELD}"
    );
    let row = sqlx::query(AssertSqlSafe(held)).bind(owner).fetch_one(&mut *connection).await?;
    let reserved = format!(
        "SELECT id FROM jobs WHERE state = 'queued' AND {IS_SUSPECT} AND reserved_by = $1 AND reserved_until > $2 LIMIT 1"
    );
    let reserved: Option<String> = sqlx::query_scalar(AssertSqlSafe(reserved))
        .bind(owner)
        .bind(now_ms)
        .fetch_optional(connection)
        .await?;
    Ok(Hands {
        are_empty: row.try_get::<i64, _>("held")? == 0,
        are_bound: row.try_get::<i64, _>("alone")? > 0,
        keep_free: reserved.is_some(),
    })
}

/// Reserves a waiting job for a busy process, unless another one has reserved it. Whether it has it now.
pub(crate) async fn reserve(
    connection: &mut AnyConnection,
    id: &JobId,
    owner: &str,
    now_ms: i64,
) -> Result<bool, StoreError> {
    let reserved = sqlx::query(
        "UPDATE jobs SET reserved_by = $1, reserved_until = $2
         WHERE id = $3 AND (reserved_by IS NULL OR reserved_by = $1 OR reserved_until <= $4)",
    )
    .bind(owner)
    .bind(now_ms + RESERVATION_MS)
    .bind(id.as_str())
    .bind(now_ms)
    .execute(connection)
    .await?;
    Ok(reserved.rows_affected() > 0)
}

/// The deaths of work since its last progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Deaths {
    pub(crate) shared: i64,
    pub(crate) lone: i64,
    /// The process held nothing else when it died the last time.
    pub(crate) alone: bool,
}

impl Deaths {
    /// Counts the death of the process `owner`, which held this job. Its other jobs, whose leases may run out later,
    /// are marked.
    pub(crate) async fn count(
        connection: &mut AnyConnection,
        before: Self,
        owner: &str,
        id: &JobId,
    ) -> Result<Self, StoreError> {
        let mark = format!("UPDATE jobs SET was_beside = 1 WHERE {HELD} AND id <> $2");
        let marked =
            sqlx::query(AssertSqlSafe(mark)).bind(owner).bind(id.as_str()).execute(connection).await?;
        let alone = marked.rows_affected() == 0 && before.alone;
        Ok(Self { shared: before.shared + i64::from(!alone), lone: before.lone + i64::from(alone), alone })
    }

    /// Deaths of a row with the columns `shared_deaths`, `lone_deaths` and `was_beside`.
    pub(crate) fn of(row: &sqlx::any::AnyRow) -> Result<Self, StoreError> {
        Ok(Self {
            shared: row.try_get("shared_deaths")?,
            lone: row.try_get("lone_deaths")?,
            alone: row.try_get::<i64, _>("was_beside")? == 0,
        })
    }

    /// Whether the work is to fail: it was alone when its process died, and that too often.
    pub(crate) fn are_too_many(self, max_deaths: i64) -> bool {
        self.alone && self.lone >= max_deaths
    }

    /// Time that the work waits.
    pub(crate) fn delay_ms(self) -> i64 {
        if self.alone { delay_ms(self.lone) } else { 0 }
    }
}

/// Delay after the n-th lone death: none, then 1 s, 2 s, 4 s, ... 60 s.
fn delay_ms(lone_deaths: i64) -> i64 {
    match u32::try_from(lone_deaths - 2) {
        Ok(doublings) => FIRST_DELAY_MS.saturating_mul(1 << doublings.min(16)).min(MAX_DELAY_MS),
        Err(_) => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_death_costs_no_time_and_later_ones_double() {
        assert_eq!([1, 2, 3, 4, 8, 9, 99].map(delay_ms), [0, 1_000, 2_000, 4_000, 60_000, 60_000, 60_000]);
    }
}
