//! `/datasets`: freeze, list, show, delete, download, verify.
//!
//! A dataset is frozen in the background (see `freezer`). The files of a version never change; each has a strong
//! `ETag`, its SHA-256, and is sent in ranges.

pub(super) mod request;
pub(super) mod views;

use axum::Json;
use axum::http::{HeaderMap, Method, StatusCode};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::accepted::accepted_at;
use super::deletion::{self, gone};
use super::download::{Content, Download, respond};
use super::extract::{JsonBody, PathId, PathName, TenantApi};
use super::idempotency::{IdempotencyKey, KeyScope, scoped};
use super::limits::{check_bytes, refused};
use super::pieces::{self, Piece};
use super::query::{Page, PageSize, PageToken, Parameters};
use crate::problem::{Problem, ProblemType};
use crate::schemas::words;
use ::datasets::tar;
use scene::DatasetId;
use store::Digest;
use store::datasets::{
    DatasetFile, DatasetFilter, DatasetRow, DatasetState, NewDataset, SubmitDatasetOutcome, VerifyOutcome,
};

use request::{DatasetBody, check_source};
use views::{DatasetFileView, DatasetView};

/// `POST /datasets`.
pub async fn submit(
    api: TenantApi,
    IdempotencyKey(idempotency_key): IdempotencyKey,
    JsonBody { value: body, memory: _memory }: JsonBody<DatasetBody>,
) -> Result<Response, Problem> {
    let (name, request) = body.checked()?;
    check_source(&api, &request).await?;
    check_bytes(&api).await?;
    let request = json!(request);
    let new = NewDataset {
        tenant_id: api.tenant_id.clone(),
        body_digest: Digest::of(format!("{name} {request}").as_bytes()),
        name,
        request,
        idempotency_key: scoped(&api, KeyScope::Dataset, idempotency_key.as_deref()),
    };
    match api.store.submit_dataset(new).await? {
        SubmitDatasetOutcome::Created(id) | SubmitDatasetOutcome::Replayed(id) => accepted(&api, &id).await,
        SubmitDatasetOutcome::KeyReused => Err(Problem::key_reused("dataset")),
        SubmitDatasetOutcome::Refused(reached) => Err(refused(reached)),
    }
}

/// Parameters of `GET /datasets`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ListParameters {
    name: Option<String>,
    #[schemars(with = "Option<words::DatasetState>")]
    state: Option<request::StateFilter>,
    page_size: PageSize,
    page_token: Option<PageToken>,
}

/// A page of datasets.
#[derive(Serialize, JsonSchema)]
pub(super) struct DatasetPage {
    datasets: Vec<DatasetView>,
    /// Null on the last page.
    next_page_token: Option<String>,
}

/// `GET /datasets`.
pub async fn list(
    api: TenantApi,
    Parameters(parameters): Parameters<ListParameters>,
) -> Result<Response, Problem> {
    let size = parameters.page_size;
    let filter = DatasetFilter {
        name: parameters.name,
        state: parameters.state.map(|state| state.0),
        before_id: parameters.page_token.and_then(PageToken::last_id),
        limit: size.rows_to_read(),
    };
    let rows = api.store.datasets(&api.tenant_id, filter).await?;
    let Page { rows, next_page_token } = size.page_of(rows, |dataset| PageToken::after(dataset.id.as_str()));
    let page = DatasetPage { datasets: rows.into_iter().map(DatasetView::new).collect(), next_page_token };
    Ok(Json(page).into_response())
}

/// `GET /datasets/{dataset_id}`.
pub async fn show(api: TenantApi, PathId(dataset_id): PathId<DatasetId>) -> Result<Response, Problem> {
    let dataset = find(&api, &dataset_id).await?;
    Ok(Json(DatasetView::new(dataset)).into_response())
}

/// `DELETE /datasets/{dataset_id}`.
pub async fn remove(api: TenantApi, PathId(dataset_id): PathId<DatasetId>) -> Result<StatusCode, Problem> {
    deletion::answer(api.store.delete_dataset(&api.tenant_id, &dataset_id).await?, &dataset_id)
}

/// `POST /datasets/{dataset_id}/verify`.
pub async fn verify(api: TenantApi, PathId(dataset_id): PathId<DatasetId>) -> Result<Response, Problem> {
    find(&api, &dataset_id).await?;
    match api.store.verify_dataset(&api.tenant_id, &dataset_id).await? {
        VerifyOutcome::Accepted => accepted(&api, &dataset_id).await,
        VerifyOutcome::NotFrozen(state) => Err(not_frozen(state)),
        VerifyOutcome::Refused(reached) => Err(refused(reached)),
        VerifyOutcome::NotFound => Err(Problem::not_found("dataset", dataset_id.as_str())),
    }
}

/// The files of a version.
#[derive(Serialize, JsonSchema)]
pub(super) struct DatasetFiles {
    files: Vec<DatasetFileView>,
}

