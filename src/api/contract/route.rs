//! A route: method, path and handler, with the description of the operation.

use axum::handler::Handler;
use axum::http::Method;
use axum::routing::{self, MethodRouter};

use super::operation::{DescribedHandler, Operation};
use crate::api::Api;

/// Describes a part of an operation.
type Description = fn(&mut Operation<'_>);

/// A route of the interface.
pub struct Route {
    pub method: Method,
    pub path: &'static str,
    pub handler: MethodRouter<Api>,
    /// Request, as the extractors of the handler read it.
    pub request: Description,
    /// The rest, which no type says.
    pub text: Description,
}

/// A route of the method GET.
pub fn get<H, T, I>(path: &'static str, handler: H, text: Description) -> Route
where
    H: Handler<T, Api> + DescribedHandler<I>,
    T: 'static,
{
    Route { method: Method::GET, path, handler: routing::get(handler), request: H::describe, text }
}

/// A route of the method POST.
pub fn post<H, T, I>(path: &'static str, handler: H, text: Description) -> Route
where
    H: Handler<T, Api> + DescribedHandler<I>,
    T: 'static,
{
    Route { method: Method::POST, path, handler: routing::post(handler), request: H::describe, text }
}

/// A route of the method PATCH.
pub fn patch<H, T, I>(path: &'static str, handler: H, text: Description) -> Route
where
    H: Handler<T, Api> + DescribedHandler<I>,
    T: 'static,
{
    Route { method: Method::PATCH, path, handler: routing::patch(handler), request: H::describe, text }
}

/// A route of the method DELETE.
pub fn delete<H, T, I>(path: &'static str, handler: H, text: Description) -> Route
where
    H: Handler<T, Api> + DescribedHandler<I>,
    T: 'static,
{
    Route { method: Method::DELETE, path, handler: routing::delete(handler), request: H::describe, text }
}
