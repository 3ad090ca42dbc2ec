//! Choice of the next job that a worker may claim.
//!
//! Tenants take turns: the one with the fewest active jobs comes first, then the one that was served the longest time
//! ago. Within a tenant, ranks decide (see `schedule`). Jobs whose kind or request version this program does not know
//! are left to newer workers, so that versions can work side by side. A tenant that has as many active jobs as it may
//! waits for one of them to end (`store.limits.running_jobs`); only a worker for one stated job is not held back.
//!
//! A job whose process died twice since its last new checkpoint runs alone (see [`crate::deaths`]).

use sqlx::{AnyConnection, AssertSqlSafe, Row};

use crate::database::Dialect;
use crate::deaths::IS_SUSPECT;
use crate::lifecycle::JobKind;
use crate::{StoreError, database, deaths, limits};
use scene::{JobId, SceneRequest};

/// The jobs that a worker claims.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Scope {
    /// Jobs of these kinds, in their turn.
    Kinds(Vec<JobKind>),
    /// One job, whatever its turn, and also while claiming is paused.
    Job(JobId),
}

impl Scope {
    /// Jobs of every kind.
    pub fn all() -> Self {
        Self::Kinds(JobKind::ALL.to_vec())
    }

    /// The one job, if there is one.
    pub(super) fn job(&self) -> Option<&JobId> {
        match self {
            Self::Kinds(_) => None,
            Self::Job(id) => Some(id),
        }
    }

    /// The condition on the kind of a job.
    pub(super) fn kinds(&self) -> String {
        let kinds: &[JobKind] = match self {
            Self::Kinds(kinds) => kinds,
            Self::Job(_) => &JobKind::ALL,
        };
        let kinds: Vec<String> = kinds.iter().map(|kind| format!("'{}'", kind.as_str())).collect();
        format!("kind IN ({})", kinds.join(", "))
    }

    /// The condition on jobs that may be claimed at `$1`, with requests of at most the version `$2`. A job with a key
    /// waits for an earlier one with the same key.
    fn condition(&self) -> String {
        format!(
            "state = 'queued' AND not_before <= $1 AND request_version <= $2 AND {}
             AND (deadline_at IS NULL OR deadline_at > $1)
             AND (exclusive_key IS NULL OR NOT EXISTS (
                 SELECT 1 FROM jobs AS other
                 WHERE other.tenant_id = jobs.tenant_id AND other.exclusive_key = jobs.exclusive_key
                   AND other.id <> jobs.id AND other.state IN ('queued', 'running', 'cancelling')
                   AND (other.state <> 'queued' OR other.id < jobs.id)))",
            self.kinds()
        )
    }
}

/// The next job for `owner`, locked. `usual_running` is the limit of active jobs of a tenant without its own; 0 is
/// none.
pub(super) async fn next_job(
    connection: &mut AnyConnection,
    owner: &str,
    scope: &Scope,
    usual_running: i64,
    now_ms: i64,
) -> Result<Option<JobId>, StoreError> {
    if let Some(job_id) = scope.job() {
        return stated_job(connection, scope, job_id, now_ms).await;
    }
    if is_paused(connection).await? {
        return Ok(None);
    }
    let hands = deaths::hands(connection, owner, now_ms).await?;
    if hands.are_bound {
        return Ok(None);
    }
    if let Some(suspect) = suspect(connection, scope, usual_running, now_ms).await? {
        if hands.are_empty {
            return Ok(Some(suspect));
        }
        if deaths::reserve(connection, &suspect, owner, now_ms).await? {
            return Ok(None);
        }
    }
    if hands.keep_free {
        return Ok(None);
    }
    for Waiting { tenant, max_active } in waiting_tenants(connection, usual_running).await? {
        if max_active > 0 && !has_room(connection, &tenant, max_active).await? {
            continue;
        }
        if let Some(job_id) = first_of(connection, scope, &tenant, now_ms).await? {
            return Ok(Some(job_id));
        }
    }
    Ok(None)
}

/// Whether a tenant may have another active job. Claims for one tenant exclude each other until their ends, so that
/// two at once do not exceed its limit; the second leaves the tenant to the first, whose end wakes its worker.
async fn has_room(connection: &mut AnyConnection, tenant: &str, max_active: i64) -> Result<bool, StoreError> {
    if !limits::is_alone(connection, &format!("claims {tenant}")).await? {
        return Ok(false);
    }
    let active: i64 = sqlx::query_scalar(
        "SELECT COUNT(*) FROM jobs WHERE tenant_id = $1 AND state IN ('running', 'cancelling')",
    )
    .bind(tenant)
    .fetch_one(connection)
    .await?;
    Ok(active < max_active)
}

/// Whether an operator has paused claiming, of every kind of work.
pub(crate) async fn is_paused(connection: &mut AnyConnection) -> Result<bool, StoreError> {
    let value: Option<String> = sqlx::query_scalar("SELECT value FROM switches WHERE name = 'claiming'")
        .fetch_optional(connection)
        .await?;
    Ok(value.as_deref() == Some("paused"))
}

