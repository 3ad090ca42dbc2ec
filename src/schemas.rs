//! JSON schemas that no single type has, for requests and answers.
//!
//! Types derive their schemas where they are, those of crates below this package too. Here are values and lists of
//! words that several bodies have, bodies that no type reads as a whole, and types with alternatives, which the
//! contract describes as one object; tests compare these with values of the types.

pub mod values;
pub mod words;
pub mod scene_request;
pub mod scene_settings;
pub mod batches;
pub mod datasets;
pub mod edits;
pub mod episodes;
pub mod executions;
pub mod summaries;
pub mod texts;
pub mod as_objects;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::{Value, json};

use scene::json_schema::not_null;

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
