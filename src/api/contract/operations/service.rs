//! Operations of the tag `service`: health, metrics, version, contract.

use super::super::operation::Operation;
use crate::api::index::Index;
use crate::api::probes::OpenApi;
use crate::api::probes::Status;
use crate::api::probes::Version;
use crate::api::queue::QueueView;
use crate::app::catalog::{Catalog, RobotList};
use crate::schemas::datasets::OpenDocument;
use crate::schemas::values::PathText;

/// `GET /`.
pub fn index(operation: &mut Operation<'_>) {
    operation.is("service", "getIndex", "Name, version and paths of the interface; for browsers, its page.");
    operation.answers::<Index>(200, "Where clients begin.");
    operation.answers_nothing(303, "With `Accept text/html`: the address of the page.");
    operation.locates();
}

/// `GET /studio/{name}`.
pub fn studio(operation: &mut Operation<'_>) {
    operation.is("service", "getStudio", "A file of the page for people, or the page itself.");
    operation.path_parameter::<PathText>("name", "Path of a file, or an address of the page.", "index.html");
    operation.answers_file(
        200,
        "The file, in the content coding that the client takes.",
        &["text/html", "*/*"],
    );
    operation.tags();
    operation.answers_nothing(304, "The client has it already.");
    operation.refuses(&[404]);
}

/// `GET /queue`.
pub fn get_queue(operation: &mut Operation<'_>) {
    operation.is(
        "service",
        "getQueue",
        "What waits and what runs, and where; for the operator, of all tenants.",
    );
    operation.answers::<QueueView>(200, "The queue now.");
}

/// `GET /catalog`.
pub fn get_catalog(operation: &mut Operation<'_>) {
    operation.is("service", "getCatalog", "The categories of objects that scenes are made of.");
    operation.answers::<Catalog>(200, "The categories.");
    operation.tags();
    operation.answers_nothing(304, "The client has them already.");
}

/// `GET /robots`.
pub fn list_robots(operation: &mut Operation<'_>) {
    operation.is("service", "listRobots", "The robots that tasks are done with.");
    operation.answers::<RobotList>(200, "The robots.");
}

/// `GET /robots/{robot}/model`.
pub fn get_robot_model(operation: &mut Operation<'_>) {
    operation.is("service", "getRobotModel", "The visible shape of a robot, for viewers.");
    operation.explain(
        "A GLB file whose nodes are the links with all joints at zero, each carried by its parent. The extras of a link \
         that moves are `joint`, `kind` (`revolute` or `prismatic`), `axis` in its own frame, and the source of its \
         position. `arm_joint` is the index in `joint_positions` of a trajectory. For fingers the position is \
         `per_opening_m` times the opening of the gripper, plus `offset`.",
    );
    operation.answers_file(200, "The model.", &["application/octet-stream", "model/gltf-binary"]);
    operation.tags();
    operation.answers_nothing(304, "The client has it already.");
    operation.refuses(&[404]);
}

/// `GET /settings/schema`.
pub fn get_request_schema(operation: &mut Operation<'_>) {
    operation.is("service", "getRequestSchema", "A JSON schema of a request for a scene, for forms.");
    operation.explain(
        "It has every field and option of `POST /scenes` with its range and its meaning, and the settings that a request \
         may change with their types and the values that this server has.",
    );
    operation.answers::<OpenDocument>(200, "A schema by JSON Schema 2020-12.");
}

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
    operation.is("service", "version", "Name and version of the program, and whether it has the page.");
    operation.answers::<Version>(200, "These.");
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
