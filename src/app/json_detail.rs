//! Faults of values of a JSON body, in terms of JSON.
//!
//! Serde reports names of Rust types ("expected u64"). Clients know numbers, strings, lists and objects. The kinds of
//! messages are those of `serde::de::Error`; a message of another form is a sentence of this program and stays.

/// The detail for a message of serde.
pub fn json_detail(message: &str) -> String {
    // serde_json appends where it stood in the text.
    let message = message.split(" at line ").next().unwrap_or(message);
    for kind in ["invalid type: ", "invalid value: ", "invalid length "] {
        if let Some((found, expected)) =
            message.strip_prefix(kind).and_then(|rest| rest.split_once(", expected "))
        {
            let found =
                if kind == "invalid length " { format!("a list of {found}") } else { json_value(found) };
            return format!("must be {}, not {found}", json_type(expected));
        }
    }
    if let Some((name, expected)) = message.strip_prefix("unknown variant ").and_then(|r| r.split_once(", "))
    {
        return format!("must be {}, not {}", choices(expected, "nothing"), quoted(name));
    }
    if let Some((_, expected)) = message.strip_prefix("unknown field ").and_then(|r| r.split_once(", ")) {
        return format!("is not known here; the name must be {}", choices(expected, "left out"));
    }
    if let Some(name) = message.strip_prefix("missing field ") {
        return format!("must have {}", quoted(name));
    }
    if let Some(name) = message.strip_prefix("duplicate field ") {
        return format!("has {} twice; give it once", quoted(name));
    }
    // The text is JSON, so these messages are about what stands there instead of another kind of value.
    let other = match message {
        "expected value" => "must be a string",
        "trailing characters" => "must be a shorter list",
        "number out of range" => "must be a number of smaller size",
        _ => message,
    };
    other.to_owned()
}

/// Expectation of a visitor, as a type of JSON.
fn json_type(expected: &str) -> String {
    let list_of = |count: &str| format!("a list of {count}");
    match expected {
        "u8" | "u16" | "u32" | "i8" | "i16" | "i32" => integer_range(expected),
        "u64" | "u128" | "usize" => "a whole number of at least 0".to_owned(),
        "i64" | "i128" | "isize" => "a whole number".to_owned(),
        "f32" | "f64" => "a number".to_owned(),
        "a boolean" | "bool" => "true or false".to_owned(),
        "a string" | "a character" | "a borrowed string" | "str" | "string" => "a string".to_owned(),
        "unit" | "null" => "null".to_owned(),
        "a sequence" | "a list" | "a byte array" => "a list".to_owned(),
        "a map" | "map" | "an object" => "an object".to_owned(),
        "fewer elements in array" | "fewer elements in sequence" => "a shorter list".to_owned(),
        "fewer elements in map" => "an object of fewer names".to_owned(),
        "string or map" => "a string or an object".to_owned(),
        "map with a single key" => "an object with one name".to_owned(),
        _ => {
            let counted =
                ["an array of length ", "a tuple of size "].iter().find_map(|p| expected.strip_prefix(p));
            // Vectors of glam: "a sequence of 3 f64 values".
            if let Some(rest) = expected.strip_prefix("a sequence of ") {
                return list_of(&format!("{} numbers", rest.split(' ').next().unwrap_or_default()));
            }
            match (counted, expected.split(' ').next()) {
                (Some(count), _) => list_of(&format!("{count} values")),
                (None, Some("struct")) if expected.contains(" with ") => list_of(&elements(expected)),
                (None, Some("tuple")) if expected.contains(" with ") => list_of(&elements(expected)),
                (None, Some("struct")) => "an object".to_owned(),
                (None, Some("tuple" | "newtype")) => "a list".to_owned(),
                (None, Some("enum" | "variant")) => "a string or an object".to_owned(),
                _ => expected.to_owned(),
            }
        }
    }
}

/// "3 values" of "struct X with 3 elements".
fn elements(expected: &str) -> String {
    let count = expected.rsplit(" with ").next().and_then(|rest| rest.split(' ').next()).unwrap_or_default();
    format!("{count} values")
}

/// The range of an integer type of at most 32 bits.
fn integer_range(name: &str) -> String {
    let (low, high) = match name {
        "u8" => (0, i64::from(u8::MAX)),
        "u16" => (0, i64::from(u16::MAX)),
        "u32" => (0, i64::from(u32::MAX)),
        "i8" => (i64::from(i8::MIN), i64::from(i8::MAX)),
        "i16" => (i64::from(i16::MIN), i64::from(i16::MAX)),
        _ => (i64::from(i32::MIN), i64::from(i32::MAX)),
    };
    format!("a whole number from {low} to {high}")
}

