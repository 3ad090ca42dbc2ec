//! The five ports: traits for the kinds of model that the method uses, each implemented by adapters.
//!
//! Pipeline stages call ports. Embedded adapters need no key, network or GPU. Remote adapters call models of vendors,
//! whose cost a [`ledger`] accounts for. An adapter reports a missing capability as a [`ProviderError`] that names
//! its port, never as an invented answer. Every adapter has an [`Adapter`] identity (name, model and settings), which
//! is part of the key of each stage that uses it.
//!
//! Ports know scenes and images. The crate must not depend on adapters, jobs, storage or the network.
//!
//! ```
//! use ports::{Adapter, Port, ProviderError};
//!
//! let adapter = Adapter::new("embedded/grammar", "1", &());
//! let (port, reason) = (Port::Analyst, "no image input".to_owned());
//! let error = ProviderError::Unsupported { port, adapter: adapter.name, reason };
//! assert!(error.another_may_answer());
//! ```

pub mod call;
pub mod error;
pub mod ledger;
pub mod analyst;
pub mod instruction_reader;
pub mod recognition_hints;
pub mod upright;
pub mod image_generator;
pub mod segmenter;
pub mod mesh_generator;
pub mod feature_extractor;

use std::sync::Arc;

use futures::future::BoxFuture;
use serde::{Deserialize, Serialize};

pub use analyst::{
    Judgement, MadeAfter, SceneAnalyst, TaskObject, TaskQuestion, TopCheck, TopVerdict, Upright,
    UprightQuestion, UprightView,
};
pub use call::Call;
pub use error::{BAD_ANSWER, Port, ProviderError};
pub use feature_extractor::FeatureExtractor;
pub use image_generator::{
    CompletedBy, Completion, CompletionRequest, CompletionWay, GeneratedReference, ImageAnnotations,
    ImageGenerator, IsolatedRender, ReferenceImage, SyntheticGroundTruth, TopViewAnnotations, TopViewImage,
    TopViewRequest, Truth, TruthInstance,
};
pub use instruction_reader::{Instruction, InstructionReader};
pub use mesh_generator::{
    MeshGenerator, RawMesh, RawTable, ReconstructionRequest, TablePhotograph, TableRequest,
};
pub use recognition_hints::{InvalidHints, NamedObject, RecognitionHints};
pub use segmenter::{Segmentation, Segmenter, TopBoxes};
pub use upright::stood_up;

/// The answer of a port: a future of a value or an error.
pub type Answer<'a, T> = BoxFuture<'a, Result<T, ProviderError>>;

/// The identity of an adapter: everything that can change its answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adapter {
    /// `embedded/grammar`, `openai/chat`.
    pub name: String,
    /// Version, raised by hand when answers change, with the digest of the weights if any; for a remote adapter, the
    /// name of its model.
    pub model: String,
    /// The settings of the adapter.
    pub settings: serde_json::Value,
}

impl Adapter {
    /// The identity of an adapter with these settings.
    pub fn new(name: &str, model: &str, settings: &impl Serialize) -> Self {
        // Settings are plain structs of numbers and words, which always have a JSON form.
        let settings = serde_json::to_value(settings).unwrap_or(serde_json::Value::Null);
        Self { name: name.to_owned(), model: model.to_owned(), settings }
    }
}

/// One adapter per port; clones share them.
#[derive(Clone)]
pub struct Ports {
    pub analyst: Arc<dyn SceneAnalyst>,
    pub image_generator: Arc<dyn ImageGenerator>,
    pub segmenter: Arc<dyn Segmenter>,
    pub mesh_generator: Arc<dyn MeshGenerator>,
    pub feature_extractor: Arc<dyn FeatureExtractor>,
}
