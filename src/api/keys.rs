//! `/keys`: administrators make, list and revoke the keys of their tenant; the operator's those of any.

use axum::Json;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::extract::{JsonBody, JsonRequest, PathId, TenantApi};
use super::query::{Page, PageSize, PageToken, Parameters, TenantFilter};
use crate::problem::{FieldError, Problem};
use crate::schemas::values::{Id, TenantName, Timestamp};
use crate::schemas::words;
use scene::{KeyId, TenantId};
use store::keys::{KeyFilter, KeyRow, MAX_LIFETIME_SECS, MIN_LIFETIME_SECS, NewKey, RevokeOutcome, is_name};
use store::scopes::ScopeSet;
use store::secret::Secret;

/// A key to be made.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "NewKey")]
pub struct KeyDraft {
    /// For people, such as the machine that uses it.
    #[schemars(length(min = 1, max = 100), regex(pattern = r"^[^\x00-\x1F\x7F-\x9F]*$"))]
    name: String,
    #[schemars(with = "Vec<words::Scope>", length(min = 1, max = 5))]
    scopes: ScopeSet,
    /// The key expires after so many seconds; never, where it is absent.
    #[schemars(range(min = MIN_LIFETIME_SECS, max = MAX_LIFETIME_SECS))]
    expires_in_s: Option<u64>,
    /// The operator's administrators may name any; others their own one.
    #[schemars(with = "Option<TenantName>")]
    tenant: Option<TenantId>,
}

impl JsonRequest for KeyDraft {
    type Schema = Self;
    const EXAMPLE: &str = r#"{"name": "robot lab", "scopes": ["read", "submit"], "expires_in_s": 7776000}"#;
}

/// A key without its secret.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Key")]
pub(super) struct KeyView {
    #[schemars(with = "Id")]
    id: KeyId,
    #[schemars(with = "TenantName")]
    tenant: TenantId,
    name: String,
    #[schemars(with = "Vec<words::Scope>")]
    scopes: ScopeSet,
    created_at: Timestamp,
    expires_at: Option<Timestamp>,
    revoked_at: Option<Timestamp>,
    /// To a minute.
    last_used_at: Option<Timestamp>,
    /// The secret, in the answer to its making alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    key: Option<String>,
}

impl KeyView {
    fn new(row: KeyRow, secret: Option<&Secret>) -> Self {
        Self {
            id: row.id,
            tenant: row.tenant_id,
            name: row.name,
            scopes: row.scopes,
            created_at: Timestamp::of_ms(row.created_at_ms),
            expires_at: row.expires_at_ms.map(Timestamp::of_ms),
            revoked_at: row.revoked_at_ms.map(Timestamp::of_ms),
            last_used_at: row.last_used_at_ms.map(Timestamp::of_ms),
            key: secret.map(|secret| secret.expose().to_owned()),
        }
    }
}

/// Parameters of `GET /keys`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ListParameters {
    tenant: Option<TenantFilter>,
    page_size: PageSize,
    page_token: Option<PageToken>,
}

/// Parameters of `DELETE /keys/{key_id}`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RevokeParameters {
    tenant: Option<TenantFilter>,
}

/// A page of keys.
#[derive(Serialize, JsonSchema)]
pub(super) struct KeyPage {
    keys: Vec<KeyView>,
    /// Null on the last page.
    next_page_token: Option<String>,
}

/// `POST /keys`.
pub async fn create(
    api: TenantApi,
    JsonBody { value: draft, memory: _memory }: JsonBody<KeyDraft>,
) -> Result<Response, Problem> {
    let mut errors = Vec::new();
    let mut must = |holds: bool, pointer: &str, detail: String| {
        if !holds {
            errors.push(FieldError::new(pointer, detail));
        }
    };
    must(
        is_name(&draft.name),
        "/name",
        "must have 1 to 100 characters, none of them a control character".into(),
    );
    must(!draft.scopes.is_empty(), "/scopes", "must name a scope, such as read".into());
    let is_lifetime =
        draft.expires_in_s.is_none_or(|seconds| (MIN_LIFETIME_SECS..=MAX_LIFETIME_SECS).contains(&seconds));
    must(is_lifetime, "/expires_in_s", format!("must be from {MIN_LIFETIME_SECS} to {MAX_LIFETIME_SECS}"));
    if !errors.is_empty() {
        return Err(Problem::invalid(errors));
    }
    let new = NewKey {
        tenant_id: api.principal.administered(draft.tenant)?,
        name: draft.name,
        scopes: draft.scopes,
        lifetime_ms: draft.expires_in_s.and_then(|seconds| i64::try_from(seconds * 1000).ok()),
    };
    let (row, secret) = api.store.create_key(new).await?;
    let view = Json(KeyView::new(row, Some(&secret)));
    Ok((StatusCode::CREATED, [(header::CACHE_CONTROL, "no-store")], view).into_response())
}

/// `GET /keys`.
pub async fn list(
    api: TenantApi,
    Parameters(ListParameters { tenant, page_size, page_token }): Parameters<ListParameters>,
) -> Result<Response, Problem> {
    let tenant_id = api.principal.administered(tenant.map(TenantFilter::id))?;
    let filter =
        KeyFilter { before_id: page_token.and_then(PageToken::last_id), limit: page_size.rows_to_read() };
    let rows = api.store.keys(&tenant_id, filter).await?;
    let Page { rows, next_page_token } = page_size.page_of(rows, |key| PageToken::after(key.id.as_str()));
    let keys = rows.into_iter().map(|row| KeyView::new(row, None)).collect();
    Ok(Json(KeyPage { keys, next_page_token }).into_response())
}

/// `DELETE /keys/{key_id}`.
pub async fn revoke(
    api: TenantApi,
    PathId(key_id): PathId<KeyId>,
    Parameters(RevokeParameters { tenant }): Parameters<RevokeParameters>,
) -> Result<StatusCode, Problem> {
    let tenant_id = api.principal.administered(tenant.map(TenantFilter::id))?;
    match api.store.revoke_key(&tenant_id, &key_id).await? {
        RevokeOutcome::Revoked | RevokeOutcome::WasRevoked => Ok(StatusCode::NO_CONTENT),
        RevokeOutcome::NotFound => Err(Problem::not_found("key", key_id.as_str())),
    }
}
