//! The contract of the interface, written from its routes, extractors and types. `openapi.yaml` is this document; a
//! test compares them.

pub(super) mod operation;
pub(super) mod operations;
pub(super) mod route;

use std::collections::BTreeSet;

use schemars::generate::{Contract, SchemaSettings};
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value, json};

use super::scene_body::SceneBody;
use crate::problem::ProblemDocument;
use crate::schemas::as_objects::{describe_answers, describe_requests};
use operation::Operation;
use scene::json_schema::{join_lines, list_words, not_null};

/// The whole document.
pub fn document() -> Value {
    let (mut read, mut written) = (generator(Contract::Deserialize), generator(Contract::Serialize));
    describe_requests(&mut read);
    describe_answers(&mut written);
    let mut paths: Map<String, Value> = Map::new();
    for route in super::routes() {
        let mut operation = Operation::new(route.path, &mut read, &mut written);
        (route.request)(&mut operation);
        (route.text)(&mut operation);
        operation.guards(route.access);
        let path = paths.entry(route.path.replace("{*", "{")).or_insert_with(|| json!({}));
        path[route.method.as_str().to_lowercase()] = operation.into_document();
    }
    written.subschema_for::<ProblemDocument<'_>>();
    let mut schemas = definitions(written);
    // What is both read and answered is described as it is read, which allows more.
    schemas.extend(definitions(read));
    schemas.sort_keys();
    keep_named(&mut schemas, &json!([paths, refusals()]));
    json!({
        "openapi": "3.1.0",
        "info": info(),
        "servers": [{ "url": "/" }],
        "tags": tags(),
        "paths": paths,
        "components": {
            "headers": headers(),
            "responses": refusals(),
            "schemas": schemas,
            "securitySchemes": security_schemes(),
        },
    })
}

/// The schema of the body of a request for a scene as one object, and the schemas that it refers to.
pub(super) fn scene_request() -> (Value, Map<String, Value>) {
    let mut read = generator(Contract::Deserialize);
    describe_requests(&mut read);
    let mut body = json!(SceneBody::json_schema(&mut read));
    apply_rules(&mut body, false);
    let mut schemas = definitions(read);
    keep_named(&mut schemas, &body);
    (body, schemas)
}

fn info() -> Value {
    json!({
        "title": env!("CARGO_PKG_NAME"),
        "version": env!("CARGO_PKG_VERSION"),
        "summary": "Turns a sentence or one image into a tabletop scene a robot can be trained in.",
        "description": "A scene is what users keep; a job is an operation on it. Submit a scene, follow its job's \
            events, download its bundle. Errors are RFC 9457 problem documents: `type` comes from a closed list, `code` \
            is stable and finer, `detail` says what to change, `errors` points into the body. Every response carries \
            `x-request-id`.\n\n\
            Every object of this document names all of its fields, and every number states its range. New fields may be \
            added to answers; requests with unknown fields are refused. In requests, null means the same as absent, but \
            in a merge patch, where it removes. Bodies of requests are sent as they are: a `Content-Encoding` other than \
             `identity` is refused with 415.",
        "license": { "name": "Apache-2.0", "identifier": "Apache-2.0" },
    })
}

fn tags() -> Value {
    let tags = [
        ("scenes", "Scenes, their bundles and their artifacts."),
        ("batches", "Many requests for scenes that are submitted together."),
        ("datasets", "Frozen, verifiable sets of finished scenes."),
        ("episodes", "Demonstrations of robots in a finished scene, recorded as datasets for policies."),
        ("jobs", "Operations on scenes, their stages and their events."),
        ("access", "Sessions of browsers, keys, and the record of changes."),
        ("webhooks", "Addresses that events are sent to, signed by Standard Webhooks."),
        ("service", "Health, metrics, version, contract."),
    ];
    tags.map(|(name, description)| json!({ "name": name, "description": description })).into_iter().collect()
}

/// Headers of answers.
fn headers() -> Value {
    json!({
        "Location": {
            "description": "URL of the new resource.",
            "schema": { "type": "string", "format": "uri-reference" },
        },
        "PreferenceApplied": {
            "description": "The wait that was granted.",
            "schema": { "type": "string", "examples": ["wait=30"] },
        },
        "ETag": {
            "description": "The SHA-256 of the whole, or of the scene without its job, stages, artifacts and spending, or \
                            of the webhook without its secret; quoted.",
            "schema": { "type": "string", "pattern": "^\"[0-9a-f]{64}\"$" },
        },
        "SetCookie": {
            "description": "The cookie of a session.",
            "schema": { "type": "string" },
        },
        "ContentRange": { "schema": { "type": "string" } },
        "RetryAfter": {
            "description": "Seconds to wait before the request is sent again.",
            "schema": { "type": "integer", "minimum": 1, "maximum": 2678400 },
        },
    })
}

