//! Types with alternatives, described as one object that has the fields of all: clients that are generated read it
//! better. Each description has the name of its type, and a test compares them with values of it.

use std::borrow::Cow;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator};

use super::{edits, scene_request, scene_settings, summaries, texts};

/// Has the generator of requests describe these types so, wherever they are.
pub fn describe_requests(generator: &mut SchemaGenerator) {
    describe::<edits::EditOperation, scene::EditOperation>(generator);
    describe::<scene_settings::SceneSettings, scene::request::SceneSettings>(generator);
}

/// The same for answers.
pub fn describe_answers(generator: &mut SchemaGenerator) {
    describe_requests(generator);
    describe::<scene_request::Input, scene::Input>(generator);
    describe::<summaries::Fidelity, certificate::Fidelity>(generator);
    describe::<summaries::Relaxation, certificate::Relaxation>(generator);
    describe::<texts::Understood, scene::Understood>(generator);
    describe::<texts::Unmet, scene::predicates::Unmet>(generator);
}

fn describe<D: JsonSchema, T: JsonSchema>(generator: &mut SchemaGenerator) {
    generator.subschema_for::<Described<D, T>>();
}

/// A type `T` with the schema of `D`.
struct Described<D, T>(PhantomData<(D, T)>);

impl<D: JsonSchema, T: JsonSchema> JsonSchema for Described<D, T> {
    fn schema_name() -> Cow<'static, str> {
        T::schema_name()
    }

    fn schema_id() -> Cow<'static, str> {
        T::schema_id()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        D::json_schema(generator)
    }
}
