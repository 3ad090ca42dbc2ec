//! Recordings of episodes as clients see them.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::content::media_type_of;
use crate::api::extract::TenantApi;
use crate::app::episodes::EpisodesOrder;
use crate::app::episodes::draft::EpisodesDraft;
use crate::problem::Problem;
use crate::schemas::episodes::AttemptCount;
use crate::schemas::values::{Id, Link, MAX_INTEGER, Sha256, Timestamp};
use crate::schemas::words;
use scene::{RecordingId, SceneId};
use store::StoreError;
use store::recordings::{RecordingArchive, RecordingFile, RecordingProgress, RecordingRow, RecordingState};

/// Demonstrations of tasks in a scene, and the dataset that becomes of them.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Recording")]
pub(in crate::api) struct RecordingView {
    #[schemars(with = "Id")]
    id: RecordingId,
    #[schemars(with = "Id")]
    scene_id: SceneId,
    #[schemars(with = "words::RecordingState")]
    state: &'static str,
    #[schemars(with = "EpisodesDraft")]
    order: Value,
    progress: RecordingProgress,
    /// Number of attempts by result, `success` or the reason of a failure.
    #[schemars(with = "BTreeMap<String, AttemptCount>")]
    attempts: BTreeMap<String, u64>,
    failure: Option<RecordingFailureView>,
    dataset: Option<RecordedDatasetView>,
    created_at: Timestamp,
    started_at: Option<Timestamp>,
    finished_at: Option<Timestamp>,
    pub(super) links: RecordingLinks,
}

/// Reason why a recording failed.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RecordingFailure")]
pub struct RecordingFailureView {
    #[schemars(regex(pattern = r"^[a-z0-9_]+$"))]
    code: String,
    message: String,
}

/// Content of the recorded dataset.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RecordedDataset")]
pub(in crate::api) struct RecordedDatasetView {
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    episodes: u64,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    frames: u64,
    formats: Vec<RecordedFormatView>,
}

/// The dataset in one format.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "RecordedFormat")]
pub(in crate::api) struct RecordedFormatView {
    #[schemars(with = "words::EpisodeFormat")]
    format: String,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    files: u64,
    /// All files as one tar archive.
    #[schemars(with = "Link")]
    archive: String,
    /// Of the archive, bytes.
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    size: u64,
    /// Of the archive.
    #[schemars(with = "Option<Sha256>")]
    sha256: Option<String>,
}

/// Paths of what belongs to a recording.
#[derive(Serialize, JsonSchema)]
pub(in crate::api) struct RecordingLinks {
    #[serde(rename = "self")]
    #[schemars(with = "Link")]
    pub(super) this: String,
    #[schemars(with = "Link")]
    scene: String,
    #[schemars(with = "Link")]
    events: String,
    #[schemars(with = "Link")]
    files: String,
    #[schemars(with = "Link")]
    cancel: String,
}

/// The summary that the recorder stores.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Summary {
    attempts: BTreeMap<String, u64>,
    episodes: u64,
    frames: u64,
}

impl RecordingView {
    /// The view of a row, with what is read of its attempts.
    pub(super) async fn of(api: &TenantApi, row: RecordingRow) -> Result<Self, Problem> {
        let this = format!("/episodes/{}", row.id);
        let summary: Option<Summary> =
            row.summary.clone().map(serde_json::from_value).transpose().map_err(|error| {
                StoreError::Corrupt { table: "recordings", reason: format!("summary: {error}") }
            })?;
        let summary = summary.unwrap_or_default();
        let is_final = row.state.is_final();
        let attempts = match is_final {
            true => summary.attempts,
            false => api.store.attempt_outcomes(&row.id).await?,
        };
        let progress = api.store.recording_progress(&row).await?;
        let dataset = match row.state {
            RecordingState::Finished => Some(RecordedDatasetView {
                episodes: summary.episodes,
                frames: summary.frames,
                formats: api
                    .store
                    .recording_archives(&row.id)
                    .await?
                    .into_iter()
                    .map(|archive| RecordedFormatView::new(&this, archive))
                    .collect(),
            }),
            _ => None,
        };
        let failure = row.failure_code.zip(row.failure_message);
        let order = EpisodesOrder::statement(&row.request);
        Ok(Self {
            links: RecordingLinks {
                scene: format!("/scenes/{}", row.scene_id),
                events: format!("{this}/events"),
                files: format!("{this}/files"),
                cancel: format!("{this}/cancel"),
                this,
            },
            id: row.id,
            scene_id: row.scene_id,
            state: row.state.as_str(),
            order,
            progress,
            attempts,
            failure: failure.map(|(code, message)| RecordingFailureView { code, message }),
            dataset,
            created_at: Timestamp::of_ms(row.created_at_ms),
            started_at: row.started_at_ms.map(Timestamp::of_ms),
            finished_at: row.finished_at_ms.map(Timestamp::of_ms),
        })
    }
}

impl RecordedFormatView {
    fn new(recording: &str, archive: RecordingArchive) -> Self {
        Self {
            archive: format!("{recording}/archives/{}", archive.format),
            format: archive.format,
            files: archive.files,
            size: archive.size,
            sha256: archive.digest.map(|digest| digest.to_string()),
        }
    }
}

/// A file of a dataset.
#[derive(Serialize)]
pub(in crate::api) struct RecordingFileView {
    path: String,
    media_type: &'static str,
    size: u64,
    sha256: String,
    url: String,
}

impl RecordingFileView {
    pub(super) fn new(id: &RecordingId, file: RecordingFile) -> Self {
        Self {
            url: format!("/episodes/{id}/files/{}", file.path),
            media_type: media_type_of(&file.path),
            path: file.path,
            size: file.size,
            sha256: file.digest.to_string(),
        }
    }
}
