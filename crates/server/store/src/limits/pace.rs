//! Submissions of a tenant over time: the generic cell rate algorithm (ITU-T I.371, "GCRA"), a bucket of tokens that
//! needs one number a tenant.
//!
//! Each submission moves the time `used_up` on by its share of a minute; it may lie at most a minute ahead. So a tenant
//! that was quiet may submit a minute's worth at once, then evenly. In any minute it is at most twice the limit.

use sqlx::{AnyConnection, AssertSqlSafe};

use super::{Limit, LimitReached};
use crate::StoreError;
use crate::database::Dialect;
use scene::TenantId;

const MINUTE_US: i64 = 60_000_000;

/// Takes up to `wanted` submissions of a tenant at `now_ms`; how many there were. Inner `Err` where there is none. The
/// row stays locked until the end of the transaction.
pub(crate) async fn take(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    per_minute: i64,
    wanted: i64,
    now_ms: i64,
) -> Result<Result<i64, LimitReached>, StoreError> {
    sqlx::query(
        "INSERT INTO tenant_paces (tenant_id, used_up) VALUES ($1, 0) ON CONFLICT (tenant_id) DO NOTHING",
    )
    .bind(tenant_id.as_str())
    .execute(&mut *connection)
    .await?;
    let lock = Dialect::of(connection).lock();
    let query = format!("SELECT used_up FROM tenant_paces WHERE tenant_id = $1 {lock}");
    let used_up: i64 =
        sqlx::query_scalar(AssertSqlSafe(query)).bind(tenant_id.as_str()).fetch_one(&mut *connection).await?;
    let (taken, used_up) = match after(used_up, per_minute, wanted, now_ms.saturating_mul(1000)) {
        Ok(after) => after,
        Err(reached) => return Ok(Err(reached)),
    };
    sqlx::query("UPDATE tenant_paces SET used_up = $1 WHERE tenant_id = $2")
        .bind(used_up)
        .bind(tenant_id.as_str())
        .execute(connection)
        .await?;
    Ok(Ok(taken))
}

/// Submissions of the last minute that count, for a report.
pub(super) async fn used(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    per_minute: i64,
    now_ms: i64,
) -> Result<i64, StoreError> {
    let used_up: Option<i64> = sqlx::query_scalar("SELECT used_up FROM tenant_paces WHERE tenant_id = $1")
        .bind(tenant_id.as_str())
        .fetch_optional(connection)
        .await?;
    let ahead = used_up.unwrap_or(0).saturating_sub(now_ms.saturating_mul(1000)).max(0);
    Ok(if per_minute > 0 { ahead / share_us(per_minute) } else { 0 })
}

/// Share of a minute of one submission, microseconds.
fn share_us(per_minute: i64) -> i64 {
    (MINUTE_US / per_minute).max(1)
}

/// Number of submissions that are taken, and the time until which they are used up.
fn after(used_up: i64, per_minute: i64, wanted: i64, now_us: i64) -> Result<(i64, i64), LimitReached> {
    let share = share_us(per_minute);
    // A clock that was set back does not stop a tenant for longer than a minute.
    let ahead = used_up.saturating_sub(now_us).clamp(0, share.saturating_mul(per_minute));
    let free = per_minute - (ahead + share - 1) / share;
    if free < 1 {
        let until_free_us = ahead - share * (per_minute - 1);
        let retry_after_secs = (until_free_us + 999_999) / 1_000_000;
        return Err(LimitReached {
            limit: Limit::SubmissionsPerMinute,
            max: per_minute,
            used: per_minute,
            retry_after_secs: retry_after_secs.max(1),
        });
    }
    let taken = wanted.min(free);
    Ok((taken, now_us + ahead + taken * share))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times of `count` tries, microseconds apart, and which of them were taken.
    fn taken(per_minute: i64, count: i64, apart_us: i64) -> Vec<i64> {
        let mut used_up = 0;
        let start = 1_000_000_000_000_000;
        (0..count)
            .map(|k| start + k * apart_us)
            .filter(|now_us| match after(used_up, per_minute, 1, *now_us) {
                Ok((1, next)) => {
                    used_up = next;
                    true
                }
                _ => false,
            })
            .collect()
    }

    #[test]
    fn a_quiet_tenant_takes_a_minutes_worth_at_once_and_no_more() {
        for per_minute in [1, 3, 7, 60, 1000, 90_000] {
            assert_eq!(taken(per_minute, 2 * per_minute, 0).len() as i64, per_minute);
        }
    }

    #[test]
    fn any_minute_has_at_most_twice_the_limit_and_a_long_time_the_limit() {
        for per_minute in [1, 7, 60] {
            let times = taken(per_minute, 10 * 60 * 20, 50_000);
            for (index, time) in times.iter().enumerate() {
                let within = times[index..].iter().take_while(|later| *later - time < MINUTE_US).count();
                assert!(within as i64 <= 2 * per_minute, "{within} in a minute at {per_minute}");
            }
            // Ten minutes, and the burst at their begin.
            let expected = 11 * per_minute;
            assert!((times.len() as i64 - expected).abs() <= 1, "{} of {expected}", times.len());
        }
    }

    #[test]
    fn a_refusal_states_when_the_next_is_taken() {
        let now = 1_000_000_000_000_000;
        let (taken, used_up) = after(0, 6, 99, now).expect("all are free");
        assert_eq!(taken, 6);
        let refused = after(used_up, 6, 1, now).expect_err("none is left");
        assert_eq!((refused.max, refused.used, refused.retry_after_secs), (6, 6, 10));
        let later = now + refused.retry_after_secs * 1_000_000;
        assert_eq!(after(used_up, 6, 9, later).map(|(taken, _)| taken), Ok(1));
        // A clock that was set back by a year holds the tenant for a minute at most.
        let early = now - 365 * 86_400 * 1_000_000;
        let refused = after(used_up, 6, 1, early).expect_err("it looks used up");
        assert!(refused.retry_after_secs <= 60, "{refused:?}");
    }
}
