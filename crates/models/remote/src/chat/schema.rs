//! JSON schemas of answers, in the subset of strict servers: every property is required, no other is allowed, and the
//! only keywords are `type`, `enum`, `items` and `description`. Ranges are part of descriptions; the parser checks
//! them.

use serde_json::{Map, Value, json};

/// The maximum coordinate of a box: boxes are in thousandths of the image size.
pub(super) const PER_MILLE: f64 = 1000.0;

/// An object with exactly these properties.
pub fn object(properties: &[(&str, Value)]) -> Value {
    let names: Vec<&str> = properties.iter().map(|(name, _)| *name).collect();
    let properties: Map<String, Value> =
        properties.iter().map(|(name, schema)| ((*name).to_owned(), schema.clone())).collect();
    json!({ "type": "object", "properties": properties, "required": names, "additionalProperties": false })
}

/// A list.
pub fn list(items: &Value) -> Value {
    json!({ "type": "array", "items": items })
}

/// A text.
pub fn text(description: &str) -> Value {
    json!({ "type": "string", "description": description })
}

/// A text, or null.
pub fn text_or_null(description: &str) -> Value {
    json!({ "type": ["string", "null"], "description": description })
}

/// An enumeration.
pub fn word<'a>(words: impl IntoIterator<Item = &'a str>) -> Value {
    json!({ "type": "string", "enum": words.into_iter().collect::<Vec<_>>() })
}

/// An enumeration or null.
pub fn word_or_null<'a>(words: impl IntoIterator<Item = &'a str>) -> Value {
    let words: Vec<Value> = words.into_iter().map(|word| json!(word)).chain([Value::Null]).collect();
    json!({ "type": ["string", "null"], "enum": words })
}

/// A number between two others, both included.
pub fn number(low: f64, high: f64, what: &str) -> Value {
    json!({ "type": "number", "description": format!("{what}, {low} to {high}") })
}

/// The same, or null.
pub fn number_or_null(low: f64, high: f64, what: &str) -> Value {
    json!({ "type": ["number", "null"], "description": format!("{what}, {low} to {high}") })
}

/// A yes or no.
pub fn yes_or_no() -> Value {
    json!({ "type": "boolean" })
}

/// A box on the image.
pub fn image_box(low: f64, high: f64) -> Value {
    let side = |name: &str| number(low, high, &format!("{name}, thousandths of the picture"));
    object(&[("x0", side("left")), ("y0", side("top")), ("x1", side("right")), ("y1", side("bottom"))])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rules of strict mode (OpenAI, "Structured Outputs", "Supported schemas").
    fn hold(schema: &Value, at: &str, properties: &mut usize, words: &mut usize, depth: usize) {
        assert!(depth <= 10, "{at} is too deep");
        let map = schema.as_object().expect(at);
        for keyword in map.keys() {
            let known =
                ["type", "enum", "items", "description", "properties", "required", "additionalProperties"];
            assert!(known.contains(&keyword.as_str()), "{at}: {keyword}");
        }
        if schema["type"] == "object" {
            assert_eq!(schema["additionalProperties"], false, "{at}");
            let names: Vec<&String> = schema["properties"].as_object().expect(at).keys().collect();
            assert_eq!(json!(names), schema["required"], "{at}");
            for (name, inner) in schema["properties"].as_object().expect(at) {
                *properties += 1;
                hold(inner, &format!("{at}/{name}"), properties, words, depth + 1);
            }
        }
        if schema["type"] == "array" {
            hold(&schema["items"], &format!("{at}[]"), properties, words, depth + 1);
        }
        *words += schema["enum"].as_array().map_or(0, Vec::len);
    }

    #[test]
    fn schemas_obey_strict_mode() {
        for (index, schema) in crate::chat::all_schemas().iter().enumerate() {
            let (mut properties, mut words) = (0, 0);
            hold(schema, &format!("schema {index}"), &mut properties, &mut words, 0);
            assert!(properties > 1 && properties <= 5000 && words <= 1000, "{index}: {properties}, {words}");
        }
    }
}
