//! The header `Idempotency-Key`: its form, which every route checks, and the scope in which a key is one.
//!
//! A key is stored behind its scope and a space, which no key has. So the same key names different requests of
//! different kinds of operations, and no key of a client is that of a part of another request.

use std::fmt;

use axum::Router;
use axum::extract::{FromRequestParts, Request};
use axum::http::HeaderMap;
use axum::http::request::Parts;
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};

use super::Api;
use super::extract::TenantApi;
use super::principal::Identity;
use crate::problem::{Problem, ProblemType};

/// The kind of what a request with a key makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum KeyScope {
    /// A scene, new or edited.
    Scene,
    /// One of the variants of a request, by its number.
    Variant(usize),
    Batch,
    Dataset,
    Recording,
    Execution,
}

impl fmt::Display for KeyScope {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scene => f.write_str("scene"),
            Self::Variant(index) => write!(f, "variant/{index}"),
            Self::Batch => f.write_str("batch"),
            Self::Dataset => f.write_str("dataset"),
            Self::Recording => f.write_str("recording"),
            Self::Execution => f.write_str("execution"),
        }
    }
}

/// A key as it is stored: unique for the client, the kind of operation and the client's key. Rows have the tenant.
pub(super) fn scoped(api: &TenantApi, scope: KeyScope, key: Option<&str>) -> Option<String> {
    key.map(|key| format!("{}{scope} {key}", client_of(api)))
}

/// Name of the client whose key it is, with a `:`; nothing where they have no names. A session is the client of
/// the key that began it. Scopes have no `:`, so two clients never have the same stored key.
fn client_of(api: &TenantApi) -> String {
    match &api.principal.identity {
        Identity::Anonymous => String::new(),
        Identity::Key(id) | Identity::Session(id) => format!("key:{id}:"),
        Identity::User(name) => format!("user:{name}:"),
    }
}

/// The header `Idempotency-Key` alone.
pub struct IdempotencyKey(pub(super) Option<String>);

impl FromRequestParts<Api> for IdempotencyKey {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Api) -> Result<Self, Problem> {
        idempotency_key(&parts.headers).map(Self)
    }
}

/// Wraps the routes: a key of a wrong form is refused by every one of them, also where it has no effect.
pub(super) fn around(router: Router<Api>, api: &Api) -> Router<Api> {
    router.layer(from_fn_with_state(api.clone(), check))
}

async fn check(request: Request, next: Next) -> Response {
    match idempotency_key(request.headers()) {
        Ok(_) => next.run(request).await,
        Err(problem) => problem.into_response(),
    }
}

/// The idempotency key of a request, if it has one.
///
/// # Errors
///
/// A [`Problem`] for a key of another form, and for several.
pub(super) fn idempotency_key(headers: &HeaderMap) -> Result<Option<String>, Problem> {
    let invalid = |detail| Problem::new(ProblemType::MalformedRequest, "invalid_idempotency_key", detail);
    let mut keys = headers.get_all("idempotency-key").into_iter();
    let Some(key) = keys.next() else { return Ok(None) };
    if keys.next().is_some() {
        return Err(invalid("the request has several headers Idempotency-Key; send one"));
    }
    let key = key.to_str().ok().filter(|key| {
        (1..=255).contains(&key.len()) && key.bytes().all(|byte| (0x21..=0x7e).contains(&byte))
    });
    key.map(|key| Some(key.to_owned()))
        .ok_or_else(|| invalid("Idempotency-Key has 1 to 255 visible ASCII characters, such as a UUID"))
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderValue;

    use super::*;

    fn read(keys: &[&[u8]]) -> Result<Option<String>, &'static str> {
        let mut headers = HeaderMap::new();
        for key in keys {
            headers.append("idempotency-key", HeaderValue::from_bytes(key).expect("a header"));
        }
        idempotency_key(&headers).map_err(|problem| problem.own_code())
    }

    #[test]
    fn a_key_is_one_word_of_visible_characters() {
        assert_eq!(read(&[]), Ok(None));
        assert_eq!(read(&[b"a/0:b"]), Ok(Some("a/0:b".to_owned())));
        let invalid = Err("invalid_idempotency_key");
        for keys in [&[b"".as_slice()][..], &[b"two words"], &[b"\xff"], &[&[b'x'; 256]], &[b"a", b"a"]] {
            assert_eq!(read(keys), invalid, "{keys:?}");
        }
    }

    #[test]
    fn no_two_scopes_have_the_same_form() {
        let scopes = [
            KeyScope::Scene,
            KeyScope::Variant(0),
            KeyScope::Variant(10),
            KeyScope::Batch,
            KeyScope::Dataset,
            KeyScope::Recording,
            KeyScope::Execution,
        ];
        let forms: std::collections::BTreeSet<String> = scopes.iter().map(KeyScope::to_string).collect();
        assert_eq!(forms.len(), scopes.len());
        assert!(forms.iter().all(|form| !form.contains(' ')), "a space ends the scope: {forms:?}");
    }
}
