//! Errors of typed JSON as places and faults.

use serde_path_to_error::Segment;

use super::json_detail::json_detail;
use crate::problem::FieldError;

/// Place at which a value stops being of its type, and the reason.
pub fn field_error(error: &serde_path_to_error::Error<serde_json::Error>) -> FieldError {
    let mut pointer = String::new();
    for segment in error.path() {
        match segment {
            Segment::Seq { index } => pointer.push_str(&format!("/{index}")),
            Segment::Map { key } => pointer.push_str(&pointer_segment(key)),
            Segment::Enum { .. } | Segment::Unknown => {}
        }
    }
    FieldError::new(pointer, detail_of(error.inner()))
}

/// A name as a segment of a JSON pointer.
pub fn pointer_segment(name: &str) -> String {
    let name: String = name.chars().take(200).collect();
    format!("/{}", name.replace('~', "~0").replace('/', "~1"))
}

/// The detail of an error of serde, of bounded length.
pub fn detail_of(error: &serde_json::Error) -> String {
    json_detail(&error.to_string()).chars().take(300).collect()
}
