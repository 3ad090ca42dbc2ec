//! The gate before each handler: who asks, whether that suffices for the route, and the record of what was changed.
//!
//! It lies inside of the admission by hosts, so that a page of another site is refused before a credential is read. The
//! principal is found once for each request, and handlers take their tenant from it.

use std::net::IpAddr;
use std::sync::Arc;

use axum::extract::{Request, State};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::MethodRouter;
use tracing::Span;

use super::Api;
use super::access::Access;
use super::contract::route::Route;
use super::principal::{Principal, Refused, resolve};
use super::serve::connection::Connection;
use crate::path_without_keys::path_without_keys;
use crate::problem::Problem;
use store::audit::AuditEntry;

#[derive(Clone)]
struct Gate {
    api: Api,
    access: Access,
    /// Id of the operation in the contract.
    action: Arc<str>,
    is_recorded: bool,
}

/// The handler of a route behind its gate.
pub(super) fn around(route: Route, api: &Api) -> MethodRouter<Api> {
    if route.access == Access::Public {
        return route.handler;
    }
    let gate = Gate {
        api: api.clone(),
        access: route.access,
        action: route.operation_id().into(),
        is_recorded: route.access.is_recorded(&route.method),
    };
    route.handler.route_layer(from_fn_with_state(gate, pass))
}

async fn pass(State(gate): State<Gate>, request: Request, next: Next) -> Response {
    let (mut parts, body) = request.into_parts();
    let peer = parts.extensions.get::<Arc<Connection>>().map(|connection| connection.peer);
    let address = peer.map(|peer| gate.api.proxies.client_ip(peer, &parts.headers));
    let subject = path_without_keys(parts.uri.path()).into_owned();
    let principal = match resolve(&gate.api, &parts.headers, peer).await {
        Ok(principal) => principal,
        Err(refused) => return gate.refuse(refused, address, subject).await,
    };
    let name = principal.identity.name();
    Span::current().record("principal", &name).record("tenant", principal.tenant_id.as_str());
    if let Access::Scope(scope) = gate.access
        && let Err(problem) = principal.check(scope)
    {
        let refused = Refused { problem: Box::new(problem), tenant_id: principal.tenant_id, name };
        return gate.refuse(refused, address, subject).await;
    }
    let recorded = gate.is_recorded.then(|| {
        gate.api.audit_trail.begin(gate.entry(&principal, address, subject), address.map(Into::into))
    });
    if let Some(recorded) = &recorded {
        parts.extensions.insert(recorded.record());
    }
    parts.extensions.insert(principal);
    let response = next.run(Request::from_parts(parts, body)).await;
    if let Some(recorded) = recorded {
        recorded.end(response.status()).await;
    }
    response
}

impl Gate {
    fn entry(&self, principal: &Principal, address: Option<IpAddr>, subject: String) -> AuditEntry {
        AuditEntry {
            tenant_id: principal.tenant_id.clone(),
            principal: principal.identity.name(),
            address: address.map(|address| address.to_string()).unwrap_or_default(),
            action: self.action.to_string(),
            subject,
            status: 0,
        }
    }

    /// Answers with a refusal, which is recorded, too, also where the route changes nothing.
    async fn refuse(&self, refused: Refused, address: Option<IpAddr>, subject: String) -> Response {
        let Refused { problem, tenant_id, name } = refused;
        Span::current().record("principal", &name).record("tenant", tenant_id.as_str());
        count_refusal(&problem);
        let entry = AuditEntry {
            tenant_id,
            principal: name,
            address: address.map(|address| address.to_string()).unwrap_or_default(),
            action: self.action.to_string(),
            subject,
            status: 0,
        };
        let recorded = self.api.audit_trail.begin(entry, address.map(Into::into));
        let response = (*problem).into_response();
        recorded.end(response.status()).await;
        response
    }
}

/// Counts a refusal by its reason as metrics have it.
fn count_refusal(problem: &Problem) {
    let reason = match problem.kind.status() {
        401 => "credential",
        403 => "scope",
        _ => return,
    };
    metrics::counter!("tabletopgen_requests_refused_total", "reason" => reason).increment(1);
}
