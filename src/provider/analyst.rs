//! Port 1, the scene analyst: it describes a text, recognizes a picture (objects, table, camera, sizes,
//! what stands on what), and stands meshes up. The paper asks ChatGPT.

use std::sync::Arc;

use super::{Adapter, Answer, Call, Completion, Reference};
use crate::align::canonicalize::{CanonicalPose, CanonicalizeSettings};
use crate::align::dro::DroSettings;
use crate::geometry::{Camera, TexturedMesh};
use crate::scene::request::RequestOptions;
use crate::scene::{Recognition, RecognizedObject, SceneDescription};

/// Answers questions about texts, pictures and meshes.
pub trait SceneAnalyst: Send + Sync {
    fn adapter(&self) -> Adapter;

    /// A text becomes a detailed, layout-aware description.
    fn describe<'a>(
        &'a self,
        call: &'a Call,
        text: String,
        seed: u64,
        options: RequestOptions,
    ) -> Answer<'a, SceneDescription>;

    /// Camera, table and objects of a reference picture, with commonsense sizes (`measure`) and the
    /// stacking relation.
    fn recognize<'a>(
        &'a self,
        call: &'a Call,
        reference: Reference,
        seed: u64,
        options: RequestOptions,
    ) -> Answer<'a, Recognition>;

    /// Which of the 24 axis-aligned rotations stands a raw mesh as the picture shows it.
    fn upright<'a>(&'a self, call: &'a Call, question: UprightQuestion) -> Answer<'a, CanonicalPose>;
}

/// A raw mesh and what is known of its instance.
#[derive(Clone)]
pub struct UprightQuestion {
    /// As generated: any size, any of the 24 axis-aligned orientations.
    pub raw_mesh: Arc<TexturedMesh>,
    pub object: RecognizedObject,
    /// Of the reference picture.
    pub camera: Camera,
    pub completion: Completion,
    pub canonicalize: CanonicalizeSettings,
    pub dro: DroSettings,
}
