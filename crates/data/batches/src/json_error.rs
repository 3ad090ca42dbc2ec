//! Errors of JSON documents with their place: a pointer into the document, and the column where the text stops being
//! what is expected.

use serde::de::DeserializeOwned;
use serde_json::Value;
use serde_json::error::Category;
use serde_path_to_error::Segment;

/// Error of reading a text as a value of a type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct JsonError {
    /// Whether the text is no JSON at all.
    pub is_malformed: bool,
    /// Line in the text, from 1.
    pub line: usize,
    /// Column in bytes, from 1; 0 where it is unknown.
    pub column: usize,
    /// JSON pointer of the value; empty for the whole document.
    pub pointer: String,
    pub detail: String,
}

/// A value out of a JSON object. `objects` are pointers to what must be no list: serde would read its items as the
/// fields of a struct in order.
pub(crate) fn parse<T: DeserializeOwned>(bytes: &[u8], objects: &[&str]) -> Result<T, JsonError> {
    if bytes.trim_ascii_start().starts_with(b"[") {
        return Err(JsonError { line: 1, column: 1, ..list_at("") });
    }
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let value = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let pointer = pointer_of(error.path());
        described(&error.into_inner(), pointer)
    })?;
    json.end().map_err(|error| described(&error, String::new()))?;
    match serde_json::from_slice(bytes).ok().and_then(|read| list_for_object(&read, objects)) {
        Some(error) => Err(error),
        None => Ok(value),
    }
}

/// Converts a value that was read; the error has no column.
pub(crate) fn convert<T: DeserializeOwned>(value: &Value, objects: &[&str]) -> Result<T, JsonError> {
    if let Some(error) = list_for_object(value, objects) {
        return Err(error);
    }
    serde_path_to_error::deserialize(value).map_err(|error| {
        let pointer = pointer_of(error.path());
        described(&error.into_inner(), pointer)
    })
}

fn list_for_object(value: &Value, objects: &[&str]) -> Option<JsonError> {
    let is_list = |pointer: &&&str| value.pointer(pointer).is_some_and(Value::is_array);
    objects.iter().find(is_list).map(|pointer| list_at(pointer))
}

fn list_at(pointer: &str) -> JsonError {
    let detail = "must be an object, not a list".to_owned();
    JsonError { is_malformed: false, line: 0, column: 0, pointer: pointer.to_owned(), detail }
}

/// A key as a part of a JSON pointer.
pub(crate) fn escaped(key: &str) -> String {
    key.replace('~', "~0").replace('/', "~1")
}

fn pointer_of(path: &serde_path_to_error::Path) -> String {
    let mut pointer = String::new();
    for segment in path {
        match segment {
            Segment::Seq { index } => pointer.push_str(&format!("/{index}")),
            Segment::Map { key } => {
                pointer.push('/');
                pointer.push_str(&escaped(&key.chars().take(200).collect::<String>()));
            }
            Segment::Enum { .. } | Segment::Unknown => {}
        }
    }
    pointer
}

fn described(error: &serde_json::Error, pointer: String) -> JsonError {
    let is_malformed = matches!(error.classify(), Category::Syntax | Category::Eof);
    let message = error.to_string();
    // serde_json appends where it stood in the text.
    let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(message, _)| message);
    let detail = if is_malformed { message.to_owned() } else { in_terms_of_json(message) };
    let detail = detail.chars().take(300).collect();
    let pointer = if is_malformed { String::new() } else { pointer };
    JsonError { is_malformed, line: error.line(), column: error.column(), pointer, detail }
}

/// Serde names types of Rust; readers of the message know those of JSON.
fn in_terms_of_json(message: &str) -> String {
    if let Some((found, expected)) =
        message.strip_prefix("invalid type: ").and_then(|rest| rest.split_once(", expected "))
    {
        let found = match found {
            "map" => "an object",
            "sequence" => "a list",
            "null" | "unit value" => "null",
            other => other,
        };
        let expected = match expected {
            "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number of at least 0",
            "i64" => "a whole number",
            "f32" | "f64" => "a number",
            "a map" => "an object",
            "a sequence" => "a list",
            _ if expected.starts_with("struct ") => "an object",
            other => other,
        };
        return format!("must be {expected}, not {found}");
    }
    if let Some((_, expected)) = message.strip_prefix("unknown field ").and_then(|rest| rest.split_once(", "))
    {
        let names = expected.strip_prefix("expected ").unwrap_or("left out");
        return format!("is not known here; the name must be {names}");
    }
    if let Some(name) = message.strip_prefix("missing field ") {
        return format!("must have {name}");
    }
    if let Some(name) = message.strip_prefix("duplicate field ") {
        return format!("has {name} twice; give it once");
    }
    message.to_owned()
}
