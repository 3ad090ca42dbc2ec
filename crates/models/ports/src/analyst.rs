//! Port 1, the scene analyst: scene descriptions from texts, recognition of images (objects, table, camera, sizes,
//! supports), upright orientation of meshes, checks of top views, ratings of scenes, and robot tasks. The paper uses
//! ChatGPT.

use std::sync::Arc;

use glam::DQuat;
use serde::{Deserialize, Serialize};

use super::{Adapter, Answer, Call, Completion, Port, ProviderError, RecognitionHints, ReferenceImage};
use geometry::{Camera, TexturedMesh};
use imaging::Image;
use pose_estimation::upright::{UprightPose, UprightSettings};
use pose_estimation::yaw::YawSettings;
use scene::appraisal::{ModelResponse, ProposedTask, Rating};
use scene::instance::SupportRelation;
use scene::request::RequestOptions;
use scene::{InstanceId, Recognition, RecognizedObject, SceneDescription};

/// Answers questions about texts, images and meshes.
pub trait SceneAnalyst: Send + Sync {
    fn adapter(&self) -> Adapter;

    /// A detailed, layout-aware description of a text.
    fn describe<'a>(
        &'a self,
        call: &'a Call,
        text: String,
        seed: u64,
        options: RequestOptions,
    ) -> Answer<'a, SceneDescription>;

    /// Camera, table and objects of a reference image, with commonsense sizes and supports. `hints` are what a text
    /// says is in the image, with the contract of [`RecognitionHints`].
    fn recognize<'a>(
        &'a self,
        call: &'a Call,
        reference: ReferenceImage,
        seed: u64,
        options: RequestOptions,
        hints: Option<Arc<RecognitionHints>>,
    ) -> Answer<'a, Recognition>;

    /// The identity of the adapter when it recognizes an image with hints.
    fn adapter_with_hints(&self) -> Adapter {
        self.adapter()
    }

    /// The axis-aligned rotation, one of 24, that orients a raw mesh upright as in the image.
    fn upright<'a>(&'a self, call: &'a Call, question: UprightQuestion) -> Answer<'a, Upright>;

    /// Judges whether a generated top view shows the table of the reference image. Adapters without image input return
    /// `Unsupported`; callers must not treat that as acceptance.
    fn check_top_view<'a>(&'a self, _call: &'a Call, _question: TopCheck) -> Answer<'a, TopVerdict> {
        let reason = "it checks no generated images; put a chat provider into providers.analyst, or leave views from \
                      above to the embedded image generator";
        cannot(self.adapter(), reason)
    }

    /// Ratings of a finished scene by the criteria of the paper. Adapters without a rating model return `Unsupported`;
    /// no default score replaces it.
    fn judge<'a>(&'a self, _call: &'a Call, _question: Judgement) -> Answer<'a, ModelResponse<Vec<Rating>>> {
        let reason = "it has no opinion of scenes; put a chat provider into providers.analyst, or set appraise.ratings = false";
        cannot(self.adapter(), reason)
    }

    /// Robot tasks in a finished scene.
    fn propose_tasks<'a>(
        &'a self,
        _call: &'a Call,
        _question: TaskQuestion,
    ) -> Answer<'a, ModelResponse<Vec<ProposedTask>>> {
        let reason =
            "it thinks of no tasks; put a chat provider into providers.analyst, or set appraise.tasks = 0";
        cannot(self.adapter(), reason)
    }
}

fn cannot<'a, T>(adapter: Adapter, reason: &str) -> Answer<'a, T> {
    let (adapter, reason) = (adapter.name, reason.to_owned());
    Box::pin(async move { Err(ProviderError::Unsupported { port: Port::Analyst, adapter, reason }) })
}

/// A generated top view and its inputs.
#[derive(Clone)]
pub struct TopCheck {
    pub reference: ReferenceImage,
    pub recognition: Arc<Recognition>,
    pub top: Arc<Image>,
    pub seed: u64,
}

/// The result of the check of a top view.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TopVerdict {
    pub straight_down: bool,
    pub no_perspective: bool,
    /// The edge that is nearest in the reference image is at the bottom.
    pub front_below: bool,
    pub all_there: bool,
    pub none_added: bool,
    /// Feedback to the image generator, one sentence.
    pub feedback: String,
}

impl TopVerdict {
    /// Whether positions can be measured on the top view.
    pub fn holds(&self) -> bool {
        self.straight_down && self.no_perspective && self.front_below && self.all_there && self.none_added
    }
}

/// A raw mesh and the data of its instance.
#[derive(Clone)]
pub struct UprightQuestion {
    /// The generated mesh, of any size, in any of the 24 axis-aligned orientations.
    pub raw_mesh: Arc<TexturedMesh>,
    pub object: RecognizedObject,
    /// The camera of the reference image.
    pub camera: Camera,
    pub completion: Completion,
    pub canonicalize: UprightSettings,
    pub dro: YawSettings,
}

/// The upright pose of a raw mesh, and the evidence of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Upright {
    pub pose: UprightPose,
    /// The answers of a model that was shown the mesh, in order; `pose` decides, and weighs them with other evidence.
    pub views: Vec<UprightView>,
}

/// The answer of a model to the side views of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UprightView {
    /// The side view that is the top of the mesh as shown, and the one that is its front.
    pub top: String,
    pub front: String,
    /// `canonical_from_raw` by this view and the earlier ones.
    pub rotation_xyzw: DQuat,
}

/// A finished scene and its input.
#[derive(Clone)]
pub struct Judgement {
    pub after: MadeAfter,
    /// The scene from the camera of the reference image.
    pub scene_view: Arc<Image>,
    pub seed: u64,
}

/// The input of a scene.
#[derive(Clone)]
pub enum MadeAfter {
    Text(String),
    Image(Arc<Image>),
}

/// The objects for which tasks are requested.
#[derive(Clone, Debug)]
pub struct TaskQuestion {
    pub objects: Vec<TaskObject>,
    /// The number of requested tasks.
    pub count: u32,
    pub seed: u64,
}

/// The properties of an object of a finished scene.
#[derive(Clone, Debug, Serialize)]
pub struct TaskObject {
    pub name: InstanceId,
    pub label: String,
    pub material: Option<String>,
    /// Width, depth, height, meters.
    pub size_m: [f64; 3],
    pub mass_kg: f64,
    /// Relation to the support: on it or in it.
    pub relation: SupportRelation,
    /// The support: `table`, or a name.
    pub carried_by: String,
}
