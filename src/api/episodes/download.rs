//! The files of a recorded dataset, and the archives of its formats.

use axum::Json;
use axum::http::{HeaderMap, Method};
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::content::{file_content, media_type_of, place_of, token_after, whole};
use super::find;
use super::views::RecordingFileView;
use crate::api::datasets::views::DatasetFileView;
use crate::api::download::{Download, respond};
use crate::api::extract::{PathId, PathName, TenantApi};
use crate::api::query::{PageSize, PageToken, Parameters};
use crate::problem::{Problem, ProblemType};
use scene::RecordingId;
use store::recordings::{RecordingArchive, RecordingRow, RecordingState};

/// Parameters of `GET /episodes/{recording_id}/files`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FileParameters {
    page_size: PageSize,
    page_token: Option<PageToken>,
}

/// A page of the files of a recording.
#[derive(Serialize, JsonSchema)]
pub struct RecordingFilePage {
    #[schemars(with = "Vec<DatasetFileView>")]
    files: Vec<RecordingFileView>,
    /// Null on the last page.
    next_page_token: Option<String>,
}

/// `GET /episodes/{recording_id}/files`.
pub async fn files(
    api: TenantApi,
    PathId(recording_id): PathId<RecordingId>,
    Parameters(parameters): Parameters<FileParameters>,
) -> Result<Response, Problem> {
    let row = finished(&api, &recording_id).await?;
    let size = parameters.page_size;
    let after = parameters.page_token.and_then(place_of);
    let files = api.store.recording_files(&row.id, after, size.rows_to_read()).await?;
    let page = size.page_of(files, |(place, _)| token_after(*place));
    let files = page.rows.into_iter().map(|(_, file)| RecordingFileView::new(&row.id, file)).collect();
    Ok(Json(RecordingFilePage { files, next_page_token: page.next_page_token }).into_response())
}

/// `GET /episodes/{recording_id}/files/{name}`.
pub async fn download(
    api: TenantApi,
    PathId(recording_id): PathId<RecordingId>,
    PathName(path): PathName,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let row = finished(&api, &recording_id).await?;
    let file = api.store.recording_file(&row.id, &path).await?;
    let file = file.ok_or_else(|| Problem::not_found("file of the episodes", &path))?;
    let format = path.split('/').next().unwrap_or_default();
    let archive = archive_of(&api, &row, format).await?;
    let kind = media_type_of(&path);
    let name = path.rsplit('/').next().unwrap_or_default().to_owned();
    let what = Download {
        digest: &file.digest,
        size: file.size,
        media_type: kind,
        // Documents are shown in place.
        file_name: (kind == "application/octet-stream").then_some(name),
        content: file_content(&archive, &file),
    };
    respond(&api, &method, &headers, what).await?.ok_or_else(damaged)
}

/// `GET /episodes/{recording_id}/archives/{format}`.
pub async fn archive(
    api: TenantApi,
    PathId(recording_id): PathId<RecordingId>,
    PathName(format): PathName,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let row = finished(&api, &recording_id).await?;
    let archive = archive_of(&api, &row, &format).await?;
    let digest = archive.digest.clone().ok_or_else(damaged)?;
    let what = Download {
        digest: &digest,
        size: archive.size,
        media_type: "application/x-tar",
        file_name: Some(format!("{}-{}.tar", row.id, archive.format)),
        content: whole(&archive),
    };
    respond(&api, &method, &headers, what).await?.ok_or_else(damaged)
}

async fn archive_of(api: &TenantApi, row: &RecordingRow, format: &str) -> Result<RecordingArchive, Problem> {
    let archives = api.store.recording_archives(&row.id).await?;
    let found = archives.into_iter().find(|archive| archive.format == format);
    found.ok_or_else(|| Problem::not_found("format of the episodes", format))
}

fn damaged() -> Problem {
    Problem::new(
        ProblemType::Gone,
        "episodes_damaged",
        "the bytes of this file are lost or damaged; order the same episodes again",
    )
}

/// A recording with a dataset.
async fn finished(api: &TenantApi, recording_id: &RecordingId) -> Result<RecordingRow, Problem> {
    let row = find(api, recording_id).await?;
    let (code, detail) = match row.state {
        RecordingState::Finished => return Ok(row),
        RecordingState::Failed => ("episodes_failed", "these episodes have no files; see the failure"),
        RecordingState::Cancelled => {
            ("episodes_cancelled", "these episodes were cancelled; order them again")
        }
        RecordingState::Queued | RecordingState::Running => (
            "episodes_not_ready",
            "these episodes are not recorded yet; ask for their state until it is finished",
        ),
    };
    Err(Problem::new(ProblemType::Conflict, code, detail))
}
