//! `/batches/{batch_id}/output` and `/errors`: results as JSON lines, streamed page by page, while the batch runs too.

use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use futures::stream;

use super::find;
use crate::api::download::served_as;
use crate::api::extract::{PathId, TenantApi};
use crate::problem::Problem;
use ::batches::{OutputLine, RequestState};
use scene::BatchId;
use store::batches::{ItemRow, OutputKind};
use store::{Store, StoreError};

/// Results that are read and sent together.
const PAGE: u32 = 500;

/// `GET /batches/{batch_id}/output`.
pub async fn output(
    api: TenantApi,
    PathId(batch_id): PathId<BatchId>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    lines(&api, batch_id, &headers, OutputKind::Output).await
}

/// `GET /batches/{batch_id}/errors`.
pub async fn errors(
    api: TenantApi,
    PathId(batch_id): PathId<BatchId>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    lines(&api, batch_id, &headers, OutputKind::Errors).await
}

async fn lines(
    api: &TenantApi,
    batch_id: BatchId,
    headers: &HeaderMap,
    kind: OutputKind,
) -> Result<Response, Problem> {
    find(api, &batch_id).await?;
    let mut fields = HeaderMap::new();
    let media_type = HeaderValue::from_str(served_as(headers, "application/jsonl"));
    fields.insert(header::CONTENT_TYPE, media_type.unwrap_or(HeaderValue::from_static("application/jsonl")));
    fields.insert(header::CACHE_CONTROL, HeaderValue::from_static("private, no-store"));
    Ok((fields, Body::from_stream(pages(api.store.clone(), batch_id, kind))).into_response())
}

/// All results so far. A failing store ends the stream with an error, so that the client sees that it is cut off.
fn pages(
    store: Store,
    batch_id: BatchId,
    kind: OutputKind,
) -> impl stream::Stream<Item = Result<Bytes, StoreError>> {
    stream::try_unfold(Some(0), move |after_place| {
        let (store, batch_id) = (store.clone(), batch_id.clone());
        async move {
            let Some(after_place) = after_place else { return Ok(None) };
            let rows = store.batch_output(&batch_id, kind, after_place, PAGE).await?;
            let is_last = rows.len() < PAGE as usize;
            let next = rows.last().filter(|_| !is_last).map(|row| row.place);
            let text: String = rows.into_iter().map(|row| with_bundle(row).text()).collect();
            Ok(Some((Bytes::from(text), next)))
        }
    })
}

/// A result with the address of its bundle.
fn with_bundle(ItemRow { line, .. }: ItemRow) -> OutputLine {
    let bundle = line.scene_id.as_ref().and_then(|id| match line.state {
        RequestState::Succeeded => Some(format!("/scenes/{id}/bundle")),
        RequestState::Quarantined => Some(format!("/scenes/{id}/bundle?quarantined=true")),
        _ => None,
    });
    OutputLine { bundle, ..line }
}
