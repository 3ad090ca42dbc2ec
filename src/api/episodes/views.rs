//! Recordings of episodes as clients see them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::content::media_type_of;
use crate::api::extract::TenantApi;
use crate::api::views::timestamp;
use crate::app::episodes::EpisodesOrder;
use crate::problem::Problem;
use scene::{RecordingId, SceneId};
use store::StoreError;
use store::recordings::{RecordingArchive, RecordingFile, RecordingProgress, RecordingRow, RecordingState};

/// A recording.
#[derive(Serialize)]
pub(super) struct RecordingView {
    id: RecordingId,
    scene_id: SceneId,
    state: &'static str,
    order: Value,
    progress: RecordingProgress,
    /// Number of attempts by outcome.
    attempts: BTreeMap<String, u64>,
    failure: Option<RecordingFailureView>,
    dataset: Option<RecordedDatasetView>,
    created_at: String,
    started_at: Option<String>,
    finished_at: Option<String>,
    pub(super) links: RecordingLinks,
}

#[derive(Serialize)]
struct RecordingFailureView {
    code: String,
    message: String,
}

/// Content of the recorded dataset.
#[derive(Serialize)]
struct RecordedDatasetView {
    episodes: u64,
    frames: u64,
    formats: Vec<RecordedFormatView>,
}

#[derive(Serialize)]
struct RecordedFormatView {
    format: String,
    files: u64,
    /// The archive of all files.
    archive: String,
    /// Of the archive, bytes.
    size: u64,
    sha256: Option<String>,
}

#[derive(Serialize)]
pub(super) struct RecordingLinks {
    #[serde(rename = "self")]
    pub(super) this: String,
    scene: String,
    events: String,
    files: String,
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
            created_at: timestamp(row.created_at_ms),
            started_at: row.started_at_ms.map(timestamp),
            finished_at: row.finished_at_ms.map(timestamp),
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
pub(super) struct RecordingFileView {
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
