//! A route: method, path and handler, with the description of the operation.

use axum::handler::Handler;
use axum::http::Method;
use axum::routing::{self, MethodFilter, MethodRouter};
use schemars::SchemaGenerator;

use super::operation::{DescribedHandler, Operation};
use crate::api::Api;
use crate::api::access::Access;
use store::scopes::Scope;

/// Describes a part of an operation.
type Description = fn(&mut Operation<'_>);

/// A route of the interface.
pub struct Route {
    pub method: Method,
    pub path: &'static str,
    pub handler: MethodRouter<Api>,
    /// Condition on those who use it.
    pub access: Access,
    /// Request, as the extractors of the handler read it.
    pub request: Description,
    /// The rest, which no type says.
    pub text: Description,
}

impl Route {
    /// Needs a scope that is not the usual one of its method.
    pub fn needs(self, scope: Scope) -> Self {
        Self { access: Access::Scope(scope), ..self }
    }

    /// Is for every principal, whatever its scopes are.
    pub fn for_all_known(self) -> Self {
        Self { access: Access::Known, ..self }
    }

    /// Is for everyone.
    pub fn public(self) -> Self {
        Self { access: Access::Public, ..self }
    }

    /// Id of the operation in the contract.
    pub fn operation_id(&self) -> String {
        let (mut read, mut written) = (SchemaGenerator::default(), SchemaGenerator::default());
        let mut operation = Operation::new(self.path, &mut read, &mut written);
        (self.request)(&mut operation);
        (self.text)(&mut operation);
        operation.id().to_owned()
    }
}

fn new<H, T, I>(method: Method, path: &'static str, handler: H, text: Description) -> Route
where
    H: Handler<T, Api> + DescribedHandler<I>,
    T: 'static,
{
    let access = Access::of(&method);
    let filter = MethodFilter::try_from(method.clone()).unwrap_or(MethodFilter::GET);
    Route { method, path, handler: routing::on(filter, handler), access, request: H::describe, text }
}

/// A route of the method GET.
pub fn get<H, T, I>(path: &'static str, handler: H, text: Description) -> Route
where
    H: Handler<T, Api> + DescribedHandler<I>,
    T: 'static,
{
    new(Method::GET, path, handler, text)
}

/// A route of the method POST.
pub fn post<H, T, I>(path: &'static str, handler: H, text: Description) -> Route
where
    H: Handler<T, Api> + DescribedHandler<I>,
    T: 'static,
{
    new(Method::POST, path, handler, text)
}

/// A route of the method PATCH.
pub fn patch<H, T, I>(path: &'static str, handler: H, text: Description) -> Route
where
    H: Handler<T, Api> + DescribedHandler<I>,
    T: 'static,
{
    new(Method::PATCH, path, handler, text)
}

/// A route of the method DELETE.
pub fn delete<H, T, I>(path: &'static str, handler: H, text: Description) -> Route
where
    H: Handler<T, Api> + DescribedHandler<I>,
    T: 'static,
{
    new(Method::DELETE, path, handler, text)
}
