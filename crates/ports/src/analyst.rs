//! Port 1, the scene analyst: it describes a text, recognizes a picture (objects, table, camera, sizes, what
//! stands on what), stands meshes up, looks at drawn views from above, rates finished scenes and proposes
//! tasks in them. The paper asks ChatGPT.

use std::sync::Arc;

use glam::DQuat;
use serde::{Deserialize, Serialize};

use super::{Adapter, Answer, Call, Completion, Port, ProviderError, Reference};
use geometry::{Camera, TexturedMesh};
use imaging::Image;
use pose_estimation::canonicalize::{CanonicalPose, CanonicalizeSettings};
use pose_estimation::dro::DroSettings;
use scene::appraisal::{Opinion, ProposedTask, Rating};
use scene::instance::SupportRelation;
use scene::request::RequestOptions;
use scene::{InstanceId, Recognition, RecognizedObject, SceneDescription};

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
    fn upright<'a>(&'a self, call: &'a Call, question: UprightQuestion) -> Answer<'a, Upright>;

    /// Whether a drawn view from above shows the table as the reference picture does. Who cannot look says
    /// so: that is no yes.
    fn check_top_view<'a>(&'a self, _call: &'a Call, _question: TopCheck) -> Answer<'a, TopVerdict> {
        let reason = "it looks at no drawings; put a chat provider into providers.analyst, or leave drawn views from \
                      above to the embedded painter";
        cannot(self.adapter(), reason)
    }

    /// How good a finished scene looks, as the paper has it rated. Who has no opinion says so: there is no
    /// number in its place.
    fn judge<'a>(&'a self, _call: &'a Call, _question: Judgement) -> Answer<'a, Opinion<Vec<Rating>>> {
        let reason = "it has no opinion of scenes; put a chat provider into providers.analyst, or set appraise.ratings = false";
        cannot(self.adapter(), reason)
    }

    /// What a robot could do in a finished scene.
    fn propose_tasks<'a>(
        &'a self,
        _call: &'a Call,
        _question: TaskQuestion,
    ) -> Answer<'a, Opinion<Vec<ProposedTask>>> {
        let reason =
            "it thinks of no tasks; put a chat provider into providers.analyst, or set appraise.tasks = 0";
        cannot(self.adapter(), reason)
    }
}

fn cannot<'a, T>(adapter: Adapter, reason: &str) -> Answer<'a, T> {
    let (adapter, reason) = (adapter.name, reason.to_owned());
    Box::pin(async move { Err(ProviderError::Unsupported { port: Port::Analyst, adapter, reason }) })
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

/// How a raw mesh is to be turned, and how that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Upright {
    pub pose: CanonicalPose,
    /// Where a model looked at the mesh: each look, in order. What counts is the pose, which the picture has
    /// a say in.
    pub looks: Vec<UprightLook>,
}

/// What somebody says who has looked at a mesh from all sides.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UprightLook {
    /// The side, as the mesh was turned then, that belongs on top, and the one that is its front.
    pub top: String,
    pub front: String,
    /// `canonical_from_raw` that follows from this look and those before it.
    pub rotation_xyzw: DQuat,
}

/// A finished scene, and what it was made after.
#[derive(Clone)]
pub struct Judgement {
    pub after: MadeAfter,
    /// The scene from the camera of the reference picture.
    pub scene_view: Arc<Image>,
    pub seed: u64,
}

/// What a scene was made after.
#[derive(Clone)]
pub enum MadeAfter {
    Text(String),
    Picture(Arc<Image>),
}

/// What there is to do something with.
#[derive(Clone, Debug)]
pub struct TaskQuestion {
    pub things: Vec<TaskThing>,
    /// How many tasks are wanted.
    pub count: u32,
    pub seed: u64,
}

/// A thing of a finished scene, in words and numbers.
#[derive(Clone, Debug, Serialize)]
pub struct TaskThing {
    pub name: InstanceId,
    pub label: String,
    pub material: Option<String>,
    /// Width, depth, height, meters.
    pub size_m: [f64; 3],
    pub mass_kg: f64,
    /// Whether it stands on or in what carries it.
    pub relation: SupportRelation,
    /// What carries it: `table`, or a name.
    pub carried_by: String,
}