/// `GET /datasets/{dataset_id}/files`.
pub async fn files(api: TenantApi, PathId(dataset_id): PathId<DatasetId>) -> Result<Response, Problem> {
    let dataset = frozen(&api, &dataset_id).await?;
    let files = api.store.dataset_files(&dataset.id).await?;
    let files = files.into_iter().map(|file| DatasetFileView::new(&dataset.id, file)).collect();
    Ok(Json(DatasetFiles { files }).into_response())
}

/// `GET /datasets/{dataset_id}/files/{name}`.
pub async fn download(
    api: TenantApi,
    PathId(dataset_id): PathId<DatasetId>,
    PathName(path): PathName,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let dataset = frozen(&api, &dataset_id).await?;
    let file = api.store.dataset_file(&dataset.id, &path).await?;
    let file = file.ok_or_else(|| Problem::not_found("file of the dataset", &path))?;
    let base = path.rsplit('/').next().unwrap_or_default();
    let name = format!("{}-v{}-{base}", dataset.name, dataset.version.unwrap_or(0));
    let what = Download {
        digest: &file.digest,
        size: file.size,
        media_type: &file.media_type,
        // Pages and documents are shown in place.
        file_name: (file.media_type == "application/x-tar").then_some(name),
        content: Content::Stored,
    };
    respond(&api, &method, &headers, what).await?.ok_or_else(damaged)
}

/// `GET /datasets/{dataset_id}/archive`.
pub async fn archive(
    api: TenantApi,
    PathId(dataset_id): PathId<DatasetId>,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let dataset = frozen(&api, &dataset_id).await?;
    let version = dataset.version.unwrap_or(0);
    let files = api.store.dataset_files(&dataset.id).await?;
    let listed: String = files.iter().map(|file| format!("{} {}\n", file.digest, file.path)).collect();
    let pieces = tar_of(version, files).map_err(|error| {
        tracing::error!(%error, dataset_id = %dataset.id, "a file of a dataset does not fit into an archive");
        let detail = "the files of this dataset do not fit into an archive; download them one by one";
        Problem::new(ProblemType::Internal, "archive_unwritable", detail)
    })?;
    let what = Download {
        // Names and digests determine every byte.
        digest: &Digest::of(format!("v{version}\n{listed}").as_bytes()),
        size: pieces::size(&pieces),
        media_type: "application/x-tar",
        file_name: Some(format!("{}-v{version}.tar", dataset.name)),
        content: Content::Pieces(pieces),
    };
    respond(&api, &method, &headers, what).await?.ok_or_else(damaged)
}

/// The pieces of a tar archive with the folder of a version.
fn tar_of(version: i64, files: Vec<DatasetFile>) -> std::io::Result<Vec<Piece>> {
    let mut pieces = Vec::with_capacity(3 * files.len() + 1);
    for DatasetFile { path, digest, size, .. } in files {
        let header = tar::header(&format!("v{version}/{path}"), size)?;
        let padding = tar::member_bytes(size) - header.len() as u64 - size;
        pieces.push(Piece::Memory(Bytes::copy_from_slice(&header)));
        pieces.push(Piece::Blob(digest, size));
        pieces.push(Piece::Memory(Bytes::from(vec![0; padding as usize])));
    }
    pieces.push(Piece::Memory(Bytes::from(vec![0; tar::END_BYTES as usize])));
    Ok(pieces)
}

fn damaged() -> Problem {
    Problem::new(
        ProblemType::Gone,
        "dataset_damaged",
        "the bytes of this file are lost or damaged; verify the dataset, and freeze its scenes again",
    )
}

/// 202 with the dataset and its address.
async fn accepted(api: &TenantApi, dataset_id: &DatasetId) -> Result<Response, Problem> {
    let view = DatasetView::new(find(api, dataset_id).await?);
    Ok(accepted_at(&view.links.this, &view))
}

/// A dataset that is there.
async fn find(api: &TenantApi, dataset_id: &DatasetId) -> Result<DatasetRow, Problem> {
    match api.store.dataset(&api.tenant_id, dataset_id).await? {
        Some(dataset) if dataset.is_deleted => {
            Err(gone("dataset_deleted", "dataset", "freeze its scenes again"))
        }
        Some(dataset) => Ok(dataset),
        None => Err(Problem::not_found("dataset", dataset_id.as_str())),
    }
}

/// A dataset with a version.
async fn frozen(api: &TenantApi, dataset_id: &DatasetId) -> Result<DatasetRow, Problem> {
    let dataset = find(api, dataset_id).await?;
    if dataset.state == DatasetState::Finished { Ok(dataset) } else { Err(not_frozen(dataset.state)) }
}

fn not_frozen(state: DatasetState) -> Problem {
    let (code, detail) = match state {
        DatasetState::Failed => ("dataset_failed", "this dataset has no files; see its failure"),
        _ => ("dataset_not_ready", "this dataset is not frozen yet; ask for its state until it is finished"),
    };
    Problem::new(ProblemType::Conflict, code, detail)
}
