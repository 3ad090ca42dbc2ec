//! Queries of jobs and their stages, and the retry of a job.

use sqlx::any::AnyRow;
use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::database::Dialect;
use super::limits::{Admission, LimitReached};
use super::list_query::ListQuery;
use super::queue::{JobSubject, NewJob, QueueColumns};
use super::{Store, StoreError, batches, database, datasets};
use crate::boxed;
use crate::lifecycle::{JobKind, JobState, SceneState};
use scene::{BatchId, DatasetId, JobId, RecordingId, SceneId, TenantId};

/// A job's row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JobRow {
    pub id: JobId,
    pub kind: JobKind,
    pub scene_id: Option<SceneId>,
    pub dataset_id: Option<DatasetId>,
    pub recording_id: Option<RecordingId>,
    /// Of an attempt of a recording.
    pub attempt_number: Option<u64>,
    pub retry_of: Option<JobId>,
    pub from_stage: Option<String>,
    pub state: JobState,
    /// Place among the waiting jobs of the tenant: earlier is claimed first.
    pub rank_at_ms: i64,
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

/// Filter of a job list.
#[derive(Clone, Debug, Default)]
pub struct JobFilter {
    pub state: Option<JobState>,
    pub kind: Option<JobKind>,
    pub scene: Option<SceneId>,
    pub dataset: Option<DatasetId>,
    pub recording: Option<RecordingId>,
    pub batch: Option<BatchId>,
    pub created_after_ms: Option<i64>,
    /// Only jobs older than this id, the last id of the previous page.
    pub before_id: Option<JobId>,
    pub limit: u32,
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
    },
    NotFound,
    /// The scene or the dataset has an active job.
    StillActive,
    /// The dataset has a version or a newer job, or the recording has ended.
    NothingToRepeat,
    /// The scene is ready (its bundle is immutable) or deleted.
    SceneIs(SceneState),
    /// The job did not reach that stage.
    NoSuchStage,
    /// A limit of the tenant leaves no room.
    Refused(LimitReached),
}

impl Store {
    /// A job of the tenant.
    #[boxed]
    pub async fn job(&self, tenant_id: &TenantId, id: &JobId) -> Result<Option<JobRow>, StoreError> {
        let row = sqlx::query("SELECT * FROM jobs WHERE id = $1 AND tenant_id = $2")
            .bind(id.as_str())
            .bind(tenant_id.as_str())
            .fetch_optional(&self.readers)
            .await?;
        row.as_ref().map(job_of).transpose()
    }

    /// Jobs of the tenant, newest first.
    #[boxed]
    pub async fn jobs(&self, tenant_id: &TenantId, filter: JobFilter) -> Result<Vec<JobRow>, StoreError> {
        let list = ListQuery::of(tenant_id)
            .word("state", filter.state.map(JobState::as_str))
            .word("kind", filter.kind.map(JobKind::as_str))
            .text("scene_id =", filter.scene)
            .text("dataset_id =", filter.dataset)
            .text("recording_id =", filter.recording)
            .text("batch_id =", filter.batch)
            .text("id <", filter.before_id)
            .number("created_at >", filter.created_after_ms);
        list.select("jobs", filter.limit).rows(&self.readers).await?.iter().map(job_of).collect()
    }

    /// The newest job of a scene.
    #[boxed]
    pub async fn latest_job(
        &self,
        tenant_id: &TenantId,
        scene_id: &SceneId,
    ) -> Result<Option<JobRow>, StoreError> {
        let row =
            sqlx::query("SELECT * FROM jobs WHERE scene_id = $1 AND tenant_id = $2 ORDER BY id DESC LIMIT 1")
                .bind(scene_id.as_str())
                .bind(tenant_id.as_str())
                .fetch_optional(&self.readers)
                .await?;
        row.as_ref().map(job_of).transpose()
    }

