//! JSON schemas of the types that other crates have, for requests and answers that hold them.
//!
//! Types of this package derive their schemas where they are. Those of crates below it, which know nothing of an
//! interface, are described here, one file for each subject; tests compare what the server answers with them.

pub mod values;
pub mod words;
pub mod scene_request;
pub mod scene_settings;
pub mod batches;
pub mod datasets;
pub mod edits;
pub mod edit_accounts;
pub mod episodes;
pub mod executions;
pub mod summaries;
pub mod tasks;
pub mod texts;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::{Value, json};

/// The schema of a body in which a field is given and other fields are not.
pub fn narrowed<T: JsonSchema>(
    generator: &mut SchemaGenerator,
    description: &str,
    given: Option<&str>,
    absent: &[&str],
) -> Schema {
    let mut schema = T::json_schema(generator);
    schema.insert("description".to_owned(), description.into());
    if let Some(given) = given {
        schema.insert("required".to_owned(), json!([given]));
    }
    let fields = schema.get_mut("properties").and_then(Value::as_object_mut);
    for (name, field) in fields.into_iter().flatten() {
        if given == Some(name) {
            not_null(field);
        } else if absent.contains(&name.as_str()) {
            *field = json!({ "type": "null" });
        }
    }
    schema
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

/// Types that stand for a body in which one of several fields is given.
macro_rules! narrowed {
    ($($doc:literal $name:ident = $body:ty, $given:expr, $absent:expr;)*) => {
        $(
            #[doc = $doc]
            #[derive(Default)]
            pub struct $name;

            impl schemars::JsonSchema for $name {
                fn schema_name() -> std::borrow::Cow<'static, str> {
                    stringify!($name).into()
                }

                fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                    crate::schemas::narrowed::<$body>(generator, $doc, $given, $absent)
                }
            }
        )*
    };
}

pub(crate) use narrowed as narrowed_types;

/// Schemas that are described where they are used.
macro_rules! in_place {
    ($($type:ident $schema:tt)*) => {
        $(
            impl schemars::JsonSchema for $type {
                fn inline_schema() -> bool {
                    true
                }

                fn schema_name() -> std::borrow::Cow<'static, str> {
                    stringify!($type).into()
                }

                fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
                    schemars::json_schema!($schema)
                }
            }
        )*
    };
}

pub(crate) use in_place;
