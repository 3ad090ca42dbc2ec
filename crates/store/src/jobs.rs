//! Queries of jobs and their stages, and the retry of a job.

use sqlx::sqlite::SqliteRow;
use sqlx::{Row, SqliteConnection};

use super::{Store, StoreError, database, scenes};
use scene::job::{JobKind, JobState, SceneState};
use scene::{JobId, SceneId, TenantId};

/// A job's row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JobRow {
    pub id: JobId,
    pub kind: JobKind,
    pub scene_id: Option<SceneId>,
    pub retry_of: Option<JobId>,
    pub from_stage: Option<String>,
    pub state: JobState,
    /// Claims since the last new checkpoint.
    pub attempt: i64,
    pub epoch: i64,
    pub failure_class: Option<String>,
    pub failure_code: Option<String>,
    pub failure_message: Option<String>,
    /// Milliseconds since 1970.
    pub created_at_ms: i64,
    pub started_at_ms: Option<i64>,
    pub finished_at_ms: Option<i64>,
}

/// One stage of one job (for one instance, where the stage works on instances).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StageRow {
    pub stage: String,
    /// Empty for the whole scene.
    pub instance: String,
    /// `running` or `finished`.
    pub state: String,
    /// The result came from a checkpoint the last time the job reached the stage.
    pub cached: bool,
    /// Number of times this job started to compute it.
    pub runs: i64,
    /// Duration of the computation, by this or an earlier job.
    pub elapsed_ms: Option<i64>,
    /// Milliseconds since 1970.
    pub started_at_ms: i64,
}

/// Result of a retry request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RetryOutcome {
    Created {
        job_id: JobId,
        scene_id: SceneId,
    },
    NotFound,
    /// The scene has an active job.
    StillActive,
    /// The scene is ready (its bundle is immutable) or deleted.
    SceneIs(SceneState),
    /// The job did not reach that stage.
    NoSuchStage,
}

impl Store {
    /// A job of the tenant.
    pub async fn job(&self, tenant_id: &TenantId, id: &JobId) -> Result<Option<JobRow>, StoreError> {
        let row = sqlx::query("SELECT * FROM jobs WHERE id = ? AND tenant_id = ?")
            .bind(id.as_str())
            .bind(tenant_id.as_str())
            .fetch_optional(&self.readers)
            .await?;
        row.as_ref().map(job_of).transpose()
    }

    /// The newest job of a scene.
    pub async fn latest_job(
        &self,
        tenant_id: &TenantId,
        scene_id: &SceneId,
    ) -> Result<Option<JobRow>, StoreError> {
        let row =
            sqlx::query("SELECT * FROM jobs WHERE scene_id = ? AND tenant_id = ? ORDER BY id DESC LIMIT 1")
                .bind(scene_id.as_str())
                .bind(tenant_id.as_str())
                .fetch_optional(&self.readers)
                .await?;
        row.as_ref().map(job_of).transpose()
    }

    /// The stages of a job in order of their start.
    pub async fn stages(&self, tenant_id: &TenantId, job_id: &JobId) -> Result<Vec<StageRow>, StoreError> {
        let rows = sqlx::query(
            "SELECT * FROM stages
             WHERE job_id = ? AND (SELECT tenant_id FROM jobs WHERE id = stages.job_id) = ?
             ORDER BY started_at, stage, instance",
        )
        .bind(job_id.as_str())
        .bind(tenant_id.as_str())
        .fetch_all(&self.readers)
        .await?;
        rows.iter()
            .map(|row| {
                Ok(StageRow {
                    stage: row.try_get("stage")?,
                    instance: row.try_get("instance")?,
                    state: row.try_get("state")?,
                    cached: row.try_get("cached")?,
                    runs: row.try_get("runs")?,
                    elapsed_ms: row.try_get("elapsed_ms")?,
                    started_at_ms: row.try_get("started_at")?,
                })
            })
            .collect()
    }

    /// Number of jobs per state, for all tenants.
    pub async fn job_counts(&self) -> Result<Vec<(JobState, i64)>, StoreError> {
        // A single statement reads one snapshot; with several, a job that changes its state could be counted twice.
        let counted: Vec<(String, i64)> = sqlx::query_as("SELECT state, COUNT(*) FROM jobs GROUP BY state")
            .fetch_all(&self.readers)
            .await?;
        let count_of = |state: JobState| {
            counted.iter().find(|(name, _)| name == state.as_str()).map_or(0, |(_, count)| *count)
        };
        Ok(JobState::ALL.into_iter().map(|state| (state, count_of(state))).collect())
    }

