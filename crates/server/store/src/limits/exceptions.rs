//! Limits of tenants as the operator sees them: with what is used, and set for one tenant. A change counts in every
//! process within a second, that of bytes within half a minute.

use sqlx::{AnyConnection, AssertSqlSafe};

use super::{Limit, Month, TenantLimits, admission, of_month, of_tenant, pace};
use crate::boxed;
use crate::retention::usage;
use crate::{Operator, StoreError, batches, database};
use scene::TenantId;

/// A new value of a limit of one tenant; `None` = that of the settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimitChange {
    pub limit: Limit,
    pub value: Option<i64>,
}

/// A limit of a tenant, and what is used of it. Money is in millionths of a US dollar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TenantAccount {
    pub limit: Limit,
    /// 0 = none.
    pub max: i64,
    /// Whether the tenant has a value of its own.
    pub is_exception: bool,
    pub used: i64,
}

impl Operator {
    /// Tenants that have scenes, batches or limits of their own, by name.
    #[boxed]
    pub async fn tenants(&mut self) -> Result<Vec<TenantId>, StoreError> {
        // The recursion visits each tenant once instead of each row.
        let names: Vec<String> = sqlx::query_scalar(
            "WITH RECURSIVE with_scenes (tenant_id) AS (
                 SELECT MIN(tenant_id) FROM scenes
                 UNION ALL
                 SELECT (SELECT MIN(later.tenant_id) FROM scenes AS later
                         WHERE later.tenant_id > with_scenes.tenant_id)
                 FROM with_scenes WHERE with_scenes.tenant_id IS NOT NULL
             ), with_batches (tenant_id) AS (
                 SELECT MIN(tenant_id) FROM batches
                 UNION ALL
                 SELECT (SELECT MIN(later.tenant_id) FROM batches AS later
                         WHERE later.tenant_id > with_batches.tenant_id)
                 FROM with_batches WHERE with_batches.tenant_id IS NOT NULL
             )
             SELECT tenant_id FROM with_scenes WHERE tenant_id IS NOT NULL
             UNION SELECT tenant_id FROM with_batches WHERE tenant_id IS NOT NULL
             UNION SELECT tenant_id FROM tenant_limits
             ORDER BY 1",
        )
        .fetch_all(&mut self.connection)
        .await?;
        names.iter().map(|name| database::parse_id(name, "scenes")).collect()
    }

    /// The limits of a tenant, and what is used of each. Bytes are added up, which takes a while where there are many.
    #[boxed]
    pub async fn account_of(&mut self, tenant_id: &TenantId) -> Result<Vec<TenantAccount>, StoreError> {
        let connection = &mut self.connection;
        let limits = of_tenant(connection, &self.limits, tenant_id).await?;
        let usual = TenantLimits::new(&self.limits, None)?;
        let now = database::now_ms(connection).await?;
        let month = Month::now(connection).await?;
        let running: i64 = sqlx::query_scalar(
            "SELECT COUNT(*) FROM jobs WHERE tenant_id = $1 AND state IN ('running', 'cancelling')",
        )
        .bind(tenant_id.as_str())
        .fetch_one(&mut *connection)
        .await?;
        let mut accounts = Vec::with_capacity(Limit::OF_TENANT.len());
        for limit in Limit::OF_TENANT {
            let max = limits.get(limit);
            let used = match limit {
                Limit::Bytes => usage::bytes_of(connection, tenant_id).await?,
                Limit::WaitingJobs | Limit::AllWaitingScenes => {
                    admission::waiting_work(connection, tenant_id).await?
                }
                Limit::RunningJobs => running,
                Limit::SubmissionsPerMinute => pace::used(connection, tenant_id, max, now).await?,
                Limit::UsdPerMonth => of_month(connection, tenant_id, &month).await?,
                Limit::BatchRequests => batches::unsettled(connection, tenant_id).await?,
            };
            accounts.push(TenantAccount { limit, max, is_exception: max != usual.get(limit), used });
        }
        Ok(accounts)
    }

    /// Sets limits of a tenant.
    #[boxed]
    pub async fn set_limits(
        &mut self,
        tenant_id: &TenantId,
        changes: &[LimitChange],
    ) -> Result<(), StoreError> {
        set(&mut self.connection, tenant_id, changes).await
    }
}

/// Sets limits of a tenant.
pub(crate) async fn set(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    changes: &[LimitChange],
) -> Result<(), StoreError> {
    let now = database::now_ms(connection).await?;
    sqlx::query(
        "INSERT INTO tenant_limits (tenant_id, changed_at) VALUES ($1, $2)
         ON CONFLICT (tenant_id) DO UPDATE SET changed_at = excluded.changed_at",
    )
    .bind(tenant_id.as_str())
    .bind(now)
    .execute(&mut *connection)
    .await?;
    for LimitChange { limit, value } in changes {
        let query = format!("UPDATE tenant_limits SET {} = $1 WHERE tenant_id = $2", limit.column());
        sqlx::query(AssertSqlSafe(query))
            .bind(value)
            .bind(tenant_id.as_str())
            .execute(&mut *connection)
            .await?;
    }
    Ok(())
}
