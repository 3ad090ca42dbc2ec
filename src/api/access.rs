//! Conditions of routes on those who ask.

use axum::http::Method;

use store::scopes::Scope;

/// Condition on the principal of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Everyone; credentials are not even read.
    Public,
    /// Every principal, whatever its scopes are.
    Known,
    /// Principals with a scope. What needs [`Scope::Read`] changes nothing.
    Scope(Scope),
}

impl Access {
    /// The usual one of a method.
    pub fn of(method: &Method) -> Self {
        Self::Scope(match *method {
            Method::GET | Method::HEAD => Scope::Read,
            Method::DELETE => Scope::Delete,
            _ => Scope::Submit,
        })
    }

    /// Whether requests are written to the record of changes.
    pub fn is_recorded(self, method: &Method) -> bool {
        !matches!(*method, Method::GET | Method::HEAD) && self != Self::Scope(Scope::Read)
    }
}