/// The first job that has to run alone, locked. Jobs of a tenant with as many active ones as it may have wait.
async fn suspect(
    connection: &mut AnyConnection,
    scope: &Scope,
    usual_running: i64,
    now_ms: i64,
) -> Result<Option<JobId>, StoreError> {
    let lock = Dialect::of(connection).lock_free_rows();
    let query = format!(
        "SELECT id FROM jobs
         WHERE {} AND {IS_SUSPECT}
           AND (SELECT COUNT(*) FROM jobs AS held
                WHERE held.tenant_id = jobs.tenant_id AND held.state IN ('running', 'cancelling'))
               < (SELECT CASE WHEN max_active > 0 THEN max_active ELSE {} END
                  FROM (SELECT COALESCE((SELECT running_jobs FROM tenant_limits
                                         WHERE tenant_limits.tenant_id = jobs.tenant_id), $3) AS max_active) AS own)
         ORDER BY COALESCE(rank_at, created_at), id LIMIT 1 {lock}",
        scope.condition(),
        i64::MAX
    );
    let id: Option<String> = sqlx::query_scalar(AssertSqlSafe(query))
        .bind(now_ms)
        .bind(i64::from(SceneRequest::VERSION))
        .bind(usual_running)
        .fetch_optional(connection)
        .await?;
    id.map(|id| database::parse_id(&id, "jobs")).transpose()
}

/// A tenant with waiting jobs.
struct Waiting {
    tenant: String,
    /// Active jobs that it may have; 0 = any number.
    max_active: i64,
}

/// Tenants with waiting jobs that have not all the active jobs that they may have, in the order of their turns.
async fn waiting_tenants(
    connection: &mut AnyConnection,
    usual_running: i64,
) -> Result<Vec<Waiting>, StoreError> {
    // The recursion visits each tenant once instead of each waiting job.
    let rows = sqlx::query(
        "WITH RECURSIVE waiting (tenant_id) AS (
             SELECT MIN(tenant_id) FROM jobs WHERE state = 'queued'
             UNION ALL
             SELECT (SELECT MIN(later.tenant_id) FROM jobs AS later
                     WHERE later.state = 'queued' AND later.tenant_id > waiting.tenant_id)
             FROM waiting WHERE waiting.tenant_id IS NOT NULL
         ), active (tenant_id, jobs) AS (
             SELECT tenant_id, COUNT(*) FROM jobs WHERE state IN ('running', 'cancelling') GROUP BY tenant_id
         ), limited (tenant_id, jobs, max_active) AS (
             SELECT waiting.tenant_id, COALESCE(active.jobs, 0),
                    COALESCE((SELECT running_jobs FROM tenant_limits
                              WHERE tenant_limits.tenant_id = waiting.tenant_id), $1)
             FROM waiting LEFT JOIN active ON active.tenant_id = waiting.tenant_id
             WHERE waiting.tenant_id IS NOT NULL
         )
         SELECT limited.tenant_id AS tenant_id, limited.max_active AS max_active, limited.jobs AS jobs,
                COALESCE((SELECT MAX(claimed_at) FROM jobs AS past
                          WHERE past.tenant_id = limited.tenant_id), 0) AS served_at
         FROM limited WHERE limited.max_active = 0 OR limited.jobs < limited.max_active
         ORDER BY jobs, served_at, tenant_id",
    )
    .bind(usual_running)
    .fetch_all(connection)
    .await?;
    rows.iter()
        .map(|row| Ok(Waiting { tenant: row.try_get("tenant_id")?, max_active: row.try_get("max_active")? }))
        .collect()
}

/// The first job of a tenant that need not run alone.
async fn first_of(
    connection: &mut AnyConnection,
    scope: &Scope,
    tenant: &str,
    now_ms: i64,
) -> Result<Option<JobId>, StoreError> {
    let lock = Dialect::of(connection).lock_free_rows();
    let query = format!(
        "SELECT id FROM jobs
         WHERE {} AND tenant_id = $3 AND shared_deaths + lone_deaths < 2
         ORDER BY COALESCE(rank_at, created_at), id LIMIT 1 {lock}",
        scope.condition()
    );
    let id: Option<String> = sqlx::query_scalar(AssertSqlSafe(query))
        .bind(now_ms)
        .bind(i64::from(SceneRequest::VERSION))
        .bind(tenant)
        .fetch_optional(connection)
        .await?;
    id.map(|id| database::parse_id(&id, "jobs")).transpose()
}

/// The job itself, if it waits and its time has come.
async fn stated_job(
    connection: &mut AnyConnection,
    scope: &Scope,
    job_id: &JobId,
    now_ms: i64,
) -> Result<Option<JobId>, StoreError> {
    let lock = Dialect::of(connection).lock_free_rows();
    let query = format!("SELECT id FROM jobs WHERE {} AND id = $3 {lock}", scope.condition());
    let id: Option<String> = sqlx::query_scalar(AssertSqlSafe(query))
        .bind(now_ms)
        .bind(i64::from(SceneRequest::VERSION))
        .bind(job_id.as_str())
        .fetch_optional(connection)
        .await?;
    id.map(|id| database::parse_id(&id, "jobs")).transpose()
}
