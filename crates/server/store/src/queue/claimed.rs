//! Claimed work: a job of any kind with what its worker needs, and the lease that guards every write about it.

use std::time::Duration;

use serde_json::{Value, json};
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, Row};

use super::{Lease, Scope, milliseconds, move_job, rescue, turns};
use crate::datasets::{self, DatasetRow};
use crate::executions::{self, ExecutionRow};
use crate::lifecycle::{JobEvent, JobKind};
use crate::recordings::{self, AttemptWork, RecordingRow};
use crate::{StoreError, database, events};
use scene::{DatasetId, JobId, SceneId, TenantId};

/// A claimed job.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    pub lease: Lease,
    pub tenant_id: TenantId,
    pub work: ClaimedWork,
    /// Claims since the last progress, this one included.
    pub attempt: i64,
    /// Time until the job's deadline.
    pub time_left: Option<Duration>,
}

/// The work of a claimed job.
#[derive(Clone, Debug, PartialEq)]
pub enum ClaimedWork {
    /// [`JobKind::Generate`] and [`JobKind::Retry`].
    BuildScene(SceneWork),
    FreezeDataset(Box<DatasetRow>),
    VerifyDataset(Box<DatasetRow>),
    RecordAttempt(Box<AttemptWork>),
    AssembleRecording(Box<RecordingRow>),
    ExecuteTask(Box<ExecutionRow>),
}

/// A scene to be built.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneWork {
    pub scene_id: SceneId,
    /// The scene's request, as JSON.
    pub request: Value,
    /// Stage and salt: checkpoint keys are salted from this stage on.
    pub salt: Option<(String, String)>,
}

impl ClaimedWork {
    /// The kind of its job; a repeated scene counts as a new one.
    pub fn kind(&self) -> JobKind {
        match self {
            Self::BuildScene(_) => JobKind::Generate,
            Self::FreezeDataset(_) => JobKind::FreezeDataset,
            Self::VerifyDataset(_) => JobKind::VerifyDataset,
            Self::RecordAttempt(_) => JobKind::RecordAttempt,
            Self::AssembleRecording(_) => JobKind::AssembleRecording,
            Self::ExecuteTask(_) => JobKind::ExecuteTask,
        }
    }
}

impl Claim {
    /// The scene to be built; `None` for work of another kind.
    pub fn scene(&self) -> Option<&SceneWork> {
        match &self.work {
            ClaimedWork::BuildScene(scene) => Some(scene),
            _ => None,
        }
    }
}

/// Claims the job whose turn it is, after jobs of dead workers have returned to the queue.
pub(super) async fn claim(
    connection: &mut AnyConnection,
    owner: String,
    lease: Duration,
    max_deaths: i64,
    scope: Scope,
    usual_running: i64,
) -> Result<Option<Claim>, StoreError> {
    let now = database::now_ms(connection).await?;
    rescue::rescue(connection, max_deaths, scope.job(), now).await?;
    let Some(job_id) = turns::next_job(connection, &owner, &scope, usual_running, now).await? else {
        return Ok(None);
    };
    move_job(connection, &job_id, JobEvent::Claimed, now).await?;
    let row = sqlx::query(
        "UPDATE jobs SET owner = $1, epoch = epoch + 1, attempt = attempt + 1, lease_until = $2,
                         started_at = COALESCE(started_at, $3), claimed_at = $3, was_beside = 0, reserved_by = NULL
         WHERE id = $4
         RETURNING id, kind, tenant_id, scene_id, dataset_id, epoch, attempt, from_stage, salt, deadline_at",
    )
    .bind(&owner)
    .bind(now + milliseconds(lease))
    .bind(now)
    .bind(job_id.as_str())
    .fetch_one(&mut *connection)
    .await?;
    let attempt: i64 = row.try_get("attempt")?;
    let epoch: i64 = row.try_get("epoch")?;
    let started = json!({ "attempt": attempt, "epoch": epoch });
    events::append(connection, &job_id, now, "job_started", &started).await?;
    let deadline_at: Option<i64> = row.try_get("deadline_at")?;
    let time_left = |deadline_at: i64| Duration::from_millis(u64::try_from(deadline_at - now).unwrap_or(0));
    Ok(Some(Claim {
        tenant_id: database::id(&row, "jobs", "tenant_id")?,
        work: work(connection, &row, now).await?,
        lease: Lease { job_id, owner, epoch },
        attempt,
        time_left: deadline_at.map(time_left),
    }))
}

/// The work of the job in a row.
async fn work(connection: &mut AnyConnection, job: &AnyRow, now_ms: i64) -> Result<ClaimedWork, StoreError> {
    let kind: String = job.try_get("kind")?;
    let corrupt = |reason| StoreError::Corrupt { table: "jobs", reason };
    let kind = JobKind::parse(&kind).ok_or_else(|| corrupt(format!("kind {kind}")))?;
    match kind {
        JobKind::Generate | JobKind::Retry => Ok(ClaimedWork::BuildScene(scene_work(connection, job).await?)),
        JobKind::FreezeDataset | JobKind::VerifyDataset => {
            let id: DatasetId = database::id(job, "jobs", "dataset_id")?;
            let dataset = Box::new(datasets::begun(connection, &id).await?);
            Ok(match kind {
                JobKind::FreezeDataset => ClaimedWork::FreezeDataset(dataset),
                _ => ClaimedWork::VerifyDataset(dataset),
            })
        }
        JobKind::ExecuteTask => {
            let id: JobId = database::id(job, "jobs", "id")?;
            Ok(ClaimedWork::ExecuteTask(Box::new(executions::begun(connection, &id).await?)))
        }
        JobKind::RecordAttempt | JobKind::AssembleRecording => {
            let id: JobId = database::id(job, "jobs", "id")?;
            let (recording, number) = recordings::begun(connection, &id, now_ms).await?;
            Ok(match number {
                Some(number) => ClaimedWork::RecordAttempt(Box::new(AttemptWork { recording, number })),
                None => ClaimedWork::AssembleRecording(Box::new(recording)),
            })
        }
    }
}

async fn scene_work(connection: &mut AnyConnection, job: &AnyRow) -> Result<SceneWork, StoreError> {
    let scene_id: SceneId = database::id(job, "jobs", "scene_id")?;
    let request: String = sqlx::query_scalar("SELECT request FROM scenes WHERE id = $1")
        .bind(scene_id.as_str())
        .fetch_one(connection)
        .await?;
    let request = serde_json::from_str(&request)
        .map_err(|error| StoreError::Corrupt { table: "scenes", reason: error.to_string() })?;
    let salt = Option::zip(job.try_get("from_stage")?, job.try_get("salt")?);
    Ok(SceneWork { scene_id, request, salt })
}
