//! The embedded scene analyst: a grammar over the catalog for texts, what the painter knows for pictures it
//! painted, a network and geometry for photographs, geometric evidence for standing meshes up.

use std::sync::Arc;

use serde::Serialize;

use super::analyst::{self, DescribeError, DescribeOptions};
use super::photograph::{self, PictureReader, ReaderIdentity};
use catalog::Recipe;
use ports::{
    Adapter, Answer, Call, Port, ProviderError, Reference, SceneAnalyst, Upright, UprightQuestion, stood_up,
};
use scene::request::RequestOptions;
use scene::{Recognition, SceneDescription};

/// Answers without a model.
pub struct EmbeddedAnalyst {
    pub settings: analyst::Settings,
    pub photograph: PictureReader,
}

/// Most objects of a scene whose request does not say.
const USUAL_MAX_OBJECTS: u32 = 64;

/// What decides the answers.
#[derive(Serialize)]
struct Identity {
    analyst: analyst::Settings,
    photograph: ReaderIdentity,
}

impl SceneAnalyst for EmbeddedAnalyst {
    fn adapter(&self) -> Adapter {
        let identity = Identity { analyst: self.settings.clone(), photograph: self.photograph.identity() };
        Adapter::new("embedded/grammar", "4", &identity)
    }

    fn describe<'a>(
        &'a self,
        call: &'a Call,
        text: String,
        seed: u64,
        options: RequestOptions,
    ) -> Answer<'a, SceneDescription> {
        let settings = self.settings.clone();
        Box::pin(call.compute(Port::Analyst, move |_| {
            let options = DescribeOptions {
                max_objects: options.max_objects.unwrap_or(USUAL_MAX_OBJECTS) as usize,
                table: options.table,
            };
            analyst::describe(&text, seed, &options, &settings).map_err(rejected)
        }))
    }

    fn recognize<'a>(
        &'a self,
        call: &'a Call,
        reference: Reference,
        seed: u64,
        options: RequestOptions,
    ) -> Answer<'a, Recognition> {
        let reader = self.photograph.clone();
        Box::pin(call.compute(Port::Analyst, move |interrupt| match &reference.known {
            Some(known) => Ok(known.recognition.clone()),
            None => photograph::recognize(&reference.picture, seed, &options, &reader, interrupt),
        }))
    }

    fn upright<'a>(&'a self, call: &'a Call, question: UprightQuestion) -> Answer<'a, Upright> {
        let settings = self.photograph.settings.clone();
        Box::pin(call.compute(Port::Analyst, move |interrupt| {
            let UprightQuestion { object, completion, camera, .. } = &question;
            let seen = || photograph::as_seen(object, completion, camera, &settings).map(Arc::new);
            let typical = || Recipe::typical(&object.category, object.color, object.material.clone());
            let example = seen().or_else(|| catalog::stocked(&typical()?));
            let pose = stood_up(&question, example.as_deref(), &[], interrupt)?;
            Ok(Upright { pose, looks: Vec::new() })
        }))
    }
}

/// Stable code and message of a text that became no description.
fn rejected(error: DescribeError) -> ProviderError {
    let code = match error {
        DescribeError::Empty => "text_empty",
        DescribeError::TooLong { .. } => "text_too_long",
        DescribeError::NothingRecognized { .. } => "nothing_recognized",
        DescribeError::TooManyObjects { .. } => "too_many_objects",
        DescribeError::UnknownTableModel { .. } => "unknown_table_model",
    };
    ProviderError::Rejected { port: Port::Analyst, code, reason: error.to_string() }
}
