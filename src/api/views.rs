//! Response bodies: the rows of the store as clients see them.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

pub use super::spending::SpendingView;
use scene::job::JobKind;
use scene::{DatasetId, JobId, RecordingId, SceneId};
use store::artifacts::ArtifactRow;
use store::events::Event;
use store::jobs::{JobRow, StageRow};
use store::outlook::Outlook;
use store::scenes::SceneRow;

/// A scene with its newest job.
#[derive(Serialize)]
pub struct SceneView {
    pub id: SceneId,
    pub state: &'static str,
    pub verdict: Option<String>,
    pub failure: Option<FailureView>,
    pub parent: Option<SceneId>,
    pub seed: Value,
    pub request: Value,
    pub labels: BTreeMap<String, String>,
    pub metrics: Option<Value>,
    pub summary: Option<Value>,
    pub created_at: String,
    pub updated_at: String,
    pub job: Option<JobView>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stages: Option<Vec<StageView>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub artifacts: Option<Vec<ArtifactView>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spending: Option<SpendingView>,
    pub links: SceneLinks,
}

#[derive(Serialize)]
pub struct SceneLinks {
    #[serde(rename = "self")]
    pub this: String,
    pub bundle: String,
    pub artifacts: String,
    pub events: Option<String>,
}

impl SceneView {
    pub fn new(scene: SceneRow, job: Option<JobView>) -> Self {
        let this = format!("/scenes/{}", scene.id);
        Self {
            links: SceneLinks {
                bundle: format!("{this}/bundle"),
                artifacts: format!("{this}/artifacts"),
                events: job.as_ref().map(|job| job.links.events.clone()),
                this,
            },
            id: scene.id,
            state: scene.state.as_str(),
            verdict: scene.verdict,
            failure: FailureView::new(None, scene.failure_code, scene.failure_message),
            parent: scene.parent_id,
            seed: scene.request.get("seed").cloned().unwrap_or_default(),
            request: scene.request,
            labels: scene.labels,
            metrics: scene.metrics,
            summary: scene.summary,
            created_at: timestamp(scene.created_at_ms),
            updated_at: timestamp(scene.updated_at_ms),
            job,
            stages: None,
            artifacts: None,
            spending: None,
        }
    }
}

#[derive(Serialize)]
pub struct FailureView {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    pub code: String,
    pub message: String,
}

impl FailureView {
    fn new(class: Option<String>, code: Option<String>, message: Option<String>) -> Option<Self> {
        code.map(|code| Self { class, code, message: message.unwrap_or_default() })
    }
}

#[derive(Serialize)]
pub struct JobView {
    pub id: JobId,
    pub kind: &'static str,
    pub state: &'static str,
    pub scene_id: Option<SceneId>,
    pub dataset_id: Option<DatasetId>,
    pub recording_id: Option<RecordingId>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attempt_number: Option<u64>,
    pub retry_of: Option<JobId>,
    pub from_stage: Option<String>,
    pub attempt: i64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub queue_position: Option<i64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated_finish_at: Option<String>,
    pub failure: Option<FailureView>,
    pub created_at: String,
    pub started_at: Option<String>,
    pub finished_at: Option<String>,
    pub links: JobLinks,
}

#[derive(Serialize)]
pub struct JobLinks {
    #[serde(rename = "self")]
    pub this: String,
    pub events: String,
    pub stages: String,
    pub scene: Option<String>,
    pub dataset: Option<String>,
    pub recording: Option<String>,
    /// The answer of an execution.
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
                execution: (job.kind == JobKind::ExecuteTask).then(|| format!("/executions/{}", job.id)),
                recording: job.recording_id.as_ref().map(|id| format!("/episodes/{id}")),
                this,
            },
            id: job.id,
            kind: job.kind.as_str(),
            state: job.state.as_str(),
            scene_id: job.scene_id,
            dataset_id: job.dataset_id,
            recording_id: job.recording_id,
            attempt_number: job.attempt_number,
            retry_of: job.retry_of,
            from_stage: job.from_stage,
            attempt: job.attempt,
            queue_position: outlook.queue_position,
            estimated_finish_at: outlook.finish_at_ms.map(timestamp),
            failure: FailureView::new(job.failure_class, job.failure_code, job.failure_message),
            created_at: timestamp(job.created_at_ms),
            started_at: job.started_at_ms.map(timestamp),
            finished_at: job.finished_at_ms.map(timestamp),
        }
    }
}

#[derive(Serialize)]
pub struct StageView {
    pub stage: String,
    /// Absent when the stage works on the whole scene.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub instance: String,
    pub state: String,
    pub cached: bool,
    pub runs: i64,
    pub elapsed_ms: Option<i64>,
    pub started_at: String,
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
            started_at: timestamp(row.started_at_ms),
        }
    }
}

#[derive(Serialize)]
pub struct ArtifactView {
    pub name: String,
    pub stage: String,
    pub media_type: String,
    pub size: u64,
    pub sha256: String,
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

#[derive(Serialize)]
pub struct EventView {
    pub seq: i64,
    pub at: String,
    pub kind: String,
    pub data: Value,
}

impl EventView {
    pub fn new(event: Event) -> Self {
        Self { seq: event.seq, at: timestamp(event.at_ms), kind: event.kind, data: event.data }
    }
}

/// RFC 3339 in UTC with milliseconds, of milliseconds since 1970.
pub fn timestamp(ms: i64) -> String {
    let time = jiff::Timestamp::from_millisecond(ms).unwrap_or_default();
    time.strftime("%Y-%m-%dT%H:%M:%S%.3fZ").to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timestamp_formats_known_times() {
        assert_eq!(timestamp(0), "1970-01-01T00:00:00.000Z");
        assert_eq!(timestamp(951_782_400_000), "2000-02-29T00:00:00.000Z");
        assert_eq!(timestamp(1_763_722_805_042), "2025-11-21T11:00:05.042Z");
        assert_eq!(timestamp(-1), "1969-12-31T23:59:59.999Z");
    }
}
