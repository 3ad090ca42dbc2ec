//! Work that waits and work in progress, of one tenant or of all: for those who watch a server.

use std::collections::BTreeMap;

use sqlx::any::AnyRow;
use sqlx::{AssertSqlSafe, Row};

use super::switch::Pause;
use crate::lifecycle::JobKind;
use crate::{Store, StoreError, boxed, database};
use scene::{DatasetId, JobId, RecordingId, SceneId, TenantId};

/// Jobs in progress that are read at most.
const MAX_ACTIVE: usize = 1_000;

/// Work at one moment.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct QueueOverview {
    /// `None` = workers claim jobs.
    pub paused: Option<Pause>,
    /// Jobs by kind, those for a later time included; kinds without jobs are left out.
    pub waiting: BTreeMap<JobKind, i64>,
    /// Jobs in progress, those that began first in front.
    pub active: Vec<ActiveJob>,
}

/// A job that a worker holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ActiveJob {
    pub id: JobId,
    pub kind: JobKind,
    /// Name of the worker.
    pub owner: String,
    pub scene_id: Option<SceneId>,
    pub dataset_id: Option<DatasetId>,
    pub recording_id: Option<RecordingId>,
    /// Time of the newest claim of the job, milliseconds since 1970.
    pub claimed_at_ms: i64,
}

impl Store {
    /// Work of a tenant, or of all tenants.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if the database does not answer, or a row cannot be read.
    #[boxed]
    pub async fn queue_overview(&self, tenant_id: Option<&TenantId>) -> Result<QueueOverview, StoreError> {
        let switch = sqlx::query(
            "SELECT reason, changed_at FROM switches WHERE name = 'claiming' AND value = 'paused'",
        )
        .fetch_optional(&self.readers)
        .await?;
        let paused = match switch {
            Some(row) => Some(Pause { reason: row.try_get("reason")?, since_ms: row.try_get("changed_at")? }),
            None => None,
        };
        let of_tenant = if tenant_id.is_some() { "AND tenant_id = $1" } else { "" };
        let mut waiting = BTreeMap::new();
        for kind in JobKind::ALL {
            // A kind at a time, by the index of waiting jobs.
            let query = format!(
                "SELECT COUNT(*) FROM jobs WHERE state = 'queued' AND kind = '{}' {of_tenant}",
                kind.as_str()
            );
            let query = sqlx::query_scalar(AssertSqlSafe(query));
            let query = match tenant_id {
                Some(tenant_id) => query.bind(tenant_id.as_str()),
                None => query,
            };
            let jobs: i64 = query.fetch_one(&self.readers).await?;
            if jobs > 0 {
                waiting.insert(kind, jobs);
            }
        }
        let query = format!(
            "SELECT id, kind, owner, scene_id, dataset_id, recording_id, claimed_at FROM jobs
             WHERE state IN ('running', 'cancelling') {of_tenant} LIMIT {MAX_ACTIVE}"
        );
        let query = sqlx::query(AssertSqlSafe(query));
        let query = match tenant_id {
            Some(tenant_id) => query.bind(tenant_id.as_str()),
            None => query,
        };
        let rows = query.fetch_all(&self.readers).await?;
        let mut active = rows.iter().map(active_job).collect::<Result<Vec<_>, _>>()?;
        active.sort_by(|one, other| (one.claimed_at_ms, &one.id).cmp(&(other.claimed_at_ms, &other.id)));
        Ok(QueueOverview { paused, waiting, active })
    }
}

fn active_job(row: &AnyRow) -> Result<ActiveJob, StoreError> {
    let kind: String = row.try_get("kind")?;
    let corrupt = || StoreError::Corrupt { table: "jobs", reason: format!("kind {kind}") };
    Ok(ActiveJob {
        id: database::id(row, "jobs", "id")?,
        kind: JobKind::parse(&kind).ok_or_else(corrupt)?,
        owner: row.try_get::<Option<String>, _>("owner")?.unwrap_or_default(),
        scene_id: database::optional_id(row, "jobs", "scene_id")?,
        dataset_id: database::optional_id(row, "jobs", "dataset_id")?,
        recording_id: database::optional_id(row, "jobs", "recording_id")?,
        claimed_at_ms: row.try_get::<Option<i64>, _>("claimed_at")?.unwrap_or_default(),
    })
}