/// A value that was found, as JSON has it.
fn json_value(found: &str) -> String {
    let value_after = |kind: &str| {
        let value = found.strip_prefix(kind)?;
        Some(value.trim_matches('`').to_owned())
    };
    let kinds = ["integer ", "floating point ", "boolean ", "character ", "string "];
    match found {
        "map" => "an object".to_owned(),
        "sequence" | "byte array" => "a list".to_owned(),
        "null" | "unit value" | "Option value" => "null".to_owned(),
        _ => kinds.into_iter().find_map(value_after).unwrap_or_else(|| "another kind of value".to_owned()),
    }
}

/// "one of `a`, `b`" of "expected one of `a`, `b`"; `none` where there is nothing to choose.
fn choices(expected: &str, none: &str) -> String {
    match expected.strip_prefix("expected ") {
        Some(names) => names.to_owned(),
        None => none.to_owned(),
    }
}

/// A name in backquotes, once.
fn quoted(name: &str) -> String {
    format!("`{}`", name.trim_matches('`'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_message_speaks_of_json() {
        for (message, expected) in [
            ("invalid type: string \"x\", expected u64", "must be a whole number of at least 0, not \"x\""),
            ("invalid value: integer `-1`, expected u64", "must be a whole number of at least 0, not -1"),
            (
                "invalid type: floating point `1.5`, expected u64",
                "must be a whole number of at least 0, not 1.5",
            ),
            (
                "invalid value: integer `5000000000`, expected u32",
                "must be a whole number from 0 to 4294967295, not 5000000000",
            ),
            ("invalid type: null, expected i64", "must be a whole number, not null"),
            ("invalid value: integer `200`, expected i8", "must be a whole number from -128 to 127, not 200"),
            ("invalid type: sequence, expected f64", "must be a number, not a list"),
            ("invalid type: boolean `true`, expected f32", "must be a number, not true"),
            ("invalid type: integer `5`, expected a string", "must be a string, not 5"),
            ("invalid type: map, expected a boolean", "must be true or false, not an object"),
            ("invalid type: string \"a\", expected struct SceneBody", "must be an object, not \"a\""),
            ("invalid type: integer `1`, expected a map", "must be an object, not 1"),
            ("invalid type: integer `1`, expected a sequence", "must be a list, not 1"),
            ("invalid type: integer `1`, expected string or map", "must be a string or an object, not 1"),
            ("invalid type: integer `1`, expected enum Shape", "must be a string or an object, not 1"),
            ("invalid type: unit value, expected a sequence", "must be a list, not null"),
            ("invalid type: integer `1`, expected unit", "must be null, not 1"),
            (
                "invalid length 2, expected an array of length 3",
                "must be a list of 3 values, not a list of 2",
            ),
            ("invalid length 2, expected a tuple of size 3", "must be a list of 3 values, not a list of 2"),
            (
                "invalid length 1, expected struct X with 2 elements",
                "must be a list of 2 values, not a list of 1",
            ),
            (
                "invalid length 4, expected a sequence of 3 f64 values",
                "must be a list of 3 numbers, not a list of 4",
            ),
            ("invalid length 4, expected fewer elements in array", "must be a shorter list, not a list of 4"),
            (
                "unknown variant `hexagonal`, expected `round` or `oval`",
                "must be `round` or `oval`, not `hexagonal`",
            ),
            ("unknown variant `x`, expected one of `a`, `b`, `c`", "must be one of `a`, `b`, `c`, not `x`"),
            ("unknown variant `x`, there are no variants", "must be nothing, not `x`"),
            (
                "unknown field `txet`, expected one of `text`, `image`",
                "is not known here; the name must be one of `text`, `image`",
            ),
            ("unknown field `x`, there are no fields", "is not known here; the name must be left out"),
            ("missing field `object`", "must have `object`"),
            ("duplicate field `seed`", "has `seed` twice; give it once"),
            ("must be from 1 to 64", "must be from 1 to 64"),
            (
                "invalid type: map, expected u64 at line 1 column 5",
                "must be a whole number of at least 0, not an object",
            ),
        ] {
            assert_eq!(json_detail(message), expected, "{message}");
        }
    }
}
