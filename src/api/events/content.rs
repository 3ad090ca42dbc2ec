//! Events of jobs and recordings: documents of the store.

use schemars::JsonSchema;

use crate::api::episodes::views::RecordingFailureView;
use crate::api::views::FailureView;
use crate::schemas::summaries::Metrics;
use crate::schemas::values::{Id, MAX_INTEGER, Timestamp};
use crate::schemas::words::{FailureClass, JobKind, RecordingEventKind, Verdict};
use store::recordings::RecordingProgress;

/// A page of events of a job.
#[derive(JsonSchema)]
pub struct EventPage {
    pub events: Vec<Event>,
    /// The `after` of the next page.
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub next_after: u64,
}

/// A page of events of a tenant.
#[derive(JsonSchema)]
pub struct TenantEventPage {
    pub events: Vec<TenantEvent>,
    /// The `after` of the next page.
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub next_after: u64,
}

/// Something that happened to a job or a recording.
#[derive(JsonSchema)]
pub struct TenantEvent {
    /// Ascending over all jobs and recordings, with gaps.
    #[schemars(range(min = 1, max = MAX_INTEGER))]
    pub seq: u64,
    /// The `seq` within the job or the recording.
    #[schemars(range(min = 1, max = MAX_INTEGER))]
    pub number: u64,
    pub at: Timestamp,
    pub kind: TenantEventKind,
    /// The job; null for an event of a recording itself.
    pub job_id: Option<Id>,
    pub job_kind: Option<JobKind>,
    pub scene_id: Option<Id>,
    pub dataset_id: Option<Id>,
    pub recording_id: Option<Id>,
    pub data: TenantEventData,
}

/// Kind of an event of a job or of a recording.
#[derive(JsonSchema)]
#[schemars(untagged)]
pub enum TenantEventKind {
    OfJob(EventKind),
    OfRecording(RecordingEventKind),
}

/// Subject of the event, as the events of its job or its recording have it.
#[derive(JsonSchema)]
#[schemars(untagged)]
pub enum TenantEventData {
    OfJob(Box<EventData>),
    OfRecording(RecordingEventData),
}

/// A page of events of a recording.
#[derive(JsonSchema)]
pub struct RecordingEventPage {
    pub events: Vec<RecordingEvent>,
    /// The `after` of the next page.
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub next_after: u64,
}

/// Something that happened to a recording.
#[derive(JsonSchema)]
pub struct RecordingEvent {
    #[schemars(range(min = 1, max = MAX_INTEGER))]
    pub seq: u64,
    pub at: Timestamp,
    pub kind: RecordingEventKind,
    pub data: RecordingEventData,
}

/// Subject of the event; each kind has the fields that name it.
#[derive(JsonSchema)]
pub struct RecordingEventData {
    pub progress: RecordingProgress,
    /// `attempt`, `attempt_lost`: the number of the attempt, which others may overtake.
    #[schemars(skip_serializing_if = "Option::is_none", range(min = 0, max = 1_000_000))]
    pub number: Option<u64>,
    /// `attempt`: `success`, or the reason of its failure.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub outcome: Option<String>,
    /// `attempt` without success: what happened, in words.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub detail: Option<String>,
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub failure: Option<RecordingFailureView>,
}

/// Something that happened to a job.
#[derive(JsonSchema)]
pub struct Event {
    #[schemars(range(min = 1, max = MAX_INTEGER))]
    pub seq: u64,
    pub at: Timestamp,
    pub kind: EventKind,
    pub data: EventData,
}

/// Kind of an event of a job.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum EventKind {
    JobQueued,
    JobStarted,
    StageStarted,
    StageProgress,
    StageFinished,
    JobRetrying,
    JobOrphaned,
    JobReleased,
    JobCancelling,
    JobCancelled,
    JobFailed,
    JobSucceeded,
}

/// Subject of the event; each kind has the fields that name it.
#[derive(JsonSchema)]
pub struct EventData {
    /// `job_queued`.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub scene_id: Option<Id>,
    /// `job_started`.
    #[schemars(skip_serializing_if = "Option::is_none", range(min = 0, max = 2_147_483_647))]
    pub attempt: Option<u32>,
    /// `job_started`: the number of the claim.
    #[schemars(skip_serializing_if = "Option::is_none", range(min = 0, max = MAX_INTEGER))]
    pub epoch: Option<u64>,
    /// `stage_started`, `stage_progress`, `stage_finished`.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub stage: Option<String>,
    /// Of events of stages; absent when the stage works on the whole scene.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub instance: Option<String>,
    /// `stage_finished`: found, not computed.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub cached: Option<bool>,
    /// `stage_finished`.
    #[schemars(skip_serializing_if = "Option::is_none", range(min = 0, max = MAX_INTEGER))]
    pub elapsed_ms: Option<u64>,
    /// `stage_finished`: names of the artifacts of the stage. Absent from events of earlier versions.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub artifacts: Option<Vec<String>>,
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub failure: Option<FailureView>,
    /// `job_retrying`, `job_orphaned`: how long it waits.
    #[schemars(skip_serializing_if = "Option::is_none", range(min = 0, max = MAX_INTEGER))]
    pub delay_ms: Option<u64>,
    /// `job_orphaned`: no other job was in the process that died.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub alone: Option<bool>,
    /// `job_orphaned`: beside other jobs.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub shared_deaths: Option<Deaths>,
    /// `job_orphaned`: alone in the process.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub lone_deaths: Option<Deaths>,
    /// `job_orphaned`: stages in progress when the process died.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub stages: Option<Vec<StageInProgress>>,
    /// `job_failed` with the code `worker_crashed`.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub diagnosis: Option<Diagnosis>,
    /// `job_failed`.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub class: Option<FailureClass>,
    /// `job_failed`.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub code: Option<String>,
    /// `job_failed`, `stage_progress`.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
    /// `job_succeeded`.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Verdict>,
    /// `job_succeeded`.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub metrics: Option<Metrics>,
}

/// Number of deaths of the process while it held the job, since the job's last new checkpoint.
#[derive(JsonSchema)]
pub struct Deaths(#[schemars(range(min = 0, max = MAX_INTEGER))] pub u64);

/// A stage that a job had begun and not finished.
#[derive(JsonSchema)]
pub struct StageInProgress {
    pub stage: String,
    /// Empty when the stage works on the whole scene.
    pub instance: String,
    /// Number of times that the job began it.
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub runs: u64,
}

/// Facts about a job that killed its process again and again.
#[derive(JsonSchema)]
pub struct Diagnosis {
    /// No other job was in the process that died last.
    pub alone: bool,
    pub shared_deaths: Deaths,
    pub lone_deaths: Deaths,
    /// Stages in progress at the last death.
    pub stages: Vec<StageInProgress>,
    /// The job's last events, newest first.
    pub events: Vec<EventName>,
}

/// An event by its number and kind.
#[derive(JsonSchema)]
pub struct EventName {
    #[schemars(range(min = 1, max = MAX_INTEGER))]
    pub seq: u64,
    pub kind: EventKind,
}
