//! The five ports: the kinds of model the method asks, each answered by an adapter.
//!
//! A port is a trait that stages call; an adapter answers it. The [`embedded`] adapters need no key, no
//! network and no GPU: they are real algorithms with a known error. The [`remote`] adapters ask models of vendors, for
//! money that a [`ledger`] accounts for; [`preference`] asks several providers in order. What an adapter cannot do is a
//! [`ProviderError`] that names its port, never a made-up answer. Every adapter has an [`Adapter`]
//! identity (name, model and settings), which is part of the key of each stage that asks it.
//!
//! Ports know scenes and pictures; they know neither jobs nor rows.

pub mod call;
pub mod error;
pub mod ledger;
pub mod analyst;
pub mod upright;
pub mod painter;
pub mod segmenter;
pub mod mesh_generator;
pub mod feature_extractor;

use std::sync::Arc;

use futures::future::BoxFuture;
use serde::{Deserialize, Serialize};

pub use analyst::{
    Judgement, MadeAfter, SceneAnalyst, TaskQuestion, TaskThing, TopCheck, TopVerdict, Upright, UprightLook,
    UprightQuestion,
};
pub use call::Call;
pub use error::{BAD_ANSWER, Port, ProviderError};
pub use feature_extractor::FeatureExtractor;
pub use mesh_generator::{MeshGenerator, RawMesh, RawTable, ReconstructionRequest};
pub use painter::{
    Alone, CompletedBy, Completion, CompletionRequest, CompletionWay, KnownPicture, KnownTop, Painter,
    Painting, PaintingAside, Reference, TopPicture, TopViewRequest, Truth, TruthInstance,
};
pub use segmenter::{Segmentation, Segmenter, TopBoxes};
pub use upright::stood_up;

/// What a port answers with: a future that ends in a value or in a reason.
pub type Answer<'a, T> = BoxFuture<'a, Result<T, ProviderError>>;

/// Which adapter answers a port, with everything of it that can change an answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adapter {
    /// `embedded/grammar`, `openai/chat`.
    pub name: String,
    /// Raised by hand when the same question gets another answer than before; with the digest of its weights, where
    /// it has some; a remote adapter's is its model's name.
    pub model: String,
    /// The adapter's settings.
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

/// One adapter per port; cloning shares them.
#[derive(Clone)]
pub struct Ports {
    pub analyst: Arc<dyn SceneAnalyst>,
    pub painter: Arc<dyn Painter>,
    pub segmenter: Arc<dyn Segmenter>,
    pub mesh_generator: Arc<dyn MeshGenerator>,
    pub feature_extractor: Arc<dyn FeatureExtractor>,
}
