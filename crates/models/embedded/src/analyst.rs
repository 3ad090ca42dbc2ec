//! The embedded scene analyst.
//!
//! Texts are parsed by the grammar of [`text_parser`]. Images are recognized from the ground truth of the embedded
//! image generator if they have one, otherwise by a network and geometry. The upright orientation of meshes is
//! estimated from geometric evidence.

use std::sync::Arc;

use serde::Serialize;

use super::requested_pose::posed;
use super::single_view_reconstruction::{self, ImageReader, ReaderIdentity};
use super::text_parser::{self, DescribeError, DescribeOptions, TextParserSettings};
use super::with_catalog;
use catalog::Recipe;
use geometry::TexturedMesh;
use ports::{
    Adapter, Answer, Call, Port, ProviderError, RecognitionHints, ReferenceImage, SceneAnalyst, Upright,
    UprightQuestion, stood_up,
};
use scene::request::RequestOptions;
use scene::{Recognition, SceneDescription};

/// Answers the analyst port without a language model.
pub struct EmbeddedAnalyst {
    pub settings: text_parser::TextParserSettings,
    pub photograph: ImageReader,
}

/// Maximum number of objects of a scene if the request does not specify it.
const DEFAULT_MAX_OBJECTS: u32 = 64;

/// All settings that determine the answers.
#[derive(Serialize)]
struct Identity {
    analyst: text_parser::TextParserSettings,
    photograph: ReaderIdentity,
}

impl SceneAnalyst for EmbeddedAnalyst {
    fn adapter(&self) -> Adapter {
        let identity = Identity { analyst: self.settings.clone(), photograph: self.photograph.identity() };
        with_catalog(Adapter::new("embedded/grammar", "11", &identity))
    }

    fn describe<'a>(
        &'a self,
        call: &'a Call,
        text: String,
        seed: u64,
        options: RequestOptions,
    ) -> Answer<'a, SceneDescription> {
        let settings = self.settings.clone();
        Box::pin(
            call.compute(Port::Analyst, move |_| {
                describe(&text, seed, &options, &settings).map_err(rejected)
            }),
        )
    }

    fn recognize<'a>(
        &'a self,
        call: &'a Call,
        reference: ReferenceImage,
        seed: u64,
        options: RequestOptions,
        hints: Option<Arc<RecognitionHints>>,
    ) -> Answer<'a, Recognition> {
        let reader = self.photograph.clone();
        Box::pin(call.compute(Port::Analyst, move |cancel| match &reference.known {
            Some(known) => Ok(known.recognition.clone()),
            None => {
                let hints = hints.as_deref();
                single_view_reconstruction::recognize(&reference, seed, &options, hints, &reader, cancel)
            }
        }))
    }

    fn upright<'a>(&'a self, call: &'a Call, question: UprightQuestion) -> Answer<'a, Upright> {
        let settings = self.photograph.settings.clone();
        Box::pin(call.compute(Port::Analyst, move |cancel| {
            let UprightQuestion { object, completion, camera, .. } = &question;
            let seen =
                || single_view_reconstruction::as_seen(object, completion, camera, &settings).map(Arc::new);
            let typical = || Recipe::typical(&object.category, object.color, object.material.clone());
            let tipped = |mesh: Arc<TexturedMesh>| match &object.tipped {
                Some(tipped) => posed(&mesh, tipped.pose).map(Arc::new),
                None => Some(mesh),
            };
            let example = seen().or_else(|| catalog::build_cached(&typical()?).and_then(tipped));
            let pose = stood_up(&question, example.as_deref(), &[], cancel)?;
            Ok(Upright { pose, views: Vec::new() })
        }))
    }
}

/// Describes a text with the options of a request.
///
/// # Errors
///
/// As [`text_parser::describe`].
pub fn describe(
    text: &str,
    seed: u64,
    options: &RequestOptions,
    settings: &TextParserSettings,
) -> Result<SceneDescription, DescribeError> {
    let options = DescribeOptions {
        max_objects: options.max_objects.unwrap_or(DEFAULT_MAX_OBJECTS) as usize,
        table: options.table.clone(),
        on_unknown: options.on_unknown.unwrap_or_default(),
    };
    text_parser::describe(text, seed, &options, settings)
}

/// The error of the port for a rejected text.
fn rejected(error: DescribeError) -> ProviderError {
    ProviderError::Rejected { port: Port::Analyst, code: error.code(), reason: error.to_string() }
}
