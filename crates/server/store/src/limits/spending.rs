//! Spending of a tenant by calendar month (UTC): the sum that triggers keep beside the ledger of calls.

use sqlx::AnyConnection;

use super::{Limit, LimitReached};
use crate::StoreError;
use crate::database::Dialect;
use scene::TenantId;

/// The present month.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Month {
    /// As rows name it: `2026-01`.
    pub(crate) name: String,
    /// Time until its end, seconds.
    pub(crate) secs_left: i64,
}

impl Month {
    /// The month by the database's clock.
    pub(crate) async fn now(connection: &mut AnyConnection) -> Result<Self, StoreError> {
        let query = match Dialect::of(connection) {
            Dialect::Sqlite => {
                "SELECT strftime('%Y-%m', 'now'),
                        unixepoch('now', 'start of month', '+1 month') - unixepoch('now')"
            }
            Dialect::Postgres => {
                "SELECT to_char(now, 'YYYY-MM'),
                        CAST(EXTRACT(EPOCH FROM date_trunc('month', now) + interval '1 month' - now) AS BIGINT)
                 FROM (SELECT clock_timestamp() AT TIME ZONE 'UTC' AS now) AS clock"
            }
        };
        let (name, secs_left): (String, i64) = sqlx::query_as(query).fetch_one(connection).await?;
        Ok(Self { name, secs_left })
    }
}

/// Cost of the calls of a tenant in a month, or what they may cost, millionths of a US dollar.
pub(crate) async fn of_month(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    month: &Month,
) -> Result<i64, StoreError> {
    let spent: Option<i64> =
        sqlx::query_scalar("SELECT micro_usd FROM tenant_spending WHERE tenant_id = $1 AND month = $2")
            .bind(tenant_id.as_str())
            .bind(&month.name)
            .fetch_optional(connection)
            .await?;
    Ok(spent.unwrap_or(0))
}

/// The limit of a month, if a tenant has spent it: no new work is taken until the month ends. `max` 0 is no limit.
pub(crate) async fn reached(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    max: i64,
) -> Result<Option<LimitReached>, StoreError> {
    if max == 0 {
        return Ok(None);
    }
    let month = Month::now(connection).await?;
    let used = of_month(connection, tenant_id, &month).await?;
    let retry_after_secs = month.secs_left.max(1);
    Ok((used >= max).then_some(LimitReached { limit: Limit::UsdPerMonth, max, used, retry_after_secs }))
}
