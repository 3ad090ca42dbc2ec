//! Principals: on whose behalf a request comes, with tenant and scopes.
//!
//! A request has the first of these that it states: a key (`Authorization: Bearer tt_...`), the cookie of a session, a
//! user whom a proxy names. A credential that opens nothing is refused even where none is needed, so that no client is
//! served as another principal than it asks to be. Without any, the mode of the server decides.

use std::net::IpAddr;

use axum::http::{HeaderMap, header};

use super::Api;
use super::authentication::Mode;
use crate::problem::{Problem, ProblemType};
use scene::{KeyId, TenantId};
use store::DEFAULT_TENANT;
use store::keys::{Grant, Validity};
use store::scopes::{Scope, ScopeSet};
use store::secret::{KEY_PREFIX, Secret};

/// On whose behalf a request comes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Principal {
    pub tenant_id: TenantId,
    pub scopes: ScopeSet,
    pub identity: Identity,
    /// Time until which the credential lasts, milliseconds since 1970.
    pub expires_at_ms: Option<i64>,
}

/// Credential that a principal is known by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Identity {
    /// Nothing: the server needs no credentials.
    Anonymous,
    Key(KeyId),
    /// A session that was begun with this key.
    Session(KeyId),
    /// The name that a proxy gives.
    User(String),
}

impl Identity {
    /// The name in the log and in the record of changes.
    pub fn name(&self) -> String {
        match self {
            Self::Anonymous => "anonymous".to_owned(),
            Self::Key(id) => format!("key:{id}"),
            Self::Session(id) => format!("session:{id}"),
            Self::User(name) => format!("user:{name}"),
        }
    }
}

/// The refusal of a credential, with what is known of its owner.
#[derive(Debug)]
pub struct Refused {
    pub problem: Box<Problem>,
    pub tenant_id: TenantId,
    pub name: String,
}

impl Principal {
    /// Refuses a principal without a scope.
    ///
    /// # Errors
    ///
    /// 403 `scope_missing`.
    pub fn check(&self, scope: Scope) -> Result<(), Problem> {
        if self.scopes.contains(scope) {
            return Ok(());
        }
        let held = if self.scopes.is_empty() { "none".to_owned() } else { self.scopes.to_string() };
        let detail = format!(
            "this needs the scope {scope}, and your scopes are: {held}; ask an administrator for a key with it"
        );
        Err(Problem::new(ProblemType::Forbidden, "scope_missing", detail))
    }

    /// The tenant that an administrator asks about: its own one, or any if it is of the operator's tenant.
    ///
    /// # Errors
    ///
    /// 403 `other_tenant`.
    pub fn administered(&self, named: Option<TenantId>) -> Result<TenantId, Problem> {
        match named {
            None => Ok(self.tenant_id.clone()),
            Some(named) if named == self.tenant_id || self.tenant_id == *DEFAULT_TENANT => Ok(named),
            Some(_) => {
                let detail =
                    "only the operator, an administrator of the tenant default, may name another tenant";
                Err(Problem::new(ProblemType::Forbidden, "other_tenant", detail))
            }
        }
    }
}

/// The principal of a request from this peer.
///
/// # Errors
///
/// A [`Refused`] credential, a missing one, or a store that does not answer.
pub async fn resolve(api: &Api, headers: &HeaderMap, peer: Option<IpAddr>) -> Result<Principal, Refused> {
    let authorization = Authorization::of(headers);
    if let Authorization::Key(key) = &authorization {
        let grant = api.store.key_grant(&key.digest()).await.map_err(|error| refused(error.into()))?;
        return granted(grant, Identity::Key);
    }
    let user = api.proxy_headers.user(&api.proxies, peer, headers);
    let needs_credential = api.settings.authentication.mode == Mode::Keys;
    // Where none is needed, and behind a proxy that authenticates, the header may be meant for the proxy.
    if authorization == Authorization::Other && needs_credential && matches!(user, Ok(None)) {
        return Err(refused(invalid()));
    }
    if let Some(session) = api.session_cookie.read(headers) {
        let grant = api.store.session_grant(&session.digest()).await;
        return granted(grant.map_err(|error| refused(error.into()))?, Identity::Session);
    }
    match user {
        Ok(Some(user)) => Ok(Principal {
            tenant_id: user.tenant_id,
            scopes: user.scopes,
            identity: Identity::User(user.name),
            expires_at_ms: None,
        }),
        Ok(None) if needs_credential => Err(refused(missing())),
        Ok(None) => Ok(Principal {
            tenant_id: DEFAULT_TENANT.clone(),
            scopes: ScopeSet::all(),
            identity: Identity::Anonymous,
            expires_at_ms: None,
        }),
        Err(error) => Err(refused(unauthorized("credential_invalid", error.to_string()))),
    }
}

/// The header `Authorization`.
#[derive(PartialEq, Eq)]
enum Authorization {
    None,
    Key(Secret),
    /// Something that is no key of this program.
    Other,
}

impl Authorization {
    fn of(headers: &HeaderMap) -> Self {
        let mut values = headers.get_all(header::AUTHORIZATION).into_iter();
        let Some(value) = values.next() else { return Self::None };
        let value = value.to_str().ok().filter(|_| values.next().is_none());
        let token = value.and_then(|value| value.split_once(' ')).filter(|(scheme, _)| is_bearer(scheme));
        match token.map(|(_, token)| token.trim()) {
            Some(token) if token.starts_with(KEY_PREFIX) => Self::Key(Secret::given(token)),
            _ => Self::Other,
        }
    }
}

fn is_bearer(scheme: &str) -> bool {
    scheme.eq_ignore_ascii_case("bearer")
}

/// The principal of a grant that is valid.
pub(super) fn granted(
    grant: Option<Grant>,
    identity: impl FnOnce(KeyId) -> Identity,
) -> Result<Principal, Refused> {
    let Some(grant) = grant else { return Err(refused(invalid())) };
    let problem = match grant.validity {
        Validity::Valid => {
            return Ok(Principal {
                tenant_id: grant.tenant_id,
                scopes: grant.scopes,
                identity: identity(grant.key_id),
                expires_at_ms: grant.expires_at_ms,
            });
        }
        Validity::Expired => unauthorized(
            "credential_expired",
            "this key or session has expired; ask for a new key, or log in",
        ),
        Validity::Revoked => {
            unauthorized("credential_revoked", "this key was revoked; ask an administrator for a new one")
        }
    };
    Err(Refused {
        problem: Box::new(problem),
        tenant_id: grant.tenant_id,
        name: identity(grant.key_id).name(),
    })
}

/// A refusal of which no owner is known; the operator's record has it.
fn refused(problem: Problem) -> Refused {
    Refused {
        problem: Box::new(problem),
        tenant_id: DEFAULT_TENANT.clone(),
        name: Identity::Anonymous.name(),
    }
}

fn missing() -> Problem {
    let detail = "this server wants a key: send Authorization: Bearer tt_..., or log in at POST /session";
    unauthorized("credential_missing", detail)
}

fn invalid() -> Problem {
    let detail = "no key or session of this server matches what was sent; compare it with the key that you were given, or \
                  log in again";
    unauthorized("credential_invalid", detail)
}

fn unauthorized(code: &'static str, detail: impl Into<String>) -> Problem {
    Problem::new(ProblemType::Unauthorized, code, detail)
}
