//! Operations of the tag `access`: sessions, keys, and the record of changes.

use super::super::operation::Operation;
use crate::api::audit::{AuditPage, AuditView};
use crate::api::keys::{KeyPage, KeyView};
use crate::api::session::SessionView;

/// `POST /session`.
pub fn begin_session(operation: &mut Operation<'_>) {
    operation.is("access", "beginSession", "Log a browser in: a key for a cookie.");
    operation.explain(
        "The cookie is `HttpOnly` and `SameSite=Strict`. It has the tenant and the scopes of the key, and ends with it. \
         Programs send the key itself, as `Authorization: Bearer tt_...`.",
    );
    operation.answers_nothing(204, "The cookie is in `Set-Cookie`.");
    operation.sets_cookie();
    operation.refuses(&[401]);
}

/// `GET /session`.
pub fn get_session(operation: &mut Operation<'_>) {
    operation.is("access", "getSession", "Who asks, with tenant and scopes, and what this server accepts.");
    operation.answers::<SessionView>(200, "The principal of this request.");
}

/// `DELETE /session`.
pub fn end_session(operation: &mut Operation<'_>) {
    operation.is("access", "endSession", "Log a browser out.");
    operation
        .answers_nothing(204, "The session has ended, if there was one; `Set-Cookie` removes its cookie.");
    operation.sets_cookie();
}

/// `POST /keys`.
pub fn create_key(operation: &mut Operation<'_>) {
    operation.is("access", "createKey", "Make a key. The answer is the only place that shows it.");
    operation.answers::<KeyView>(201, "The key with its secret.");
    operation.links("revocation", "revokeKey", &[("key_id", "$response.body#/id")]);
}

/// `GET /keys`.
pub fn list_keys(operation: &mut Operation<'_>) {
    operation.is("access", "listKeys", "Keys without their secrets, newest first.");
    operation.answers::<KeyPage>(200, "A page; keys that are revoked or have expired are in it, too.");
    operation.links("first", "revokeKey", &[("key_id", "$response.body#/keys/0/id")]);
}

/// `DELETE /keys/{key_id}`.
pub fn revoke_key(operation: &mut Operation<'_>) {
    operation.is("access", "revokeKey", "Revoke a key and end its sessions; twice is fine.");
    operation.answers_nothing(204, "It opens nothing any more.");
}

/// `GET /audit`.
pub fn list_audit(operation: &mut Operation<'_>) {
    operation.is("access", "listAudit", "The record of changes, newest first.");
    operation.explain(
        "Every request that may change something is recorded with its principal, its client's address and the status of \
         its answer. Of requests that were refused or failed, a bounded number is recorded each minute.",
    );
    operation.answers::<AuditPage>(200, "A page.");
}

/// `GET /audit/lines`.
pub fn export_audit(operation: &mut Operation<'_>) {
    operation.is(
        "access",
        "exportAudit",
        "The record of changes as JSON lines, newest first, each an `AuditEntry`.",
    );
    operation.mentions::<(), AuditView>();
    operation.answers_file(200, "The lines.", &["application/jsonl", "application/octet-stream"]);
}
