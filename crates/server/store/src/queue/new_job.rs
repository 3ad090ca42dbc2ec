//! New jobs: the one statement that puts work of any kind into the queue.

use serde_json::json;
use sqlx::AnyConnection;
use uuid::Uuid;

use super::QueueColumns;
use crate::jobs::JobRow;
use crate::lifecycle::{JobKind, JobState};
use crate::{StoreError, database, events};
use scene::{DatasetId, JobId, RecordingId, SceneId, TenantId};

/// The object of a job: the row that it makes or examines.
#[derive(Clone, Copy, Debug)]
pub(crate) enum JobSubject<'a> {
    Scene(&'a SceneId),
    Dataset(&'a DatasetId),
    /// With the number of the attempt.
    Recording(&'a RecordingId, Option<u64>),
    /// The job is the execution; in this scene.
    Execution(&'a SceneId),
}

/// A job to be enqueued.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NewJob<'a> {
    pub(crate) tenant_id: &'a TenantId,
    pub(crate) kind: JobKind,
    pub(crate) subject: JobSubject<'a>,
    pub(crate) retry_of: Option<&'a JobId>,
    /// Stage from which on checkpoint keys are salted, and the salt; without a salt it is the id of the job.
    pub(crate) salted_from: Option<(&'a str, Option<&'a str>)>,
    /// Of the tenant's jobs with the same key one runs at a time, in the order of their ids.
    pub(crate) exclusive_key: Option<&'a str>,
    pub(crate) columns: QueueColumns,
}

impl<'a> NewJob<'a> {
    /// The first job of a scene.
    pub(crate) fn of_scene(tenant_id: &'a TenantId, scene_id: &'a SceneId, columns: QueueColumns) -> Self {
        Self::new(tenant_id, JobKind::Generate, JobSubject::Scene(scene_id), columns)
    }

    /// A job that repeats no other one and excludes none.
    pub(crate) fn new(
        tenant_id: &'a TenantId,
        kind: JobKind,
        subject: JobSubject<'a>,
        columns: QueueColumns,
    ) -> Self {
        Self { tenant_id, kind, subject, retry_of: None, salted_from: None, exclusive_key: None, columns }
    }

    /// Inserts the job with its first event, and returns its row.
    pub(crate) async fn insert(
        self,
        connection: &mut AnyConnection,
        now_ms: i64,
    ) -> Result<JobRow, StoreError> {
        let id: JobId = database::parse_id(&Uuid::now_v7().to_string(), "jobs")?;
        // A retry from a stage salts keys with its own id, so that it finds its own checkpoints after a restart.
        let (from_stage, salt) = match self.salted_from {
            Some((stage, salt)) => (Some(stage), Some(salt.unwrap_or(id.as_str()))),
            None => (None, None),
        };
        let (mut scene_id, mut dataset_id, mut recording_id, mut number) = (None, None, None, None);
        match self.subject {
            JobSubject::Scene(id) => scene_id = Some(id),
            JobSubject::Dataset(id) => dataset_id = Some(id),
            JobSubject::Recording(id, attempt) => (recording_id, number) = (Some(id), attempt),
            JobSubject::Execution(_) => {}
        }
        sqlx::query(
            "INSERT INTO jobs (id, tenant_id, kind, scene_id, dataset_id, recording_id, attempt_number, retry_of, from_stage, salt,
                               exclusive_key, state, created_at, priority, not_before, rank_at, deadline_at,
                               request_version, next_seq)
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, 'queued', $12, $13, $14, $15, $16, $17, $18)",
        )
        .bind(id.as_str())
        .bind(self.tenant_id.as_str())
        .bind(self.kind.as_str())
        .bind(scene_id.map(SceneId::as_str))
        .bind(dataset_id.map(DatasetId::as_str))
        .bind(recording_id.map(RecordingId::as_str))
        .bind(number.map(|number| i64::try_from(number).unwrap_or(i64::MAX)))
        .bind(self.retry_of.map(JobId::as_str))
        .bind(from_stage)
        .bind(salt)
        .bind(self.exclusive_key)
        .bind(now_ms)
        .bind(self.columns.priority)
        .bind(self.columns.not_before)
        .bind(self.columns.rank_at)
        .bind(self.columns.deadline_at)
        .bind(self.columns.request_version)
        .bind(events::FIRST_SEQ + 1)
        .execute(&mut *connection)
        .await?;
        let queued = match self.subject {
            JobSubject::Scene(id) | JobSubject::Execution(id) => json!({ "scene_id": id }),
            JobSubject::Dataset(id) => json!({ "dataset_id": id }),
            JobSubject::Recording(id, None) => json!({ "recording_id": id }),
            JobSubject::Recording(id, Some(number)) => json!({ "recording_id": id, "number": number }),
        };
        events::insert(connection, &id, events::FIRST_SEQ, now_ms, "job_queued", &queued).await?;
        Ok(JobRow {
            id,
            kind: self.kind,
            scene_id: scene_id.cloned(),
            dataset_id: dataset_id.cloned(),
            recording_id: recording_id.cloned(),
            attempt_number: number,
            retry_of: self.retry_of.cloned(),
            from_stage: from_stage.map(str::to_owned),
            state: JobState::Queued,
            rank_at_ms: self.columns.rank_at,
            attempt: 0,
            epoch: 0,
            failure_class: None,
            failure_code: None,
            failure_message: None,
            created_at_ms: now_ms,
            started_at_ms: None,
            finished_at_ms: None,
        })
    }
}
