//! `/audit`: the record of changes of a tenant, as pages and as JSON lines.

use axum::Json;
use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use futures::stream;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::download::served_as;
use super::extract::TenantApi;
use super::query::{Page, PageSize, PageToken, Parameters, TenantFilter, Time};
use crate::problem::Problem;
use crate::schemas::values::{Id, TenantName, Timestamp};
use scene::TenantId;
use store::audit::{AuditFilter, AuditRow};
use store::{Store, StoreError};

/// Rows that are read and sent together.
const PAGE: u32 = 500;

/// A change, or an attempt at one.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "AuditEntry")]
pub(super) struct AuditView {
    #[schemars(with = "Id")]
    id: String,
    at: Timestamp,
    #[schemars(with = "TenantName")]
    tenant: TenantId,
    /// `key:` or `session:` with the id of a key, `user:` with the name that a proxy gave, `anonymous`, or
    /// `command line`.
    principal: String,
    /// Address of the client; empty for the command line.
    address: String,
    /// Id of the operation in this document.
    action: String,
    /// Path of the request.
    subject: String,
    /// Status of the answer; 499 where the client went before it.
    #[schemars(range(min = 100, max = 599))]
    status: u16,
}

impl From<AuditRow> for AuditView {
    fn from(AuditRow { id, at_ms, entry }: AuditRow) -> Self {
        Self {
            id,
            at: Timestamp::of_ms(at_ms),
            tenant: entry.tenant_id,
            principal: entry.principal,
            address: entry.address,
            action: entry.action,
            subject: entry.subject,
            status: entry.status,
        }
    }
}

/// Parameters of `GET /audit`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ListParameters {
    tenant: Option<TenantFilter>,
    /// Only what happened then or later.
    since: Option<Time>,
    page_size: PageSize,
    page_token: Option<PageToken>,
}

/// Parameters of `GET /audit/lines`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LineParameters {
    tenant: Option<TenantFilter>,
    /// Only what happened then or later.
    since: Option<Time>,
}

/// A page of the record.
#[derive(Serialize, JsonSchema)]
pub(super) struct AuditPage {
    entries: Vec<AuditView>,
    /// Null on the last page.
    next_page_token: Option<String>,
}

/// `GET /audit`.
pub async fn list(
    api: TenantApi,
    Parameters(parameters): Parameters<ListParameters>,
) -> Result<Response, Problem> {
    let ListParameters { tenant, since, page_size, page_token } = parameters;
    let tenant_id = api.principal.administered(tenant.map(TenantFilter::id))?;
    let filter = AuditFilter {
        since_ms: since.map(Time::as_ms),
        before_id: page_token.and_then(PageToken::last_id),
        limit: page_size.rows_to_read(),
    };
    let rows = api.store.audit(&tenant_id, filter).await?;
    let Page { rows, next_page_token } = page_size.page_of(rows, |row| PageToken::after(&row.id));
    let entries = rows.into_iter().map(AuditView::from).collect();
    Ok(Json(AuditPage { entries, next_page_token }).into_response())
}

/// `GET /audit/lines`.
pub async fn lines(
    api: TenantApi,
    Parameters(LineParameters { tenant, since }): Parameters<LineParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let tenant_id = api.principal.administered(tenant.map(TenantFilter::id))?;
    let mut fields = HeaderMap::new();
    let media_type = HeaderValue::from_str(served_as(&headers, "application/jsonl"));
    fields.insert(header::CONTENT_TYPE, media_type.unwrap_or(HeaderValue::from_static("application/jsonl")));
    fields.insert(header::CACHE_CONTROL, HeaderValue::from_static("private, no-store"));
    let pages = pages(api.store.clone(), tenant_id, since.map(Time::as_ms));
    Ok((fields, Body::from_stream(pages)).into_response())
}

/// All rows, newest first. A failing store ends the stream with an error, so that the client sees that it is cut off.
fn pages(
    store: Store,
    tenant_id: TenantId,
    since_ms: Option<i64>,
) -> impl stream::Stream<Item = Result<Bytes, StoreError>> {
    stream::try_unfold(Some(None), move |before_id: Option<Option<String>>| {
        let (store, tenant_id) = (store.clone(), tenant_id.clone());
        async move {
            let Some(before_id) = before_id else { return Ok(None) };
            let rows = store.audit(&tenant_id, AuditFilter { since_ms, before_id, limit: PAGE }).await?;
            let next = rows.last().filter(|_| rows.len() == PAGE as usize).map(|row| Some(row.id.clone()));
            let text: String =
                rows.into_iter().map(|row| format!("{}\n", json!(AuditView::from(row)))).collect();
            Ok(Some((Bytes::from(text), next)))
        }
    })
}
