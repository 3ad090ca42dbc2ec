//! Response bodies: the rows of the store as clients see them.

use std::collections::BTreeMap;

use crate::schemas::scene_request::Labels;
use crate::schemas::summaries::{Metrics, SceneSummary};
use crate::schemas::values::{Id, Link, MAX_INTEGER, Sha256, Timestamp};
use crate::schemas::words::{FailureClass, JobKind, JobState, SceneState, StageState, Verdict};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

pub use super::spending::SpendingView;
use scene::{DatasetId, JobId, RecordingId, SceneId, SceneRequest};
use store::artifacts::ArtifactRow;
use store::events::Event;
use store::jobs::{JobRow, StageRow};
use store::lifecycle;
use store::outlook::Outlook;
use store::scenes::SceneRow;
use store::tenant_events::TenantEvent;

/// A scene and its newest job.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Scene")]
pub struct SceneView {
    #[schemars(with = "Id")]
    pub id: SceneId,
    #[schemars(with = "SceneState")]
    pub state: lifecycle::SceneState,
    #[schemars(with = "Option<Verdict>")]
    pub verdict: Option<String>,
    pub failure: Option<FailureView>,
    #[schemars(with = "Option<Id>")]
    pub parent: Option<SceneId>,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub seed: u64,
    #[schemars(with = "SceneRequest")]
    pub request: Value,
    #[schemars(with = "Labels")]
    pub labels: BTreeMap<String, String>,
    #[schemars(with = "Option<Metrics>")]
    pub metrics: Option<Value>,
    #[schemars(with = "Option<SceneSummary<'static>>")]
    pub summary: Option<Value>,
    pub created_at: Timestamp,
    pub updated_at: Timestamp,
    pub job: Option<JobView>,
    /// Only when one scene is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stages: Option<Vec<StageView>>,
    /// Only when one scene is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub artifacts: Option<Vec<ArtifactView>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spending: Option<SpendingView>,
    pub links: SceneLinks,
}

/// Paths of what belongs to a scene.
#[derive(Serialize, JsonSchema)]
pub struct SceneLinks {
    #[serde(rename = "self")]
    #[schemars(with = "Link")]
    pub this: String,
    #[schemars(with = "Link")]
    pub bundle: String,
    #[schemars(with = "Link")]
    pub files: String,
    #[schemars(with = "Link")]
    pub preview: String,
    #[schemars(with = "Link")]
    pub artifacts: String,
    #[schemars(with = "Option<Link>")]
    pub events: Option<String>,
}

impl SceneView {
    pub fn new(scene: SceneRow, job: Option<JobView>) -> Self {
        let this = format!("/scenes/{}", scene.id);
        Self {
            links: SceneLinks {
                bundle: format!("{this}/bundle"),
                files: format!("{this}/files"),
                preview: format!("{this}/preview"),
                artifacts: format!("{this}/artifacts"),
                events: job.as_ref().map(|job| job.links.events.clone()),
                this,
            },
            id: scene.id,
            state: scene.state,
            verdict: scene.verdict,
            failure: FailureView::new(None, scene.failure_code, scene.failure_message),
            parent: scene.parent_id,
            seed: scene.request["seed"].as_u64().unwrap_or_default(),
            request: scene.request,
            labels: scene.labels,
            metrics: scene.metrics,
            summary: scene.summary,
            created_at: Timestamp::of_ms(scene.created_at_ms),
            updated_at: Timestamp::of_ms(scene.updated_at_ms),
            job,
            stages: None,
            artifacts: None,
            spending: None,
        }
    }
}

/// Reason of the failure.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Failure")]
pub struct FailureView {
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<FailureClass>")]
    pub class: Option<String>,
    pub code: String,
    pub message: String,
}

impl FailureView {
    fn new(class: Option<String>, code: Option<String>, message: Option<String>) -> Option<Self> {
        code.map(|code| Self { class, code, message: message.unwrap_or_default() })
    }
}

/// An operation on a scene, a dataset or a recording.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Job")]
pub struct JobView {
    #[schemars(with = "Id")]
    pub id: JobId,
    #[schemars(with = "JobKind")]
    pub kind: lifecycle::JobKind,
    #[schemars(with = "JobState")]
    pub state: lifecycle::JobState,
    /// The scene that is built, or the one in which a task is executed.
    #[schemars(with = "Option<Id>")]
    pub scene_id: Option<SceneId>,
    #[schemars(with = "Option<Id>")]
    pub dataset_id: Option<DatasetId>,
    #[schemars(with = "Option<Id>")]
    pub recording_id: Option<RecordingId>,
    /// Of an attempt of a recording, from 0. Absent from other jobs.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub attempt_number: Option<u64>,
    #[schemars(with = "Option<Id>")]
    pub retry_of: Option<JobId>,
    pub from_stage: Option<String>,
    /// Tries since the last progress.
    #[schemars(range(min = 0, max = 2_147_483_647))]
    pub attempt: i64,
    /// Place among the client's own queued scenes, 1 is next. Absent unless the job waits and builds a scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = MAX_INTEGER))]
    pub queue_position: Option<i64>,
    /// Probable end of the job, by the durations of jobs that ended lately and the jobs that run now. Absent
    /// where these say nothing, and once the job has ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated_finish_at: Option<Timestamp>,
    pub failure: Option<FailureView>,
    pub created_at: Timestamp,
    pub started_at: Option<Timestamp>,
    pub finished_at: Option<Timestamp>,
    pub links: JobLinks,
}

