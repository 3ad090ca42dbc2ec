//! Schema of the settings that requests may change, from the keys of `config/default.toml`.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, json};
use toml::Value;

use super::keys::{Allowed, Key, keys};
use super::layers::Resolved;
use crate::schemas::scene_settings::SceneSettings;

/// Longest text of a number or a truth value, characters.
const MAX_NUMBER_CHARS: u32 = 100;
/// Longest text of another setting, characters.
const MAX_TEXT_CHARS: u32 = 1000;

/// Names of the schemas of settings that are words.
const NAMES_OF_WORDS: [(&str, &str); 5] = [
    ("export.urdf", "UrdfPaths"),
    ("export.usd", "UsdForm"),
    ("no_room.outcome", "NoSpaceOutcome"),
    ("tsa.origin", "OriginSource"),
    ("tsa.scale", "ScaleSource"),
];

impl JsonSchema for SceneSettings {
    fn schema_name() -> Cow<'static, str> {
        "SceneSettings".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let open = keys().iter().filter_map(|(name, key)| Some((name, key, key.open_to_requests.as_ref()?)));
        let properties: Map<String, serde_json::Value> = open
            .map(|(name, key, allowed)| (name.clone(), property(generator, name, key, allowed)))
            .collect();
        json_schema!({
            "description": "Settings of this scene that differ from the server's, as text; `config/default.toml` says \
                            all about each. Others are its operator's.",
            "type": "object",
            "additionalProperties": false,
            "properties": properties,
        })
    }
}

/// The schema of the same settings for a form: each with its type, its range and the server's value as the default. A
/// request states all of them as text.
pub fn typed_schema(resolved: &Resolved) -> serde_json::Value {
    let open = keys().iter().filter_map(|(name, key)| Some((name, key, key.open_to_requests.as_ref()?)));
    let properties: Map<String, serde_json::Value> = open
        .map(|(name, key, allowed)| (name.clone(), typed_property(key, allowed, resolved.value(name))))
        .collect();
    json!({
        "description": "Settings of this scene that differ from the server's. A request states each as text: `\"true\"`, \
                        `\"0.5\"`.",
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
    })
}

fn typed_property(key: &Key, allowed: &Allowed, value: Option<&Value>) -> serde_json::Value {
    let kind = match &key.default {
        Value::Boolean(_) => "boolean",
        Value::Integer(_) => "integer",
        Value::Float(_) => "number",
        Value::Array(_) => "array",
        _ => "string",
    };
    let default = value.unwrap_or(&key.default);
    let mut schema = json!({ "type": kind, "description": key.meaning, "default": default });
    match allowed {
        // The unit of words lists the words.
        Allowed::Words(words) => schema["enum"] = json!(words),
        Allowed::Range { low, high } => {
            schema["unit"] = json!(key.unit);
            schema["minimum"] = json!(low);
            if let Some(high) = high {
                schema["maximum"] = json!(high);
            }
        }
        Allowed::Anything if kind != "boolean" => schema["unit"] = json!(key.unit),
        Allowed::Anything => {}
    }
    schema
}

/// The schema of one setting.
fn property(generator: &mut SchemaGenerator, name: &str, key: &Key, allowed: &Allowed) -> serde_json::Value {
    let meaning = key.meaning.trim_end_matches('.');
    match (allowed, &key.default) {
        (_, Value::Boolean(_)) => named(generator, "Switch", "A truth value as text.", &["true", "false"]),
        (Allowed::Words(words), _) => {
            let known = NAMES_OF_WORDS.iter().find(|(setting, _)| *setting == name);
            let (_, schema) = known.expect("a test generates the schemas of all settings");
            named(generator, schema, &format!("{meaning}."), words)
        }
        (Allowed::Range { low, high }, default) => {
            let range = high.map_or_else(|| format!("from {low}"), |high| format!("{low} to {high}"));
            let description = format!("{meaning} ({}, {range}).", key.unit);
            described(&description, default, MAX_NUMBER_CHARS)
        }
        (Allowed::Anything, default) => {
            described(&format!("{meaning} ({}).", key.unit), default, MAX_TEXT_CHARS)
        }
    }
}

/// A text, with the default value as an example.
fn described(description: &str, default: &Value, max_chars: u32) -> serde_json::Value {
    let example = default.as_str().map_or_else(|| default.to_string(), str::to_owned);
    json!({ "type": "string", "maxLength": max_chars, "description": description, "examples": [example] })
}

/// A reference to a list of words.
fn named(
    generator: &mut SchemaGenerator,
    name: &str,
    description: &str,
    words: &[impl AsRef<str>],
) -> serde_json::Value {
    let words: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
    let schema = json!({ "type": "string", "description": description, "enum": words });
    generator.definitions_mut().insert(name.to_owned(), schema);
    json!({ "$ref": format!("#/components/schemas/{name}") })
}
