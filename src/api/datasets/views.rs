//! Datasets as clients see them.

use serde::Serialize;
use serde_json::Value;

use crate::api::views::timestamp;
use datasets::{dataset_manifest, licences, statistics};
use scene::{DatasetId, JobId};
use store::datasets::{DatasetFile, DatasetRow, DatasetState};

/// A dataset.
#[derive(Serialize)]
pub(super) struct DatasetView {
    id: DatasetId,
    name: String,
    version: Option<i64>,
    /// The newest job: the freeze, or the last verification.
    job_id: Option<JobId>,
    state: &'static str,
    request: Value,
    /// Of the manifest, as it states it.
    digest: Option<String>,
    summary: Option<Value>,
    failure: Option<DatasetFailureView>,
    progress: Option<DatasetProgressView>,
    verification: Option<VerificationView>,
    created_at: String,
    finished_at: Option<String>,
    pub(super) links: DatasetLinks,
}

#[derive(Serialize)]
struct DatasetFailureView {
    code: String,
    message: String,
}

/// Steps of the work in progress.
#[derive(Serialize)]
struct DatasetProgressView {
    done: i64,
    all: i64,
}

/// Whether a verification waits or runs, and what the last one found.
#[derive(Serialize)]
struct VerificationView {
    state: String,
    found: Option<Value>,
}

#[derive(Serialize)]
pub(super) struct DatasetLinks {
    #[serde(rename = "self")]
    pub(super) this: String,
    files: String,
    archive: String,
    manifest: String,
    licenses: String,
    statistics: String,
    statistics_page: String,
}

impl DatasetView {
    pub(super) fn new(row: DatasetRow) -> Self {
        let this = format!("/datasets/{}", row.id);
        let file = |path: &str| format!("{this}/files/{path}");
        let is_verifying = row.verify_state.as_deref().is_some_and(|state| state != "finished");
        let is_frozen = matches!(row.state, DatasetState::Finished | DatasetState::Failed);
        let (done, all) = row.steps;
        let failure = row.failure_code.zip(row.failure_message);
        Self {
            links: DatasetLinks {
                files: format!("{this}/files"),
                archive: format!("{this}/archive"),
                manifest: file(dataset_manifest::PATH),
                licenses: file(licences::PATH),
                statistics: file(statistics::JSON_PATH),
                statistics_page: file(statistics::PAGE_PATH),
                this,
            },
            id: row.id,
            name: row.name,
            version: row.version,
            job_id: row.job_id,
            state: row.state.as_str(),
            request: row.request,
            digest: row.digest,
            summary: row.summary,
            failure: failure.map(|(code, message)| DatasetFailureView { code, message }),
            progress: (is_verifying || !is_frozen).then_some(DatasetProgressView { done, all }),
            verification: row.verify_state.map(|state| VerificationView { state, found: row.verification }),
            created_at: timestamp(row.created_at_ms),
            finished_at: row.finished_at_ms.map(timestamp),
        }
    }
}

/// A file of a version.
#[derive(Serialize)]
pub(super) struct DatasetFileView {
    path: String,
    media_type: String,
    size: u64,
    sha256: String,
    url: String,
}

impl DatasetFileView {
    pub(super) fn new(dataset_id: &DatasetId, file: DatasetFile) -> Self {
        Self {
            url: format!("/datasets/{dataset_id}/files/{}", file.path),
            path: file.path,
            media_type: file.media_type,
            size: file.size,
            sha256: file.digest.to_string(),
        }
    }
}