    /// Creates a new job for the scene of an ended job. Finished stages are reused, except from `from_stage` on.
    pub async fn retry(
        &self,
        tenant_id: &TenantId,
        job_id: &JobId,
        from_stage: Option<String>,
    ) -> Result<RetryOutcome, StoreError> {
        let (tenant_id, job_id) = (tenant_id.clone(), job_id.clone());
        let retried = self
            .writer
            .write("retry a job", move |connection| {
                Box::pin(retry(connection, tenant_id, job_id, from_stage))
            })
            .await?;
        self.announce();
        Ok(retried)
    }
}

async fn retry(
    connection: &mut SqliteConnection,
    tenant_id: TenantId,
    job_id: JobId,
    from_stage: Option<String>,
) -> Result<RetryOutcome, StoreError> {
    let now = database::now_ms(connection).await?;
    let row = sqlx::query("SELECT * FROM jobs WHERE id = ? AND tenant_id = ?")
        .bind(job_id.as_str())
        .bind(tenant_id.as_str())
        .fetch_optional(&mut *connection)
        .await?;
    let Some(row) = row else { return Ok(RetryOutcome::NotFound) };
    let Some(scene_id) = database::optional_id::<SceneId>(&row, "jobs", "scene_id")? else {
        return Ok(RetryOutcome::NotFound);
    };
    let scene_state: String = sqlx::query_scalar("SELECT state FROM scenes WHERE id = ?")
        .bind(scene_id.as_str())
        .fetch_one(&mut *connection)
        .await?;
    let active: i64 = sqlx::query_scalar(
        "SELECT COUNT(*) FROM jobs WHERE scene_id = ? AND state IN ('queued', 'running', 'cancelling')",
    )
    .bind(scene_id.as_str())
    .fetch_one(&mut *connection)
    .await?;
    match SceneState::parse(&scene_state) {
        Some(state @ (SceneState::Ready | SceneState::Deleted)) => return Ok(RetryOutcome::SceneIs(state)),
        _ if active > 0 => return Ok(RetryOutcome::StillActive),
        _ => {}
    }
    if let Some(stage) = &from_stage {
        let known: Option<i64> =
            sqlx::query_scalar("SELECT 1 FROM stages WHERE job_id = ? AND stage = ? LIMIT 1")
                .bind(job_id.as_str())
                .bind(stage)
                .fetch_optional(&mut *connection)
                .await?;
        if known.is_none() {
            return Ok(RetryOutcome::NoSuchStage);
        }
    }
    // Without its own stage, a retry uses the salt of the job it retries.
    let (old_stage, old_salt): (Option<String>, Option<String>) =
        (row.try_get("from_stage")?, row.try_get("salt")?);
    let salt = match (&from_stage, &old_stage, &old_salt) {
        (Some(stage), _, _) => Some((stage.as_str(), "")),
        (None, Some(stage), Some(salt)) => Some((stage.as_str(), salt.as_str())),
        _ => None,
    };
    let new_id = scenes::insert_job(connection, &tenant_id, &scene_id, Some(&job_id), salt, now).await?;
    sqlx::query(
        "UPDATE scenes SET state = 'pending', failure_code = NULL, failure_message = NULL, verdict = NULL,
                           updated_at = ? WHERE id = ?",
    )
    .bind(now)
    .bind(scene_id.as_str())
    .execute(&mut *connection)
    .await?;
    Ok(RetryOutcome::Created { job_id: new_id, scene_id })
}

fn job_of(row: &SqliteRow) -> Result<JobRow, StoreError> {
    let (kind, state): (String, String) = (row.try_get("kind")?, row.try_get("state")?);
    let corrupt = |reason: String| StoreError::Corrupt { table: "jobs", reason };
    Ok(JobRow {
        id: database::id(row, "jobs", "id")?,
        kind: JobKind::parse(&kind).ok_or_else(|| corrupt(format!("kind {kind}")))?,
        scene_id: database::optional_id(row, "jobs", "scene_id")?,
        retry_of: database::optional_id(row, "jobs", "retry_of")?,
        from_stage: row.try_get("from_stage")?,
        state: JobState::parse(&state).ok_or_else(|| corrupt(format!("state {state}")))?,
        attempt: row.try_get("attempt")?,
        epoch: row.try_get("epoch")?,
        failure_class: row.try_get("failure_class")?,
        failure_code: row.try_get("failure_code")?,
        failure_message: row.try_get("failure_message")?,
        created_at_ms: row.try_get("created_at")?,
        started_at_ms: row.try_get("started_at")?,
        finished_at_ms: row.try_get("finished_at")?,
    })
}
