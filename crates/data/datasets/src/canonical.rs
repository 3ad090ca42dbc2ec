//! The canonical form of a JSON value: members sorted by name, no white space. Digests are of this form.
//!
//! Python writes the same with `json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False)` for the
//! values of a dataset, which hold integers and short decimal fractions.

use serde::Serialize;
use serde_json::Value;

use crate::bundle::sha256;

/// SHA-256 of the canonical form.
///
/// # Errors
///
/// If the value has no JSON form.
pub fn digest(value: &impl Serialize) -> Result<String, serde_json::Error> {
    Ok(sha256(text(&serde_json::to_value(value)?).as_bytes()))
}

/// The canonical form.
pub fn text(value: &Value) -> String {
    let mut text = String::new();
    write(value, &mut text);
    text
}

fn write(value: &Value, text: &mut String) {
    match value {
        Value::Array(items) => {
            text.push('[');
            for (index, item) in items.iter().enumerate() {
                if index > 0 {
                    text.push(',');
                }
                write(item, text);
            }
            text.push(']');
        }
        Value::Object(members) => {
            let mut sorted: Vec<(&String, &Value)> = members.iter().collect();
            sorted.sort_by_key(|(name, _)| name.as_str());
            text.push('{');
            for (index, (name, member)) in sorted.into_iter().enumerate() {
                if index > 0 {
                    text.push(',');
                }
                write(&Value::String(name.clone()), text);
                text.push(':');
                write(member, text);
            }
            text.push('}');
        }
        scalar => text.push_str(&scalar.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_are_sorted_and_texts_stay_unicode() {
        let value = serde_json::json!({ "b": [1, 0.8, null], "a": { "é": "x\n", "d": true } });
        assert_eq!(text(&value), "{\"a\":{\"d\":true,\"é\":\"x\\n\"},\"b\":[1,0.8,null]}");
    }
}
