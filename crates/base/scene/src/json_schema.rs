//! JSON schemas of files and of the HTTP contract, written from the types that are serialized.
//!
//! Types derive `JsonSchema` where they are. [`file_schema`] makes the schema of a file of one type; the other
//! functions are rules that the HTTP contract has, too. Milliseconds for a file.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value};

/// The schema of files that hold a value of this type, as text. Every object is closed: it has no fields but those of
/// the type.
///
/// # Errors
///
/// If a part of the schema has no JSON form.
pub fn file_schema<T: JsonSchema>(file: &FileSchema) -> Result<String, serde_json::Error> {
    let mut schema = serde_json::to_value(SchemaGenerator::new(settings()).into_root_schema_for::<T>())?;
    let mut document = Map::new();
    if let Some(map) = schema.as_object_mut() {
        for (name, value) in [("$schema", map.shift_remove("$schema")), ("$id", Some(file.id.into()))] {
            document.extend(value.map(|value| (name.to_owned(), value)));
        }
        for (name, value) in [("title", file.title), ("description", file.description)] {
            map.shift_remove(name);
            document.insert(name.to_owned(), value.into());
        }
        let definitions = map.shift_remove("$defs");
        document.append(map);
        document.extend(definitions.map(|definitions| ("$defs".to_owned(), definitions)));
    }
    let mut document = Value::Object(document);
    apply_file_rules(&mut document);
    if let Some(adjust) = file.adjust {
        adjust(&mut document);
    }
    if let Some(definitions) = document.get_mut("$defs").and_then(Value::as_object_mut) {
        definitions.sort_keys();
    }
    Ok(serde_json::to_string_pretty(&document)? + "\n")
}

/// Parts of the schema of a file that its type does not state.
pub struct FileSchema {
    /// A name, not an address.
    pub id: &'static str,
    pub title: &'static str,
    pub description: &'static str,
    /// Adds conditions that no type states.
    pub adjust: Option<fn(&mut Value)>,
}

fn settings() -> SchemaSettings {
    SchemaSettings::draft2020_12().for_serialize()
}

fn apply_file_rules(schema: &mut Value) {
    each_schema(schema, &mut |map| {
        list_words(map);
        let optional = optional_fields(map);
        for (name, field) in map.get_mut("properties").and_then(Value::as_object_mut).into_iter().flatten() {
            if let Some(field) = field.as_object_mut() {
                field.shift_remove("default");
            }
            if optional.contains(name) {
                not_null(field);
            }
        }
        if map.get("type").is_some_and(|kind| kind != "string") {
            map.shift_remove("format");
        }
        join_lines(map);
    });
    close(schema);
}

/// Calls `visit` with a schema and every schema in it, the outer first.
pub fn each_schema(schema: &mut Value, visit: &mut impl FnMut(&mut Map<String, Value>)) {
    match schema {
        Value::Array(items) => items.iter_mut().for_each(|item| each_schema(item, visit)),
        Value::Object(map) => {
            visit(map);
            for (name, inner) in map.iter_mut() {
                match name.as_str() {
                    // Values, and not schemas.
                    "default" | "examples" | "const" | "enum" | "required" => {}
                    // Names of fields may be those of keywords.
                    "properties" | "$defs" | "patternProperties" => {
                        let fields = inner.as_object_mut().into_iter().flatten();
                        fields.for_each(|(_, field)| each_schema(field, visit));
                    }
                    _ => each_schema(inner, visit),
                }
            }
        }
        _ => {}
    }
}

/// Turns an alternative of words that have a description each into one list of words.
pub fn list_words(schema: &mut Map<String, Value>) {
    let word_list = |choice: &Value| -> Option<Vec<Value>> {
        let is_list = choice["type"] == "string" && choice.get("properties").is_none();
        let words = choice.get("const").map(|word| vec![word.clone()]);
        words.or_else(|| choice["enum"].as_array().cloned()).filter(|_| is_list)
    };
    let choices = schema.get("oneOf").and_then(Value::as_array);
    let Some(words) = choices.and_then(|choices| choices.iter().map(word_list).collect::<Option<Vec<_>>>())
    else {
        return;
    };
    schema.shift_remove("oneOf");
    schema.insert("type".to_owned(), "string".into());
    schema.insert("enum".to_owned(), words.concat().into());
}

/// Fields of an object that it may lack.
pub fn optional_fields(schema: &Map<String, Value>) -> Vec<String> {
    let required: Vec<&Value> =
        schema.get("required").and_then(Value::as_array).into_iter().flatten().collect();
    let fields = schema.get("properties").and_then(Value::as_object).into_iter().flatten();
    fields.map(|(name, _)| name.clone()).filter(|name| !required.iter().any(|other| *other == name)).collect()
}

/// Takes null out of the values of a schema.
pub fn not_null(schema: &mut Value) {
    let is_null = |kind: &Value| kind == "null" || kind["type"] == "null";
    let Some(map) = schema.as_object_mut() else { return };
    if let Some(Value::Array(kinds)) = map.get_mut("type") {
        kinds.retain(|kind| !is_null(kind));
        if kinds.len() == 1 {
            let only = kinds.remove(0);
            map.insert("type".to_owned(), only);
        }
    }
    if let Some(Value::Array(choices)) = map.get_mut("anyOf") {
        choices.retain(|choice| !is_null(choice));
        if choices.len() == 1
            && let Value::Object(only) = choices.remove(0)
        {
            map.remove("anyOf");
            map.extend(only);
        }
    }
}

/// Joins the lines of each paragraph of a description.
pub fn join_lines(schema: &mut Map<String, Value>) {
    if let Some(Value::String(text)) = schema.get_mut("description") {
        let paragraphs = text.split("\n\n").map(|paragraph| paragraph.replace('\n', " "));
        *text = paragraphs.collect::<Vec<_>>().join("\n\n");
    }
}

/// Forbids fields that are not listed. Where alternatives add fields to those of an object, the object is closed, and
/// the alternatives are not.
fn close(schema: &mut Value) {
    match schema {
        Value::Array(items) => items.iter_mut().for_each(close),
        Value::Object(map) => {
            let has_fields = map.get("properties").is_some_and(Value::is_object);
            let has_alternatives = ["oneOf", "anyOf", "allOf"].iter().any(|word| map.contains_key(*word));
            if has_fields && has_alternatives {
                map.shift_remove("additionalProperties");
                map.insert("unevaluatedProperties".to_owned(), false.into());
            } else if has_fields {
                map.insert("additionalProperties".to_owned(), false.into());
            }
            for (name, inner) in map.iter_mut() {
                match name.as_str() {
                    "oneOf" | "anyOf" | "allOf" if has_fields => close_fields(inner),
                    "properties" | "$defs" => {
                        inner.as_object_mut().into_iter().flatten().for_each(|(_, field)| close(field));
                    }
                    "default" | "examples" | "const" | "enum" => {}
                    _ => close(inner),
                }
            }
        }
        _ => {}
    }
}

/// Closes the values of the fields of alternatives, which stay open themselves.
fn close_fields(alternatives: &mut Value) {
    for alternative in alternatives.as_array_mut().into_iter().flatten().filter_map(Value::as_object_mut) {
        alternative.shift_remove("additionalProperties");
        for (name, inner) in alternative.iter_mut() {
            match name.as_str() {
                "oneOf" | "anyOf" | "allOf" => close_fields(inner),
                "properties" => {
                    inner.as_object_mut().into_iter().flatten().for_each(|(_, field)| close(field))
                }
                _ => {}
            }
        }
    }
}
