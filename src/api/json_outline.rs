//! One pass over JSON that keeps nothing: is it JSON, is it as flat and short as a body may be, and are objects
//! objects.
//!
//! It comes before the typed pass. Nested lists and endless maps are refused here at their first excess, before any
//! value of them is allocated. Serde reads a list as a struct's fields in order, which the contract does not.

use crate::problem::{FieldError, Problem, ProblemType};
use std::fmt;
use std::fmt::Write as _;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};

/// Levels of lists and objects; a body has five.
const MAX_DEPTH: usize = 8;

/// Values in all; a body has fewer than 200, the longest list of operations fewer than 3,000.
const MAX_VALUES: usize = 3000;

/// Places at which an object must not be a list. A star stands for the index of an item.
const OBJECTS: [&str; 9] = [
    "",
    "/image",
    "/options",
    "/options/table",
    "/options/metric_anchor",
    "/operations/*",
    "/operations/*/where",
    "/filter",
    "/splits",
];

/// Checks a body.
///
/// # Errors
///
/// A [`Problem`] where the bytes are no JSON, too deep, of too many values, or a list stands for an object.
pub fn check(bytes: &[u8]) -> Result<(), Problem> {
    let mut outline = Outline { pointer: String::new(), depth: 0, values: 0, list: None };
    let mut deserializer = serde_json::Deserializer::from_slice(bytes);
    let read = Node(&mut outline).deserialize(&mut deserializer).and_then(|()| deserializer.end());
    if let Err(error) = read {
        let detail = format!("the body is no JSON of a request: {error}");
        return Err(Problem::new(ProblemType::MalformedRequest, "malformed_json", detail));
    }
    match outline.list {
        Some(pointer) => {
            Err(Problem::invalid(vec![FieldError::new(pointer, "must be an object, not a list")]))
        }
        None => Ok(()),
    }
}

struct Outline {
    /// Of the present value, by names alone.
    pointer: String,
    depth: usize,
    values: usize,
    /// The first list that stands for an object.
    list: Option<String>,
}

/// Reads one value.
struct Node<'a>(&'a mut Outline);

impl<'de> DeserializeSeed<'de> for Node<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        self.0.values += 1;
        if self.0.values > MAX_VALUES {
            return Err(D::Error::custom(format_args!("it has more than {MAX_VALUES} values")));
        }
        deserializer.deserialize_any(self)
    }
}

impl Node<'_> {
    fn descend<E: Error>(&mut self) -> Result<(), E> {
        self.0.depth += 1;
        if self.0.depth > MAX_DEPTH {
            return Err(E::custom(format_args!("it is nested more than {MAX_DEPTH} levels deep")));
        }
        Ok(())
    }
}

impl<'de> Visitor<'de> for Node<'_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a value")
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }

    fn visit_u64<E>(self, _: u64) -> Result<(), E> {
        Ok(())
    }

    fn visit_f64<E>(self, _: f64) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut items: A) -> Result<(), A::Error> {
        self.descend()?;
        if self.0.list.is_none() && OBJECTS.iter().any(|object| matches(object, &self.0.pointer)) {
            self.0.list = Some(self.0.pointer.clone());
        }
        let length = self.0.pointer.len();
        for index in 0.. {
            // Writing to a string cannot fail.
            let _ = write!(self.0.pointer, "/{index}");
            let more = items.next_element_seed(Node(self.0))?.is_some();
            self.0.pointer.truncate(length);
            if !more {
                break;
            }
        }
        self.0.depth -= 1;
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut entries: A) -> Result<(), A::Error> {
        self.descend()?;
        let length = self.0.pointer.len();
        while entries.next_key_seed(Name(&mut self.0.pointer))?.is_some() {
            entries.next_value_seed(Node(self.0))?;
            self.0.pointer.truncate(length);
        }
        self.0.depth -= 1;
        Ok(())
    }
}

/// Whether a pointer is one of a pattern of [`OBJECTS`].
fn matches(pattern: &str, pointer: &str) -> bool {
    pattern.split('/').count() == pointer.split('/').count()
        && pattern.split('/').zip(pointer.split('/')).all(|(wanted, part)| wanted == "*" || wanted == part)
}

/// Appends the name of a value to its pointer, as far as it can matter.
struct Name<'a>(&'a mut String);

impl<'de> DeserializeSeed<'de> for Name<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl Visitor<'_> for Name<'_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a name")
    }

    fn visit_str<E>(self, name: &str) -> Result<(), E> {
        self.0.push('/');
        self.0.extend(name.chars().take(32));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_json(text: &str) -> bool {
        serde_json::from_str::<serde::de::IgnoredAny>(text).is_ok()
    }

    fn code(text: &str) -> &'static str {
        check(text.as_bytes()).map_or_else(|problem| problem.own_code(), |()| "fine")
    }

    #[test]
    fn nested_and_endless_json_is_refused_although_it_is_json() {
        let deep = |levels: usize| format!("{}{}", "[".repeat(levels), "]".repeat(levels));
        let body = |value: &str| format!("{{\"labels\": {value}}}");
        for (text, expected) in [
            (body(&deep(7)), "fine"),
            (body(&deep(8)), "malformed_json"),
            (body(&deep(100)), "malformed_json"),
            (body(&deep(1_000_000)), "malformed_json"),
            (body(&format!("[{}0]", "0,".repeat(2_900))), "fine"),
            (body(&format!("[{}0]", "0,".repeat(3_000))), "malformed_json"),
            (body(&format!("[{}[]]", "[],".repeat(1_000_000))), "malformed_json"),
        ] {
            assert!(is_json(&text));
            let shown: String = text.chars().take(40).collect();
            assert_eq!(code(&text), expected, "{shown}");
        }
    }

    #[test]
    fn malformed_json_and_lists_for_objects_are_refused() {
        for text in ["", "{", "nul", "{\"a\": 1,}", "{} x", "[[[", "{\"a\": \"\\u12\"}", "{1: 2}"] {
            assert_eq!(code(text), "malformed_json", "{text:?}");
        }
        for (text, pointer) in [
            ("[\"a mug\"]", ""),
            ("{\"options\": []}", "/options"),
            ("{\"options\": {\"table\": [1]}}", "/options/table"),
            ("{\"\\u0069mage\": []}", "/image"),
            ("{\"operations\": [{}, []]}", "/operations/1"),
            ("{\"operations\": [{\"where\": [\"on\"]}]}", "/operations/0/where"),
        ] {
            let problem = check(text.as_bytes()).expect_err(text);
            assert_eq!((problem.own_code(), problem.errors[0].pointer.as_str()), ("invalid_body", pointer));
        }
        assert_eq!(code("{\"options\": {\"table\": {\"size_m\": [1, 2, 3]}}}"), "fine");
        assert_eq!(code("{\"operations\": [{\"where\": {\"position_m\": [1, 2]}}]}"), "fine");
    }
}
