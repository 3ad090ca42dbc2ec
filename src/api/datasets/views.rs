//! Datasets as clients see them.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::freezer::{DatasetSummary, VerificationResult};
use crate::schemas::datasets::{OpenDocument, VerificationState};
use crate::schemas::values::{Id, Link, MAX_INTEGER, Sha256, Timestamp};
use crate::schemas::words;
use datasets::{dataset_manifest, licences, statistics};
use scene::{DatasetId, JobId};
use store::datasets::{DatasetFile, DatasetRow, DatasetState};

/// A freeze, and the version that it made.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Dataset")]
pub(in crate::api) struct DatasetView {
    #[schemars(with = "Id")]
    id: DatasetId,
    name: String,
    #[schemars(range(min = 1, max = u32::MAX))]
    version: Option<i64>,
    /// The newest job, the freeze or the last verification; null of versions that an earlier release froze.
    #[schemars(with = "Option<Id>")]
    job_id: Option<JobId>,
    #[schemars(with = "words::DatasetState")]
    state: &'static str,
    #[schemars(with = "OpenDocument")]
    request: Value,
    /// SHA-256 of the manifest, as it states it.
    digest: Option<String>,
    #[schemars(with = "Option<DatasetSummary<'static>>")]
    summary: Option<Value>,
    failure: Option<DatasetFailureView>,
    progress: Option<DatasetProgressView>,
    verification: Option<VerificationView>,
    created_at: Timestamp,
    finished_at: Option<Timestamp>,
    pub(super) links: DatasetLinks,
}

/// Reason why a freeze failed.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "DatasetFailure")]
pub(in crate::api) struct DatasetFailureView {
    #[schemars(regex(pattern = r"^[a-z0-9_]+$"))]
    code: String,
    message: String,
}

/// Steps of the work in progress; each phase counts anew.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "DatasetProgress")]
pub(in crate::api) struct DatasetProgressView {
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    done: i64,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    all: i64,
}

/// Whether a verification waits or runs, and what the last one found.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "DatasetVerification")]
pub(in crate::api) struct VerificationView {
    #[schemars(with = "VerificationState")]
    state: String,
    #[schemars(with = "Option<VerificationResult>")]
    found: Option<Value>,
}

/// Paths of what belongs to a dataset.
#[derive(Serialize, JsonSchema)]
pub(in crate::api) struct DatasetLinks {
    #[serde(rename = "self")]
    #[schemars(with = "Link")]
    pub(super) this: String,
    #[schemars(with = "Link")]
    files: String,
    #[schemars(with = "Link")]
    archive: String,
    #[schemars(with = "Link")]
    manifest: String,
    #[schemars(with = "Link")]
    licenses: String,
    #[schemars(with = "Link")]
    statistics: String,
    #[schemars(with = "Link")]
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
            created_at: Timestamp::of_ms(row.created_at_ms),
            finished_at: row.finished_at_ms.map(Timestamp::of_ms),
        }
    }
}

/// A file of a version.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "DatasetFile")]
pub(in crate::api) struct DatasetFileView {
    path: String,
    media_type: String,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    size: u64,
    #[schemars(with = "Sha256")]
    sha256: String,
    #[schemars(with = "Link")]
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
