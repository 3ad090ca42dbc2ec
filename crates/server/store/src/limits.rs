//! Limits of one tenant: bytes, jobs that wait and run, submissions, spending, requests of batches.
//!
//! The settings have those of every tenant; a row of `tenant_limits` replaces some of them for one ([`exceptions`]).
//! They are checked in the transaction that makes work ([`admission`]), so that submissions at once do not exceed them
//! together. Bytes are added up in the background instead (see `retention::usage`), and jobs that run are held back
//! when a worker claims (see `queue::turns`).

mod admission;
mod exceptions;
mod pace;
mod spending;

use serde::{Deserialize, Serialize};
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, Row};

use super::StoreError;
use super::database::Dialect;
use scene::{MicroUsd, TenantId};

pub(crate) use admission::{Admission, waiting_work};
#[cfg(test)]
pub(crate) use exceptions::set;
pub use exceptions::{LimitChange, TenantAccount};
pub(crate) use pace::take as take_pace;
pub(crate) use spending::{Month, of_month, reached as spent};

/// Section `[store.limits]`: what one tenant may have. 0 is no limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LimitSettings {
    /// Bytes of its artifacts, bundles, datasets, recordings and executions together.
    pub bytes: i64,
    /// Jobs that wait, and recordings that have not ended.
    pub waiting_jobs: i64,
    /// Jobs that run at the same time.
    pub running_jobs: i64,
    /// Submissions in a minute.
    pub submissions_per_minute: i64,
    /// Cost of calls of remote models in a calendar month (UTC), US dollars.
    pub usd_per_month: f64,
    /// Requests of its batches that have not come to their end.
    pub batch_requests: i64,
}

/// A limit of a tenant, or of the queue of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Limit {
    Bytes,
    WaitingJobs,
    RunningJobs,
    SubmissionsPerMinute,
    /// In millionths of a US dollar, where it is a number.
    UsdPerMonth,
    BatchRequests,
    /// Scenes of all tenants that wait: `queue.max_jobs`.
    AllWaitingScenes,
}

impl Limit {
    /// Limits of one tenant.
    pub const OF_TENANT: [Self; 6] = [
        Self::Bytes,
        Self::WaitingJobs,
        Self::RunningJobs,
        Self::SubmissionsPerMinute,
        Self::UsdPerMonth,
        Self::BatchRequests,
    ];

    /// The setting.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Bytes => "store.limits.bytes",
            Self::WaitingJobs => "store.limits.waiting_jobs",
            Self::RunningJobs => "store.limits.running_jobs",
            Self::SubmissionsPerMinute => "store.limits.submissions_per_minute",
            Self::UsdPerMonth => "store.limits.usd_per_month",
            Self::BatchRequests => "store.limits.batch_requests",
            Self::AllWaitingScenes => "queue.max_jobs",
        }
    }

    /// Column of `tenant_limits`.
    fn column(self) -> &'static str {
        match self {
            Self::Bytes => "bytes",
            Self::WaitingJobs | Self::AllWaitingScenes => "waiting_jobs",
            Self::RunningJobs => "running_jobs",
            Self::SubmissionsPerMinute => "submissions_per_minute",
            Self::UsdPerMonth => "micro_usd_per_month",
            Self::BatchRequests => "batch_requests",
        }
    }
}

/// A limit that leaves no room for what was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimitReached {
    pub limit: Limit,
    /// Value of the limit.
    pub max: i64,
    /// Amount that is used of it, without what was asked for.
    pub used: i64,
    /// Estimated time until there may be room, seconds.
    pub retry_after_secs: i64,
}

/// The limits of one tenant; 0 is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TenantLimits {
    pub bytes: i64,
    pub waiting_jobs: i64,
    pub running_jobs: i64,
    pub submissions_per_minute: i64,
    pub micro_usd_per_month: i64,
    pub batch_requests: i64,
}

impl TenantLimits {
    /// Limits of the settings, with the exceptions in a row.
    fn new(settings: &LimitSettings, row: Option<&AnyRow>) -> Result<Self, StoreError> {
        let value = |limit: Limit, usual: i64| -> Result<i64, StoreError> {
            let exception: Option<i64> = match row {
                Some(row) => row.try_get(limit.column())?,
                None => None,
            };
            Ok(exception.unwrap_or(usual))
        };
        Ok(Self {
            bytes: value(Limit::Bytes, settings.bytes)?,
            waiting_jobs: value(Limit::WaitingJobs, settings.waiting_jobs)?,
            running_jobs: value(Limit::RunningJobs, settings.running_jobs)?,
            submissions_per_minute: value(Limit::SubmissionsPerMinute, settings.submissions_per_minute)?,
            micro_usd_per_month: value(Limit::UsdPerMonth, MicroUsd::of_usd(settings.usd_per_month).0)?,
            batch_requests: value(Limit::BatchRequests, settings.batch_requests)?,
        })
    }

    /// The value of a limit.
    pub fn get(&self, limit: Limit) -> i64 {
        match limit {
            Limit::Bytes => self.bytes,
            Limit::WaitingJobs | Limit::AllWaitingScenes => self.waiting_jobs,
            Limit::RunningJobs => self.running_jobs,
            Limit::SubmissionsPerMinute => self.submissions_per_minute,
            Limit::UsdPerMonth => self.micro_usd_per_month,
            Limit::BatchRequests => self.batch_requests,
        }
    }
}

/// The limits of a tenant now.
pub(crate) async fn of_tenant(
    connection: &mut AnyConnection,
    settings: &LimitSettings,
    tenant_id: &TenantId,
) -> Result<TenantLimits, StoreError> {
    let row = sqlx::query("SELECT * FROM tenant_limits WHERE tenant_id = $1")
        .bind(tenant_id.as_str())
        .fetch_optional(connection)
        .await?;
    TenantLimits::new(settings, row.as_ref())
}

/// Lets transactions of one name follow each other until their ends. SQLite has one writer, so nothing is needed.
pub(crate) async fn one_at_a_time(connection: &mut AnyConnection, name: &str) -> Result<(), StoreError> {
    if Dialect::of(connection) == Dialect::Postgres {
        // The driver knows no values of type void.
        sqlx::query("SELECT CAST(pg_advisory_xact_lock(hashtextextended($1, 0)) AS TEXT)")
            .bind(name)
            .fetch_one(connection)
            .await?;
    }
    Ok(())
}

/// As [`one_at_a_time`], but `false` where another transaction has the name.
pub(crate) async fn is_alone(connection: &mut AnyConnection, name: &str) -> Result<bool, StoreError> {
    match Dialect::of(connection) {
        Dialect::Sqlite => Ok(true),
        Dialect::Postgres => {
            Ok(sqlx::query_scalar("SELECT pg_try_advisory_xact_lock(hashtextextended($1, 0))")
                .bind(name)
                .fetch_one(connection)
                .await?)
        }
    }
}

/// Name of the transactions that make work of a tenant.
pub(crate) fn submissions_of(tenant_id: &TenantId) -> String {
    format!("submissions {tenant_id}")
}
