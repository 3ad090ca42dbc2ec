//! Operations of an edit out of JSON, with a pointer to every field that is wrong.
//!
//! Serde reads an enum with a tag in one piece and reports no place inside. Where that fails, the fields are read one
//! by one.

use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::json_error::{detail_of, field_error, pointer_segment};
use crate::problem::FieldError;
use scene::edit::{MAX_OPERATIONS, violations};
use scene::{EditOperation, EditPlace, Violation};

/// The operations of a list.
///
/// # Errors
///
/// Every wrong field, with pointers below `/operations`; of one that cannot be read, the first.
pub fn read(items: &[Value]) -> Result<Vec<EditOperation>, Vec<FieldError>> {
    let mut errors = Vec::new();
    let mut operations = Vec::new();
    for (index, item) in items.iter().enumerate().take(MAX_OPERATIONS + 1) {
        match read_one(item) {
            Ok(operation) => operations.push(operation),
            Err(FieldError { pointer, detail }) => {
                errors.push(FieldError::new(format!("/operations/{index}{pointer}"), detail));
            }
        }
    }
    if errors.is_empty() {
        let violations = violations(&operations).into_iter();
        errors.extend(
            violations.map(|Violation { pointer, detail }| {
                FieldError::new(format!("/operations{pointer}"), detail)
            }),
        );
    }
    if errors.is_empty() { Ok(operations) } else { Err(errors) }
}

/// One operation; the pointer of the error is relative to it.
fn read_one(item: &Value) -> Result<EditOperation, FieldError> {
    let Some(fields) = item.as_object() else { return Err(FieldError::new("", "must be an object")) };
    match fields.get("op") {
        None => return Err(FieldError::new("", "must have `op`, the name of the operation")),
        Some(Value::String(_)) => {}
        Some(_) => return Err(FieldError::new("/op", "must be a string")),
    }
    let operation = EditOperation::deserialize(item).map_err(|error| first_error(fields, &error))?;
    // Serde accepts any fields beside the tag where there are none.
    let is_bare = matches!(operation, EditOperation::Tidy | EditOperation::Rearrange);
    let extra = fields.keys().find(|name| is_bare && *name != "op");
    match extra {
        Some(name) => Err(FieldError::new(pointer_segment(name), "is not known here; it must be left out")),
        None => Ok(operation),
    }
}

/// The first wrong field of an operation that cannot be read, with `whole` as the reason.
fn first_error(fields: &Map<String, Value>, whole: &serde_json::Error) -> FieldError {
    let op = &fields["op"];
    let is_missing = |error: &serde_json::Error| error.to_string().starts_with("missing field");
    let alone = |name: &str, value: &Value| EditOperation::deserialize(json!({ "op": op, name: value }));
    if let Err(error) = EditOperation::deserialize(json!({ "op": op }))
        && !is_missing(&error)
    {
        return FieldError::new("/op", detail_of(&error));
    }
    for (name, value) in fields.iter().filter(|(name, _)| *name != "op") {
        let Err(error) = alone(name, value) else { continue };
        if is_missing(&error) {
            continue;
        }
        let inside = match value {
            Value::Object(_) if name == "where" => {
                serde_path_to_error::deserialize::<_, EditPlace>(value).err()
            }
            _ => None,
        };
        return match inside.map(|error| field_error(&error)) {
            Some(FieldError { pointer, detail }) => FieldError::new(format!("/where{pointer}"), detail),
            None => FieldError::new(pointer_segment(name), detail_of(&error)),
        };
    }
    FieldError::new("", detail_of(whole))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wrong_field_is_named() {
        for (item, pointer, detail) in [
            (json!("tidy"), "", "must be an object"),
            (json!(["tidy"]), "", "must be an object"),
            (json!({}), "", "must have `op`, the name of the operation"),
            (json!({ "op": 5 }), "/op", "must be a string"),
            (json!({ "op": "explode" }), "/op", "must be one of `add`, "),
            (json!({ "op": "tidy", "x": 1 }), "/x", "is not known here; it must be left out"),
            (json!({ "op": "remove" }), "", "must have `target`"),
            (json!({ "op": "remove", "target": 5 }), "/target", "must be a string, not 5"),
            (
                json!({ "op": "remove", "target": "a", "a/b": 1 }),
                "/a~1b",
                "is not known here; the name must be ",
            ),
            (json!({ "op": "stack", "targets": ["a", 1] }), "/targets", "must be a string, not 1"),
            (
                json!({ "op": "add", "object": "a", "count": -1 }),
                "/count",
                "must be a whole number from 0 to ",
            ),
            (json!({ "op": "move", "target": "a" }), "", "must have `where`"),
            (
                json!({ "op": "move", "target": "a", "where": { "relation": "beside" } }),
                "/where/relation",
                "must be one of ",
            ),
            (
                json!({ "op": "move", "target": "a", "where": { "position_m": [0.1] } }),
                "/where/position_m",
                "must be a list of 2 numbers",
            ),
            (
                json!({ "op": "move", "target": "a", "where": { "relation": "on", "x": 1 } }),
                "/where/x",
                "is not known here; the name must be ",
            ),
            (
                json!({ "op": "move", "target": "a", "where": "there" }),
                "/where",
                "must be an object, not \"there\"",
            ),
            (
                json!({ "op": "move", "target": "a", "where": {} }),
                "/where",
                "give one of `relation`, `position_m` and `offset_m`",
            ),
        ] {
            let fine = json!({ "op": "tidy" });
            let errors = read(&[fine, item.clone()]).expect_err("is refused");
            assert_eq!(errors.len(), 1, "{item}: {errors:?}");
            assert_eq!(errors[0].pointer, format!("/operations/1{pointer}"), "{item}: {errors:?}");
            assert!(errors[0].detail.starts_with(detail), "{item}: {errors:?}");
        }
    }

    #[test]
    fn lists_of_a_wrong_length_are_refused_as_a_whole() {
        for count in [0, MAX_OPERATIONS + 1, 1000] {
            let errors = read(&vec![json!({ "op": "tidy" }); count]).expect_err("is refused");
            assert_eq!(errors[0].pointer, "/operations", "{count}: {errors:?}");
        }
        assert_eq!(read(&[json!({ "op": "tidy" })]), Ok(vec![EditOperation::Tidy]));
    }
}