    /// The stages of a job in order of their start.
    #[boxed]
    pub async fn stages(&self, tenant_id: &TenantId, job_id: &JobId) -> Result<Vec<StageRow>, StoreError> {
        let rows = sqlx::query(
            "SELECT * FROM stages
             WHERE job_id = $1 AND (SELECT tenant_id FROM jobs WHERE id = stages.job_id) = $2
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
                    cached: row.try_get::<i64, _>("cached")? != 0,
                    runs: row.try_get("runs")?,
                    elapsed_ms: row.try_get("elapsed_ms")?,
                    started_at_ms: row.try_get("started_at")?,
                })
            })
            .collect()
    }

    /// Number of jobs per state, for all tenants.
    #[boxed]
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

    /// Creates a new job for the scene or the dataset of an ended job. Finished stages are reused, except from
    /// `from_stage` on.
    #[boxed]
    pub async fn retry(
        &self,
        tenant_id: &TenantId,
        job_id: &JobId,
        from_stage: Option<String>,
    ) -> Result<RetryOutcome, StoreError> {
        let (tenant_id, job_id) = (tenant_id.clone(), job_id.clone());
        let admission = self.admission.clone();
        let retried = self
            .writer
            .write("retry a job", move |connection| {
                Box::pin(
                    async move { retry(connection, tenant_id, job_id, from_stage, Some(&admission)).await },
                )
            })
            .await?;
        self.announce();
        Ok(retried)
    }
}

/// Repeats an ended job. With an admission the limits of the tenant are held.
pub(super) async fn retry(
    connection: &mut AnyConnection,
    tenant_id: TenantId,
    job_id: JobId,
    from_stage: Option<String>,
    admission: Option<&Admission>,
) -> Result<RetryOutcome, StoreError> {
    let now = database::now_ms(connection).await?;
    let row = sqlx::query("SELECT * FROM jobs WHERE id = $1 AND tenant_id = $2")
        .bind(job_id.as_str())
        .bind(tenant_id.as_str())
        .fetch_optional(&mut *connection)
        .await?;
    let Some(row) = row else { return Ok(RetryOutcome::NotFound) };
    let Some(scene_id) = database::optional_id::<SceneId>(&row, "jobs", "scene_id")? else {
        let ended = job_of(&row)?;
        return match ended.recording_id {
            // A recording repeats its own jobs until it ends.
            Some(_) => Ok(RetryOutcome::NothingToRepeat),
            None if ended.kind == JobKind::ExecuteTask => Ok(RetryOutcome::NothingToRepeat),
            None if from_stage.is_some() => Ok(RetryOutcome::NoSuchStage),
            None => datasets::retry(connection, &ended, &tenant_id, admission, now).await,
        };
    };
    // The lock keeps another retry of the same scene waiting.
    let lock = Dialect::of(connection).lock();
    let query = AssertSqlSafe(format!("SELECT state FROM scenes WHERE id = $1 {lock}"));
    let scene_state: String =
        sqlx::query_scalar(query).bind(scene_id.as_str()).fetch_one(&mut *connection).await?;
    let active: i64 = sqlx::query_scalar(
        "SELECT COUNT(*) FROM jobs WHERE scene_id = $1 AND state IN ('queued', 'running', 'cancelling')",
    )
    .bind(scene_id.as_str())
    .fetch_one(&mut *connection)
    .await?;
    let newest: String = sqlx::query_scalar("SELECT MAX(id) FROM jobs WHERE scene_id = $1")
        .bind(scene_id.as_str())
        .fetch_one(&mut *connection)
        .await?;
    // A job that was to make the lost bytes of a finished scene again; the scene stays as it is.
    let ended: String = row.try_get("state")?;
    let is_rebuild = newest == job_id.as_str() && ended != "succeeded" && from_stage.is_none();
    match SceneState::parse(&scene_state) {
        Some(SceneState::Ready) if is_rebuild && active == 0 => {}
        Some(state @ (SceneState::Ready | SceneState::Deleted)) => return Ok(RetryOutcome::SceneIs(state)),
        _ if active > 0 => return Ok(RetryOutcome::StillActive),
        _ => {}
    }
    if let Some(stage) = &from_stage {
        let known: Option<i64> =
            sqlx::query_scalar("SELECT 1 FROM stages WHERE job_id = $1 AND stage = $2 LIMIT 1")
                .bind(job_id.as_str())
                .bind(stage)
                .fetch_optional(&mut *connection)
                .await?;
        if known.is_none() {
            return Ok(RetryOutcome::NoSuchStage);
        }
    }
    if let Some(admission) = admission
        && let Err(reached) = admission.work(connection, &tenant_id, now).await?
    {
        return Ok(RetryOutcome::Refused(reached));
    }
    // Without its own stage, a retry uses the salt of the job it retries.
    let (old_stage, old_salt): (Option<String>, Option<String>) =
        (row.try_get("from_stage")?, row.try_get("salt")?);
    let salt = match (&from_stage, &old_stage, &old_salt) {
        (Some(stage), _, _) => Some((stage.as_str(), None)),
        (None, Some(stage), Some(salt)) => Some((stage.as_str(), Some(salt.as_str()))),
        _ => None,
    };
    let columns = QueueColumns::of_retry(connection, &job_id, now).await?;
    let new = NewJob {
        retry_of: Some(&job_id),
        salted_from: salt,
        ..NewJob::new(&tenant_id, JobKind::Retry, JobSubject::Scene(&scene_id), columns)
    };
    let job = new.insert(connection, now).await?;
    sqlx::query(
        "UPDATE scenes SET state = 'pending', stripped_at = NULL, failure_code = NULL, failure_message = NULL,
                           verdict = NULL, updated_at = $1
         WHERE id = $2 AND state <> 'ready'",
    )
    .bind(now)
    .bind(scene_id.as_str())
    .execute(&mut *connection)
    .await?;
    batches::scene_retried(connection, &scene_id, &job.id, now).await?;
    Ok(RetryOutcome::Created { job_id: job.id })
}

