//! Reading jobs and their stages, and making a new job out of an old one.

use sqlx::sqlite::SqliteRow;
use sqlx::{Row, SqliteConnection};

use super::{Store, StoreError, database, scenes};
use scene::job::{JobState, SceneState};

/// A job's row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JobRow {
    pub id: String,
    pub kind: String,
    pub scene_id: Option<String>,
    pub retry_of: Option<String>,
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
    /// Found, not computed, the last time the job passed here.
    pub cached: bool,
    /// How often this job started computing it.
    pub runs: i64,
    /// How long computing it took, whoever did it.
    pub elapsed_ms: Option<i64>,
    /// Milliseconds since 1970.
    pub started_at_ms: i64,
}

/// What came of asking for a job to be tried again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Retried {
    Created {
        job_id: String,
        scene_id: String,
    },
    NotFound,
    /// The scene has a job that is still going.
    StillActive,
    /// The scene is ready (a download never changes under its URL) or deleted.
    SceneIs(SceneState),
    /// The job never came to that stage.
    NoSuchStage,
}

impl Store {
    /// A job of the tenant.
    pub async fn job(&self, tenant_id: &str, id: &str) -> Result<Option<JobRow>, StoreError> {
        let row = sqlx::query("SELECT * FROM jobs WHERE id = ? AND tenant_id = ?")
            .bind(id)
            .bind(tenant_id)
            .fetch_optional(&self.readers)
            .await?;
        row.as_ref().map(job_of).transpose()
    }

    /// The newest job of a scene.
    pub async fn latest_job(&self, scene_id: &str) -> Result<Option<JobRow>, StoreError> {
        let row = sqlx::query("SELECT * FROM jobs WHERE scene_id = ? ORDER BY id DESC LIMIT 1")
            .bind(scene_id)
            .fetch_optional(&self.readers)
            .await?;
        row.as_ref().map(job_of).transpose()
    }

    /// A job's stages in the order it came to them.
    pub async fn stages(&self, job_id: &str) -> Result<Vec<StageRow>, StoreError> {
        let rows = sqlx::query("SELECT * FROM stages WHERE job_id = ? ORDER BY started_at, stage, instance")
            .bind(job_id)
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

    /// How many jobs are in each state.
    pub async fn job_counts(&self) -> Result<Vec<(JobState, i64)>, StoreError> {
        // One statement sees one moment: a job that changes its state meanwhile would be counted twice, or not at all.
        let counted: Vec<(String, i64)> = sqlx::query_as("SELECT state, COUNT(*) FROM jobs GROUP BY state")
            .fetch_all(&self.readers)
            .await?;
        let count_of = |state: JobState| {
            counted.iter().find(|(name, _)| name == state.as_str()).map_or(0, |(_, count)| *count)
        };
        Ok(JobState::ALL.into_iter().map(|state| (state, count_of(state))).collect())
    }

    /// A new job for the scene of an ended one. Finished stages are found again, except from
    /// `from_stage` on, where everything is computed anew.
    pub async fn retry(
        &self,
        tenant_id: &str,
        job_id: &str,
        from_stage: Option<String>,
    ) -> Result<Retried, StoreError> {
        let (tenant_id, job_id) = (tenant_id.to_owned(), job_id.to_owned());
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
    tenant_id: String,
    job_id: String,
    from_stage: Option<String>,
) -> Result<Retried, StoreError> {
    let now = database::now_ms(connection).await?;
    let row = sqlx::query("SELECT * FROM jobs WHERE id = ? AND tenant_id = ?")
        .bind(&job_id)
        .bind(&tenant_id)
        .fetch_optional(&mut *connection)
        .await?;
    let Some(row) = row else { return Ok(Retried::NotFound) };
    let Some(scene_id) = row.try_get::<Option<String>, _>("scene_id")? else { return Ok(Retried::NotFound) };
    let scene_state: String = sqlx::query_scalar("SELECT state FROM scenes WHERE id = ?")
        .bind(&scene_id)
        .fetch_one(&mut *connection)
        .await?;
    let active: i64 = sqlx::query_scalar(
        "SELECT COUNT(*) FROM jobs WHERE scene_id = ? AND state IN ('queued', 'running', 'cancelling')",
    )
    .bind(&scene_id)
    .fetch_one(&mut *connection)
    .await?;
    match SceneState::parse(&scene_state) {
        Some(state @ (SceneState::Ready | SceneState::Deleted)) => return Ok(Retried::SceneIs(state)),
        _ if active > 0 => return Ok(Retried::StillActive),
        _ => {}
    }
    if let Some(stage) = &from_stage {
        let known: Option<i64> =
            sqlx::query_scalar("SELECT 1 FROM stages WHERE job_id = ? AND stage = ? LIMIT 1")
                .bind(&job_id)
                .bind(stage)
                .fetch_optional(&mut *connection)
                .await?;
        if known.is_none() {
            return Ok(Retried::NoSuchStage);
        }
    }
    // Without a stage of its own, a retry goes on with the salt of the job it retries.
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
    .bind(&scene_id)
    .execute(&mut *connection)
    .await?;
    Ok(Retried::Created { job_id: new_id, scene_id })
}

fn job_of(row: &SqliteRow) -> Result<JobRow, StoreError> {
    let state: String = row.try_get("state")?;
    Ok(JobRow {
        id: row.try_get("id")?,
        kind: row.try_get("kind")?,
        scene_id: row.try_get("scene_id")?,
        retry_of: row.try_get("retry_of")?,
        from_stage: row.try_get("from_stage")?,
        state: JobState::parse(&state)
            .ok_or_else(|| StoreError::Corrupt { table: "jobs", reason: format!("state {state}") })?,
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