/// Paths of what belongs to a job.
#[derive(Serialize, JsonSchema)]
pub struct JobLinks {
    #[serde(rename = "self")]
    #[schemars(with = "Link")]
    pub this: String,
    #[schemars(with = "Link")]
    pub events: String,
    #[schemars(with = "Link")]
    pub stages: String,
    #[schemars(with = "Option<Link>")]
    pub scene: Option<String>,
    #[schemars(with = "Option<Link>")]
    pub dataset: Option<String>,
    #[schemars(with = "Option<Link>")]
    pub recording: Option<String>,
    /// The answer of an execution.
    #[schemars(with = "Option<Link>")]
    pub execution: Option<String>,
}

impl JobView {
    pub fn new(job: JobRow, outlook: Outlook) -> Self {
        let this = format!("/jobs/{}", job.id);
        Self {
            links: JobLinks {
                events: format!("{this}/events"),
                stages: format!("{this}/stages"),
                scene: job.scene_id.as_ref().map(|id| format!("/scenes/{id}")),
                dataset: job.dataset_id.as_ref().map(|id| format!("/datasets/{id}")),
                execution: (job.kind == lifecycle::JobKind::ExecuteTask)
                    .then(|| format!("/executions/{}", job.id)),
                recording: job.recording_id.as_ref().map(|id| format!("/episodes/{id}")),
                this,
            },
            id: job.id,
            kind: job.kind,
            state: job.state,
            scene_id: job.scene_id,
            dataset_id: job.dataset_id,
            recording_id: job.recording_id,
            attempt_number: job.attempt_number,
            retry_of: job.retry_of,
            from_stage: job.from_stage,
            attempt: job.attempt,
            queue_position: outlook.queue_position,
            estimated_finish_at: outlook.finish_at_ms.map(Timestamp::of_ms),
            failure: FailureView::new(job.failure_class, job.failure_code, job.failure_message),
            created_at: Timestamp::of_ms(job.created_at_ms),
            started_at: job.started_at_ms.map(Timestamp::of_ms),
            finished_at: job.finished_at_ms.map(Timestamp::of_ms),
        }
    }
}

/// One stage of a job.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Stage")]
pub struct StageView {
    pub stage: String,
    /// Absent when the stage works on the whole scene.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub instance: String,
    #[schemars(with = "StageState")]
    pub state: String,
    /// Found, not computed, when the job last passed here.
    pub cached: bool,
    /// Number of times that this job started computing it.
    #[schemars(range(min = 0, max = 2_147_483_647))]
    pub runs: i64,
    /// Duration of the computation, in whichever job it ran.
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub elapsed_ms: Option<i64>,
    pub started_at: Timestamp,
}

impl StageView {
    pub fn new(row: StageRow) -> Self {
        Self {
            stage: row.stage,
            instance: row.instance,
            state: row.state,
            cached: row.cached,
            runs: row.runs,
            elapsed_ms: row.elapsed_ms,
            started_at: Timestamp::of_ms(row.started_at_ms),
        }
    }
}

/// A file that a stage put aside.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Artifact")]
pub struct ArtifactView {
    pub name: String,
    pub stage: String,
    pub media_type: String,
    /// Bytes.
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub size: u64,
    #[schemars(with = "Sha256")]
    pub sha256: String,
    #[schemars(with = "Link")]
    pub url: String,
}

impl ArtifactView {
    pub fn new(scene_id: &SceneId, row: ArtifactRow) -> Self {
        Self {
            url: format!("/scenes/{scene_id}/artifacts/{}", row.file.name),
            name: row.file.name,
            stage: row.stage,
            media_type: row.file.media_type,
            size: row.file.size,
            sha256: row.file.digest.to_string(),
        }
    }
}

/// An event of a job or of a recording.
#[derive(Serialize)]
pub struct EventView {
    pub seq: i64,
    pub at: Timestamp,
    pub kind: String,
    pub data: Value,
}

impl EventView {
    pub fn new(event: Event) -> Self {
        Self { seq: event.seq, at: Timestamp::of_ms(event.at_ms), kind: event.kind, data: event.data }
    }
}

/// An event of a job or of a recording among all of its tenant.
#[derive(Serialize)]
pub struct TenantEventView {
    seq: i64,
    number: i64,
    at: Timestamp,
    kind: String,
    job_id: Option<JobId>,
    job_kind: Option<lifecycle::JobKind>,
    scene_id: Option<SceneId>,
    dataset_id: Option<DatasetId>,
    recording_id: Option<RecordingId>,
    data: Value,
}

impl TenantEventView {
    pub fn new(event: TenantEvent) -> Self {
        let (job_id, job_kind) = event.job.unzip();
        Self {
            seq: event.position,
            number: event.event.seq,
            at: Timestamp::of_ms(event.event.at_ms),
            kind: event.event.kind,
            job_id,
            job_kind,
            scene_id: event.scene_id,
            dataset_id: event.dataset_id,
            recording_id: event.recording_id,
            data: event.event.data,
        }
    }
}
