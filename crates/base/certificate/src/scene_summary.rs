//! Summary of a finished scene, which servers keep beside its bundle.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;

use crate::{Fidelity, Relaxation, RobotFinding};
use scene::edit::EditAccount;
use scene::text_account::TextAccount;

/// Summary of a finished scene. Those of earlier versions lack fields.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(rename = "Summary", description = "Summary of a finished scene.")]
pub struct SceneSummary<'a> {
    /// The id of the scene in its bundle (`id` of `scene.json`), a digest of what it was made from.
    #[schemars(
        with = "Option<String>",
        skip_serializing_if = "Option::is_none",
        regex(pattern = "^[0-9a-f]{20}$")
    )]
    pub bundle_id: &'a str,
    /// Number of objects.
    #[schemars(with = "Option<u32>", skip_serializing_if = "Option::is_none", range(min = 0, max = 10_000))]
    pub objects: usize,
    /// Categories of the objects, each once, in order. Absent in scenes of earlier versions.
    #[schemars(with = "Option<Vec<String>>", skip_serializing_if = "Option::is_none")]
    pub categories: BTreeSet<&'a str>,
    /// Label of the table.
    #[schemars(with = "Option<String>", skip_serializing_if = "Option::is_none")]
    pub table: &'a str,
    /// The verdict in words, with the number of stand-ins.
    #[schemars(with = "Option<String>", skip_serializing_if = "Option::is_none")]
    pub verdict_text: &'a str,
    /// The account of the text; null for an image. That of an edited scene has what still holds.
    #[schemars(with = "Option<Nullable<TextAccount>>", skip_serializing_if = "Option::is_none")]
    pub text: Option<&'a TextAccount>,
    /// Result of the edit; null for other scenes.
    #[schemars(with = "Option<Nullable<EditAccount>>", skip_serializing_if = "Option::is_none")]
    pub edit: Option<&'a EditAccount>,
    #[schemars(with = "Option<Fidelity>", skip_serializing_if = "Option::is_none")]
    pub fidelity: &'a Fidelity,
    /// Changes made by the stage `resolve`.
    #[schemars(with = "Option<Vec<String>>", skip_serializing_if = "Option::is_none")]
    pub resolve: &'a [String],
    /// Objects that were made smaller or moved for lack of space.
    #[schemars(with = "Option<Vec<Relaxation>>", skip_serializing_if = "Option::is_none")]
    pub gave_way: &'a [Relaxation],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<&'a RobotFinding>,
}

/// A value that may be null where it is there at all.
struct Nullable<T>(PhantomData<T>);

impl<T: JsonSchema> JsonSchema for Nullable<T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        format!("Nullable{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({ "oneOf": [generator.subschema_for::<T>(), { "type": "null" }] })
    }
}