/// Credentials of clients.
fn security_schemes() -> Value {
    json!({
        "key": {
            "type": "http",
            "scheme": "bearer",
            "bearerFormat": "tt_ and 43 characters of base64url",
            "description": "A key. Each operation names the scope that it needs: `read` sees and downloads, `submit` orders \
                work, `delete` removes, `operate` cancels, repeats and verifies, `admin` manages keys and webhooks. A server without \
                authentication needs none; a key that opens nothing is refused there, too.",
        },
        "session": {
            "type": "apiKey",
            "in": "cookie",
            "name": "tt_session",
            "description": "The cookie of `POST /session`, for browsers. A server that is reached by https calls it \
                `__Host-tt_session`.",
        },
    })
}

/// Answers that refuse.
fn refusals() -> Value {
    let content =
        json!({ "application/problem+json": { "schema": { "$ref": "#/components/schemas/Problem" } } });
    json!({
        "Problem": { "description": "Reason of the refusal, and the correction.", "content": content },
        "Busy": {
            "description": "Not now; when to ask again.",
            "headers": { "Retry-After": { "$ref": "#/components/headers/RetryAfter" } },
            "content": content,
        },
    })
}

fn generator(contract: Contract) -> SchemaGenerator {
    let settings = SchemaSettings::draft2020_12().with(|settings| {
        settings.definitions_path = "/components/schemas".into();
        settings.meta_schema = None;
        settings.contract = contract;
    });
    settings.into_generator()
}

/// Removes schemas that nothing refers to. Problems stay, and lines of files, which descriptions name.
fn keep_named(schemas: &mut Map<String, Value>, document: &Value) {
    let mut named: BTreeSet<String> = BTreeSet::new();
    let mut open = vec![document.to_string()];
    let roots = ["BatchRequestLine", "BatchResult", "Problem"].map(str::to_owned);
    let mut found: Vec<String> = roots.into();
    while let Some(text) = open.pop() {
        let references = text.split("\"#/components/schemas/").skip(1);
        found.extend(references.filter_map(|rest| rest.split('"').next()).map(str::to_owned));
        for name in found.drain(..) {
            if let Some(schema) = schemas.get(&name).filter(|_| !named.contains(&name)) {
                open.push(schema.to_string());
                named.insert(name);
            }
        }
    }
    schemas.retain(|name, _| named.contains(name));
}

/// The schemas of a generator by the rules of the contract.
fn definitions(mut generator: SchemaGenerator) -> Map<String, Value> {
    let is_answer = generator.contract().is_serialize();
    let mut schemas = generator.take_definitions(true);
    schemas.values_mut().for_each(|schema| apply_rules(schema, is_answer));
    schemas
}

/// Formats have the names of OpenAPI, descriptions one line for each paragraph, and only simple values a default. A
/// field that an answer may leave out is never null.
pub(crate) fn apply_rules(schema: &mut Value, is_answer: bool) {
    match schema {
        Value::Array(items) => items.iter_mut().for_each(|item| apply_rules(item, is_answer)),
        Value::Object(map) => {
            let required: Vec<Value> =
                map.get("required").and_then(Value::as_array).cloned().unwrap_or_default();
            for (name, field) in
                map.get_mut("properties").and_then(Value::as_object_mut).into_iter().flatten()
            {
                let is_required = required.iter().any(|required| required == name);
                if is_answer && !is_required {
                    not_null(field);
                }
                if let Some(field) = field.as_object_mut()
                    && (is_required || !field.contains_key("type") || !is_simple(field.get("default")))
                {
                    field.shift_remove("default");
                }
            }
            match map.get("format").and_then(Value::as_str) {
                Some("uint64" | "uint") => {
                    map.insert("format".to_owned(), json!("int64"));
                }
                Some("uint32" | "uint16" | "uint8" | "int32" | "double" | "float") => {
                    map.shift_remove("format");
                }
                _ => {}
            }
            list_words(map);
            // New fields may be added to answers.
            if is_answer && map.get("additionalProperties") == Some(&Value::Bool(false)) {
                map.shift_remove("additionalProperties");
            }
            join_lines(map);
            let inner =
                map.iter_mut().filter(|(name, _)| !["default", "examples", "const"].contains(&name.as_str()));
            inner.for_each(|(_, inner)| apply_rules(inner, is_answer));
        }
        _ => {}
    }
}

fn is_simple(value: Option<&Value>) -> bool {
    matches!(value, Some(Value::Bool(_) | Value::Number(_) | Value::String(_)))
}
