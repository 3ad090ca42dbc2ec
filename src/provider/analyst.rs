//! Port 1, the scene analyst: it describes a text, recognizes a picture (objects, table, camera, sizes,
//! what stands on what), and stands meshes up. The paper asks ChatGPT.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Adapter, Answer, Call, Completion, Port, ProviderError, Reference};
use crate::align::canonicalize::{CanonicalPose, CanonicalizeSettings};
use crate::align::dro::DroSettings;
use crate::geometry::{Camera, Image, TexturedMesh};
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

    /// Whether a drawn view from above shows the table as the reference picture does. Who cannot look says so: that is no
    /// yes.
    fn check_top_view<'a>(&'a self, _call: &'a Call, _question: TopCheck) -> Answer<'a, TopVerdict> {
        let adapter = self.adapter().name;
        let reason = "it looks at no drawings; put a chat provider into providers.analyst, or leave drawn views from \
                      above to the embedded painter";
        let unsupported =
            ProviderError::Unsupported { port: Port::Analyst, adapter, reason: reason.to_owned() };
        Box::pin(async move { Err(unsupported) })
    }
}

/// A drawn view from above, and what it was drawn after.
#[derive(Clone)]
pub struct TopCheck {
    pub reference: Reference,
    pub recognition: Arc<Recognition>,
    pub top: Arc<Image>,
    pub seed: u64,
}

/// What somebody who looked at a drawn view from above says.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TopVerdict {
    pub straight_down: bool,
    pub no_perspective: bool,
    /// The edge that is nearest in the reference picture is at the bottom.
    pub front_below: bool,
    pub all_there: bool,
    pub none_added: bool,
    /// What the painter should change, in a sentence.
    pub told: String,
}

impl TopVerdict {
    /// Whether places can be measured on the drawing.
    pub fn holds(&self) -> bool {
        self.straight_down && self.no_perspective && self.front_below && self.all_there && self.none_added
    }
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
