//! `/queue`: what waits, what runs, and where.

use std::collections::BTreeMap;

use axum::Json;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::Serialize;

use super::extract::TenantApi;
use crate::problem::Problem;
use crate::schemas::values::{Id, MAX_INTEGER, Timestamp};
use crate::schemas::words;
use scene::{DatasetId, JobId, RecordingId, SceneId};
use store::lifecycle::JobKind;
use store::queue::{ActiveJob, Pause};
use store::{DEFAULT_TENANT, Outage};

/// Work of a tenant; for the operator, of all tenants.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Queue")]
pub(super) struct QueueView {
    /// Null while workers take jobs.
    paused: Option<PauseView>,
    /// Kinds of which jobs wait or run.
    kinds: Vec<KindView>,
    /// Workers that hold jobs, by name.
    workers: Vec<WorkerView>,
    storage: StorageState,
}

/// A pause of claiming.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "QueuePause")]
struct PauseView {
    reason: String,
    since: Timestamp,
}

/// Jobs of a kind.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "QueueKind")]
struct KindView {
    #[schemars(with = "words::JobKind")]
    kind: JobKind,
    /// Also those for a later time.
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    waiting: i64,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    running: i64,
}

/// A worker and the jobs that it holds.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "QueueWorker")]
struct WorkerView {
    id: String,
    /// The earliest claim of these jobs.
    since: Timestamp,
    jobs: Vec<HeldJobView>,
}

/// A job that a worker holds.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "HeldJob")]
struct HeldJobView {
    #[schemars(with = "Id")]
    job_id: JobId,
    #[schemars(with = "words::JobKind")]
    kind: JobKind,
    #[schemars(with = "Option<Id>")]
    scene_id: Option<SceneId>,
    #[schemars(with = "Option<Id>")]
    dataset_id: Option<DatasetId>,
    #[schemars(with = "Option<Id>")]
    recording_id: Option<RecordingId>,
    /// Time of the newest claim of the job.
    since: Timestamp,
}

/// Whether the database and the place of blobs take writes: `full` where the disk or a quota leaves no room.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum StorageState {
    Ok,
    Full,
    Unavailable,
}

/// `GET /queue`.
pub async fn show(api: TenantApi) -> Result<Response, Problem> {
    let tenant_id = Some(&api.tenant_id).filter(|tenant_id| **tenant_id != *DEFAULT_TENANT);
    let overview = api.store.queue_overview(tenant_id).await?;
    let mut kinds: BTreeMap<JobKind, (i64, i64)> = BTreeMap::new();
    for (kind, waiting) in overview.waiting {
        kinds.entry(kind).or_default().0 = waiting;
    }
    let mut by_owner: BTreeMap<String, Vec<ActiveJob>> = BTreeMap::new();
    for job in overview.active {
        kinds.entry(job.kind).or_default().1 += 1;
        by_owner.entry(job.owner.clone()).or_default().push(job);
    }
    let view = QueueView {
        paused: overview
            .paused
            .map(|Pause { reason, since_ms }| PauseView { reason, since: Timestamp::of_ms(since_ms) }),
        kinds: kinds
            .into_iter()
            .map(|(kind, (waiting, running))| KindView { kind, waiting, running })
            .collect(),
        workers: by_owner.into_iter().map(|(id, jobs)| worker(id, jobs)).collect(),
        storage: match *api.store.outage().borrow() {
            None => StorageState::Ok,
            Some(Outage::Full) => StorageState::Full,
            Some(Outage::Other) => StorageState::Unavailable,
        },
    };
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(view)).into_response())
}

/// A worker with its jobs, those that began first in front.
fn worker(id: String, jobs: Vec<ActiveJob>) -> WorkerView {
    let since = Timestamp::of_ms(jobs.first().map_or(0, |job| job.claimed_at_ms));
    let held = |job: ActiveJob| HeldJobView {
        job_id: job.id,
        kind: job.kind,
        scene_id: job.scene_id,
        dataset_id: job.dataset_id,
        recording_id: job.recording_id,
        since: Timestamp::of_ms(job.claimed_at_ms),
    };
    WorkerView { id, since, jobs: jobs.into_iter().map(held).collect() }
}
