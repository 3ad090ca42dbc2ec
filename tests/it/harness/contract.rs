//! `openapi.yaml` against the program: the same routes, and no answer it does not declare.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use hyper::Method;
use serde_json::Value;
use tabletopgen::api;

use crate::harness::server::Reply;

static DOCUMENT: LazyLock<Value> =
    LazyLock::new(|| serde_norway::from_str(api::probes::OPENAPI).expect("openapi.yaml is YAML"));

#[test]
fn the_document_and_the_router_have_the_same_routes() {
    let methods = ["get", "post", "put", "patch", "delete"];
    let declared: BTreeSet<String> = DOCUMENT["paths"]
        .as_object()
        .unwrap()
        .iter()
        .flat_map(|(path, item)| {
            methods.iter().filter(|method| item.get(**method).is_some()).map(move |m| format!("{m} {path}"))
        })
        .collect();
    let routed: BTreeSet<String> = api::routes()
        .into_iter()
        .map(|(method, path, _)| format!("{} {}", method.as_str().to_lowercase(), path.replace("{*", "{")))
        .collect();
    assert_eq!(declared, routed);
}

#[test]
fn the_document_lists_every_problem_type() {
    let listed = &DOCUMENT["components"]["schemas"]["Problem"]["properties"]["type"]["enum"];
    let listed: BTreeSet<&str> = listed.as_array().unwrap().iter().map(|v| v.as_str().unwrap()).collect();
    let known: Vec<String> = api::error::ProblemType::ALL.iter().map(|kind| kind.uri()).collect();
    assert_eq!(listed, known.iter().map(String::as_str).collect());
}

#[test]
fn references_lead_somewhere() {
    fn walk(value: &'static Value) {
        if let Some(target) = value["$ref"].as_str() {
            assert!(!resolve(value).is_null(), "{target}");
        }
        match value {
            Value::Object(map) => map.values().for_each(walk),
            Value::Array(items) => items.iter().for_each(walk),
            _ => {}
        }
    }
    walk(&DOCUMENT);
}

/// Panics unless the document declares this answer to this request: status, media type, body.
pub fn hold(method: &Method, path_and_query: &str, reply: &Reply) {
    assert!(!reply.header("x-request-id").is_empty(), "every answer has a request id");
    let path = path_and_query.split('?').next().unwrap();
    let what = format!("{method} {path} -> {}", reply.status);
    let Some(item) = path_item(path) else {
        assert_eq!(reply.problem().0, 404, "{what}");
        return;
    };
    let operation = &item[method.as_str().to_lowercase()];
    if operation.is_null() {
        assert_eq!(reply.problem().0, 405, "{what}");
        return;
    }
    let responses = &operation["responses"];
    let status = reply.status.as_str();
    let declared = if responses[status].is_null() && reply.status.is_server_error() {
        &responses["default"]
    } else {
        &responses[status]
    };
    assert!(!declared.is_null(), "{what} is not declared");
    let declared = resolve(declared);
    let kind = reply.header("content-type").split(';').next().unwrap().to_owned();
    let Some(content) = declared["content"].as_object() else {
        assert!(reply.body.is_empty(), "{what} has a body");
        return;
    };
    let media = content.get(&kind).or_else(|| content.get("*/*"));
    let media = media.unwrap_or_else(|| panic!("{what} as {kind:?} is not declared"));
    if kind.ends_with("json") && !media["schema"].is_null() {
        fits(&media["schema"], &reply.json(), "").unwrap_or_else(|why| panic!("{what}: {why}"));
    }
}

/// The declaration of a path: the one with the most literal parts; `{name}` takes the rest.
fn path_item(path: &str) -> Option<&'static Value> {
    let parts: Vec<&str> = path.split('/').collect();
    let paths = DOCUMENT["paths"].as_object().unwrap();
    let matching = paths.iter().filter(|(template, _)| {
        let wanted: Vec<&str> = template.split('/').collect();
        let rest = template.ends_with("{name}");
        (wanted.len() == parts.len() || rest && parts.len() > wanted.len())
            && wanted.iter().zip(&parts).all(|(want, part)| want.starts_with('{') || want == part)
    });
    matching.min_by_key(|(template, _)| template.matches('{').count()).map(|(_, item)| item)
}

fn resolve(value: &'static Value) -> &'static Value {
    match value["$ref"].as_str() {
        Some(target) => resolve(DOCUMENT.pointer(target.trim_start_matches('#')).unwrap_or(&Value::Null)),
        None => value,
    }
}

/// The part of JSON schema the document uses for answers.
fn fits(schema: &'static Value, value: &Value, at: &str) -> Result<(), String> {
    let schema = resolve(schema);
    let wrong = |why: String| Err(format!("{at}: {why}, but it is {value}"));
    if let Some(choices) = schema["oneOf"].as_array() {
        let fitting = choices.iter().filter(|choice| fits(choice, value, at).is_ok()).count();
        if fitting != 1 {
            return wrong(format!("{fitting} alternatives fit"));
        }
    }
    let types: Vec<&str> = match &schema["type"] {
        Value::String(one) => vec![one],
        Value::Array(some) => some.iter().map(|v| v.as_str().unwrap()).collect(),
        _ => vec![],
    };
    let is = |kind: &&str| match *kind {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("type {other}"),
    };
    if !types.is_empty() && !types.iter().any(is) {
        return wrong(format!("must be {types:?}"));
    }
    if schema["enum"].as_array().is_some_and(|words| !words.contains(value)) {
        return wrong(format!("must be one of {}", schema["enum"]));
    }
    if schema.get("const").is_some_and(|only| only != value) {
        return wrong(format!("must be {}", schema["const"]));
    }
    for name in schema["required"].as_array().into_iter().flatten() {
        if value.is_object() && value.get(name.as_str().unwrap()).is_none() {
            return wrong(format!("lacks {name}"));
        }
    }
    if let Some(map) = value.as_object() {
        for (name, inner) in map {
            match schema["properties"].get(name) {
                Some(schema) => fits(schema, inner, &format!("{at}/{name}"))?,
                // What is answered is described, except in objects that are open on purpose.
                None if schema["properties"].is_object() => return wrong(format!("{name} is not described")),
                None => {}
            }
        }
    }
    for (index, inner) in value.as_array().into_iter().flatten().enumerate() {
        if schema["items"].is_object() {
            fits(&schema["items"], inner, &format!("{at}/{index}"))?;
        }
    }
    Ok(())
}
