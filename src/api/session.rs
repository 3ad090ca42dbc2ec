//! `/session`: a browser gives a key once, and then has a cookie that scripts cannot read.

use std::sync::Arc;

use axum::extract::{FromRequest, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Api;
use super::authentication::Mode;
use super::extract::{JsonBody, JsonRequest, TenantApi};
use super::principal::{Identity, Principal, Refused, granted};
use super::serve::connection::Connection;
use crate::problem::{FieldError, Problem, ProblemType};
use crate::schemas::values::{MAX_INTEGER, TenantName, Timestamp};
use crate::schemas::words;
use scene::TenantId;
use store::audit::AuditEntry;
use store::scopes::ScopeSet;
use store::secret::Secret;

/// The key of one who logs in.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Login")]
pub struct LoginBody {
    #[schemars(length(min = 1, max = 200))]
    key: String,
}

impl JsonRequest for LoginBody {
    type Schema = Self;
    const EXAMPLE: &str = r#"{"key": "tt_0123456789abcdefghijklmnopqrstuvwxyzABCDEFG"}"#;
}

/// The key out of the body of a login. A refusal repeats nothing of the body: the key may be anywhere in it.
pub struct GivenKey(Secret);

impl FromRequest<Api> for GivenKey {
    type Rejection = Problem;

    async fn from_request(request: Request, api: &Api) -> Result<Self, Problem> {
        let body = JsonBody::<LoginBody>::from_request(request, api).await;
        body.map(|body| Self(Secret::given(&body.value.key))).map_err(|problem| match problem.kind {
            ProblemType::InvalidRequest | ProblemType::MalformedRequest => {
                let detail = "must be an object with the key and nothing else: {\"key\": \"tt_...\"}";
                Problem::invalid(vec![FieldError::new("", detail)])
            }
            _ => problem,
        })
    }
}

/// The principal of a request, and what this server accepts.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Session")]
pub(super) struct SessionView {
    kind: PrincipalKind,
    /// Name in the log and in the record of changes.
    principal: String,
    #[schemars(with = "TenantName")]
    tenant: TenantId,
    #[schemars(with = "Vec<words::Scope>")]
    scopes: ScopeSet,
    /// Null where it does not expire.
    expires_at: Option<Timestamp>,
    authentication: AuthenticationMode,
    limits: RequestLimits,
}

/// Credential of a principal: none, a key, a session, or the name that a proxy gives.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum PrincipalKind {
    Anonymous,
    Key,
    Session,
    User,
}

/// Whether clients need a credential: with `none`, everyone is the tenant `default` with all scopes.
#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum AuthenticationMode {
    None,
    Keys,
}

/// Sizes of what this server accepts.
#[derive(Serialize, JsonSchema)]
struct RequestLimits {
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    max_body_bytes: usize,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    max_image_bytes: usize,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    max_image_pixels: u64,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    max_text_chars: usize,
}

/// `POST /session`.
pub async fn begin(
    State(api): State<Api>,
    connection: Option<Extension<Arc<Connection>>>,
    headers: HeaderMap,
    GivenKey(key): GivenKey,
) -> Result<Response, Problem> {
    let address = connection.map(|Extension(connection)| api.proxies.client_ip(connection.peer, &headers));
    if !api.logins.admit(address.map(Into::into)) {
        metrics::counter!("tabletopgen_requests_refused_total", "reason" => "logins").increment(1);
        let detail = "too many logins from this address; try again in a minute";
        return Err(Problem::new(ProblemType::TooManyRequests, "too_many_logins", detail));
    }
    let session = Secret::new_session()?;
    let lifetime_ms =
        i64::try_from(api.settings.authentication.session_secs).unwrap_or(i64::MAX / 1000) * 1000;
    let grant = api.store.begin_session(&key.digest(), &session.digest(), lifetime_ms).await?;
    let now_ms = grant.as_ref().map_or(0, |grant| grant.now_ms);
    let begun = granted(grant, Identity::Session);
    let (tenant_id, principal, status) = match &begun {
        Ok(principal) => (&principal.tenant_id, principal.identity.name(), StatusCode::NO_CONTENT),
        Err(Refused { tenant_id, name, .. }) => (tenant_id, name.clone(), StatusCode::UNAUTHORIZED),
    };
    let entry = AuditEntry {
        tenant_id: tenant_id.clone(),
        principal,
        address: address.map(|address| address.to_string()).unwrap_or_default(),
        action: "beginSession".to_owned(),
        subject: "/session".to_owned(),
        status: status.as_u16(),
    };
    api.audit_trail.begin(entry, address.map(Into::into)).end(status).await;
    let principal = begun.map_err(|refused| *refused.problem)?;
    let seconds = principal.expires_at_ms.map_or(0, |end| (end - now_ms) / 1000);
    Ok(with_cookie(api.session_cookie.write(&session, seconds)))
}

/// `GET /session`.
pub async fn show(api: TenantApi) -> Response {
    let Principal { tenant_id, scopes, identity, expires_at_ms } = api.principal.clone();
    let settings = &api.settings;
    let view = SessionView {
        kind: match &identity {
            Identity::Anonymous => PrincipalKind::Anonymous,
            Identity::Key(_) => PrincipalKind::Key,
            Identity::Session(_) => PrincipalKind::Session,
            Identity::User(_) => PrincipalKind::User,
        },
        principal: identity.name(),
        tenant: tenant_id,
        scopes,
        expires_at: expires_at_ms.map(Timestamp::of_ms),
        authentication: match settings.authentication.mode {
            Mode::None => AuthenticationMode::None,
            Mode::Keys => AuthenticationMode::Keys,
        },
        limits: RequestLimits {
            max_body_bytes: settings.max_body_bytes,
            max_image_bytes: settings.max_image_bytes,
            max_image_pixels: settings.max_image_pixels,
            max_text_chars: settings.max_text_chars,
        },
    };
    ([(header::CACHE_CONTROL, "no-store")], Json(view)).into_response()
}

/// `DELETE /session`: also of one that has ended already, so that a browser can always forget its cookie.
pub async fn end(State(api): State<Api>, headers: HeaderMap) -> Result<Response, Problem> {
    if let Some(session) = api.session_cookie.read(&headers) {
        api.store.end_session(&session.digest()).await?;
    }
    Ok(with_cookie(api.session_cookie.remove()))
}

/// 204 with a cookie.
fn with_cookie(cookie: Option<HeaderValue>) -> Response {
    let mut response = StatusCode::NO_CONTENT.into_response();
    let headers = response.headers_mut();
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    if let Some(cookie) = cookie {
        headers.insert(header::SET_COOKIE, cookie);
    }
    response
}