/// Columns of [`job_in`] for a query that joins jobs as `j`.
pub(super) const JOINED_COLUMNS: &str = "j.id AS job_id, j.kind AS job_kind, j.scene_id AS job_scene_id, \
     j.dataset_id AS job_dataset_id, \
     j.recording_id AS job_recording_id, j.attempt_number AS job_attempt_number, j.retry_of AS job_retry_of, j.from_stage AS job_from_stage, j.state AS job_state, j.rank_at AS job_rank_at, \
     j.attempt AS job_attempt, j.epoch AS job_epoch, j.failure_class AS job_failure_class, \
     j.failure_code AS job_failure_code, j.failure_message AS job_failure_message, j.created_at AS job_created_at, \
     j.started_at AS job_started_at, j.finished_at AS job_finished_at";

fn job_of(row: &AnyRow) -> Result<JobRow, StoreError> {
    job_in(row, "")
}

/// The job in a row; `prefix` stands before the names of its columns.
pub(super) fn job_in(row: &AnyRow, prefix: &str) -> Result<JobRow, StoreError> {
    let column = |name: &str| format!("{prefix}{name}");
    let text = |name: &str| row.try_get::<Option<String>, _>(column(name).as_str());
    let number = |name: &str| row.try_get::<i64, _>(column(name).as_str());
    let time = |name: &str| row.try_get::<Option<i64>, _>(column(name).as_str());
    let corrupt = |reason: String| StoreError::Corrupt { table: "jobs", reason };
    let (kind, state) = (text("kind")?.unwrap_or_default(), text("state")?.unwrap_or_default());
    Ok(JobRow {
        id: database::id(row, "jobs", &column("id"))?,
        kind: JobKind::parse(&kind).ok_or_else(|| corrupt(format!("kind {kind}")))?,
        scene_id: database::optional_id(row, "jobs", &column("scene_id"))?,
        dataset_id: database::optional_id(row, "jobs", &column("dataset_id"))?,
        recording_id: database::optional_id(row, "jobs", &column("recording_id"))?,
        attempt_number: time("attempt_number")?.and_then(|number| u64::try_from(number).ok()),
        retry_of: database::optional_id(row, "jobs", &column("retry_of"))?,
        from_stage: text("from_stage")?,
        state: JobState::parse(&state).ok_or_else(|| corrupt(format!("state {state}")))?,
        rank_at_ms: time("rank_at")?.map_or_else(|| number("created_at"), Ok)?,
        attempt: number("attempt")?,
        epoch: number("epoch")?,
        failure_class: text("failure_class")?,
        failure_code: text("failure_code")?,
        failure_message: text("failure_message")?,
        created_at_ms: number("created_at")?,
        started_at_ms: time("started_at")?,
        finished_at_ms: time("finished_at")?,
    })
}
