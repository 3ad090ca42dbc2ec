//! Operations of the tag `service`: health, metrics, version, contract.

use super::super::operation::Operation;
use crate::api::probes::OpenApi;
use crate::api::probes::Status;
use crate::api::probes::Version;

/// `GET /healthz`.
pub fn healthz(operation: &mut Operation<'_>) {
    operation.is("service", "healthz", "The process answers.");
    operation.answers::<Status>(200, "The process answers.");
}

/// `GET /readyz`.
pub fn readyz(operation: &mut Operation<'_>) {
    operation.is("service", "readyz", "The process takes new work.");
    operation.answers::<Status>(200, "The process takes new work.");
}

/// `GET /metrics`.
pub fn metrics(operation: &mut Operation<'_>) {
    operation.is("service", "metrics", "Prometheus metrics.");
    operation.answers_file(200, "Text exposition format 0.0.4.", &["text/plain"]);
}

/// `GET /version`.
pub fn version(operation: &mut Operation<'_>) {
    operation.is("service", "version", "Name and version of the program.");
    operation.answers::<Version>(200, "Both.");
}

/// `GET /openapi.yaml`.
pub fn openapi(operation: &mut Operation<'_>) {
    operation.is("service", "openapi", "This document.");
    operation.answers_file(
        200,
        "It; as `application/octet-stream` for clients that accept only that.",
        &["application/octet-stream"],
    );
    operation.answers_in::<OpenApi>(
        200,
        "It; as `application/octet-stream` for clients that accept only that.",
        "application/yaml",
    );
}
