//! The contract against the program: the same types and routes, and no answer it does not declare.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use hyper::Method;
use serde_json::Value;
use tabletopgen::api;

use crate::harness::server::Reply;

static DOCUMENT: LazyLock<Value> = LazyLock::new(api::contract::document);

#[test]
fn each_list_of_words_is_one_named_schema() {
    let mut lists: BTreeMap<String, String> = BTreeMap::new();
    each_schema(&mut |pointer, schema| {
        let Some(words) = schema.get("enum").and_then(Value::as_array) else { return };
        let name = pointer.strip_prefix("/components/schemas/").expect(pointer);
        assert!(!name.contains('/'), "{pointer} lists its words in place; make it a schema of its own");
        let words: BTreeSet<String> = words.iter().map(Value::to_string).collect();
        let other = lists.insert(format!("{words:?}"), name.to_owned());
        assert_eq!(other, None, "{name} has the same words");
    });
    assert!(lists.len() > 15, "{lists:?}");
}

#[test]
fn every_number_states_its_range() {
    let mut count = 0;
    each_schema(&mut |pointer, schema| {
        if types(schema).iter().any(|kind| ["integer", "number"].contains(kind)) {
            assert!(schema["minimum"].is_number() && schema["maximum"].is_number(), "{pointer}");
            count += 1;
        }
    });
    assert!(count > 40, "{count}");
}

#[test]
fn every_object_names_its_fields_and_requests_have_no_others() {
    each_schema(&mut |pointer, schema| {
        if types(schema).contains(&"object") {
            let named = schema["properties"].as_object().is_some_and(|fields| !fields.is_empty());
            let alike = schema["additionalProperties"].is_object();
            let is_foreign = pointer == "/components/schemas/OpenApi";
            assert!(named || alike || is_foreign, "{pointer} names no fields");
        }
    });
    let schemas = &DOCUMENT["components"]["schemas"];
    for name in [
        "TextSubmission",
        "ImageSubmission",
        "SceneForm",
        "FormRequest",
        "Options",
        "TableSpec",
        "Retry",
        "OperationsEdit",
        "InstructionEdit",
        "EditOptions",
        "EditPlace",
        "MoveOperation",
        "BatchRecipe",
        "SeedRange",
        "RecipeProduct",
        "RecipeSample",
        "BatchRequestLine",
        "BatchRequestBody",
        "BatchRetry",
        "DatasetSubmission",
        "DatasetFilter",
        "ExecutionRequest",
        "BasePlace",
        "EpisodesSubmission",
        "EpisodeRecording",
        "EpisodeCamera",
        "RandomizationAmplitudes",
        "Login",
        "NewKey",
    ] {
        assert_eq!(schemas[name]["additionalProperties"], Value::Bool(false), "{name}");
    }
}

#[test]
fn bodies_that_are_files_are_binary() {
    let mut files = 0;
    for item in DOCUMENT["paths"].as_object().unwrap().values() {
        let contents = ["get", "post"].iter().filter_map(|method| item[*method]["responses"].as_object());
        for (kind, media) in contents
            .flat_map(|responses| responses.values())
            .filter_map(|response| resolve(response)["content"].as_object())
            .flatten()
            .filter(|(kind, _)| {
                !kind.ends_with("json") && !kind.starts_with("text/") && !kind.ends_with("yaml")
            })
        {
            assert_eq!(resolve(&media["schema"])["format"], "binary", "{kind}");
            files += 1;
        }
    }
    assert!(files >= 8, "{files}");
}

/// Calls `visit` with every schema of the document and its pointer.
fn each_schema(visit: &mut impl FnMut(&str, &'static Value)) {
    fn walk(value: &'static Value, pointer: &str, visit: &mut impl FnMut(&str, &'static Value)) {
        match value {
            Value::Object(map) => {
                // Examples and links have no schemas, and a field may be named like a keyword.
                let is_schema =
                    ["type", "enum", "oneOf", "const", "properties"].iter().any(|k| map.contains_key(*k));
                if is_schema && !pointer.ends_with("/properties") {
                    visit(pointer, value);
                }
                let inner = map.iter().filter(|(name, _)| !["examples", "links"].contains(&name.as_str()));
                inner.for_each(|(name, value)| walk(value, &format!("{pointer}/{name}"), visit));
            }
            Value::Array(items) => {
                items.iter().enumerate().for_each(|(k, item)| walk(item, &format!("{pointer}/{k}"), visit));
            }
            _ => {}
        }
    }
    walk(&DOCUMENT, "", visit);
}

/// The types that a schema names.
fn types(schema: &'static Value) -> Vec<&'static str> {
    match &schema["type"] {
        Value::String(one) => vec![one],
        Value::Array(some) => some.iter().filter_map(Value::as_str).collect(),
        _ => vec![],
    }
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

/// The contract as the file has it.
pub fn document() -> &'static Value {
    &DOCUMENT
}

/// The schema of a name.
pub fn schema(name: &str) -> &'static Value {
    let schema = &DOCUMENT["components"]["schemas"][name];
    assert!(schema.is_object(), "there is no schema {name}");
    schema
}

/// Panics unless the value fits the schema of that name, and has no field that it lacks.
pub fn hold_schema(name: &str, value: &Value) {
    fits(schema(name), value, "").unwrap_or_else(|why| panic!("{name}: {why}"));
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
    if let Some(choices) = schema["anyOf"].as_array() {
        let faults: Vec<String> = choices.iter().filter_map(|choice| fits(choice, value, at).err()).collect();
        if faults.len() == choices.len() {
            return wrong(format!("no alternative fits: {}", faults.join("; ")));
        }
    }
    let types = types(schema);
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
    let number = value.as_f64();
    if number.zip(schema["minimum"].as_f64()).is_some_and(|(number, low)| number < low)
        || number.zip(schema["maximum"].as_f64()).is_some_and(|(number, high)| number > high)
    {
        return wrong(format!("must be from {} to {}", schema["minimum"], schema["maximum"]));
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
                // What is answered is described, except in objects that are open on purpose. Conditions on fields,
                // which have no type, leave others alone.
                None if types.contains(&"object") && schema["properties"].is_object() => {
                    return wrong(format!("{name} is not described"));
                }
                None if schema["additionalProperties"].is_object() => {
                    fits(&schema["additionalProperties"], inner, &format!("{at}/{name}"))?;
                }
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
