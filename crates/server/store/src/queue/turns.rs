//! Choice of the next job that a worker may claim.
//!
//! Tenants take turns: the one with the fewest active jobs comes first, then the one that was served the longest time
//! ago. Within a tenant, ranks decide (see `schedule`). Jobs whose kind or request version this program does not know
//! are left to newer workers, so that versions can work side by side.
//!
//! A job whose process died twice since its last new checkpoint runs alone (see [`crate::deaths`]).

use sqlx::{AnyConnection, AssertSqlSafe, Row};

use crate::database::Dialect;
use crate::deaths::IS_SUSPECT;
use crate::lifecycle::JobKind;
use crate::{StoreError, database, deaths};
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

/// The next job for `owner`, locked.
pub(super) async fn next_job(
    connection: &mut AnyConnection,
    owner: &str,
    scope: &Scope,
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
    if let Some(suspect) = suspect(connection, scope, now_ms).await? {
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
    for tenant in waiting_tenants(connection).await? {
        if let Some(job_id) = first_of(connection, scope, &tenant, now_ms).await? {
            return Ok(Some(job_id));
        }
    }
    Ok(None)
}

/// Whether an operator has paused claiming, of every kind of work.
pub(crate) async fn is_paused(connection: &mut AnyConnection) -> Result<bool, StoreError> {
    let value: Option<String> = sqlx::query_scalar("SELECT value FROM switches WHERE name = 'claiming'")
        .fetch_optional(connection)
        .await?;
    Ok(value.as_deref() == Some("paused"))
}

/// The first job that has to run alone, locked.
async fn suspect(
    connection: &mut AnyConnection,
    scope: &Scope,
    now_ms: i64,
) -> Result<Option<JobId>, StoreError> {
    let lock = Dialect::of(connection).lock_free_rows();
    let query = format!(
        "SELECT id FROM jobs
         WHERE {} AND {IS_SUSPECT}
         ORDER BY COALESCE(rank_at, created_at), id LIMIT 1 {lock}",
        scope.condition()
    );
    let id: Option<String> = sqlx::query_scalar(AssertSqlSafe(query))
        .bind(now_ms)
        .bind(i64::from(SceneRequest::VERSION))
        .fetch_optional(connection)
        .await?;
    id.map(|id| database::parse_id(&id, "jobs")).transpose()
}

/// Tenants with waiting jobs, in the order of their turns.
async fn waiting_tenants(connection: &mut AnyConnection) -> Result<Vec<String>, StoreError> {
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
         )
         SELECT waiting.tenant_id AS tenant_id, COALESCE(active.jobs, 0) AS jobs,
                COALESCE((SELECT MAX(claimed_at) FROM jobs AS past
                          WHERE past.tenant_id = waiting.tenant_id), 0) AS served_at
         FROM waiting LEFT JOIN active ON active.tenant_id = waiting.tenant_id
         WHERE waiting.tenant_id IS NOT NULL
         ORDER BY jobs, served_at, tenant_id",
    )
    .fetch_all(connection)
    .await?;
    rows.iter().map(|row| Ok(row.try_get("tenant_id")?)).collect()
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
