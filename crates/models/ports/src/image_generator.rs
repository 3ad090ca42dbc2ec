//! Port 2, the image generator: the reference image of a description, complete images of single objects, and top
//! views. The paper uses Seedream.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use super::{Adapter, Answer, Call};
use geometry::Camera;
use imaging::{DepthImage, Image, Mask};
use scene::predicates::Unmet;
use scene::{InstanceId, InstanceMask, MaskEdges, Recognition, RecognizedObject, SceneDescription};

/// Generates images.
pub trait ImageGenerator: Send + Sync {
    fn adapter(&self) -> Adapter;

    /// The reference image of a description; another seed gives another arrangement and view.
    fn reference<'a>(
        &'a self,
        call: &'a Call,
        description: Arc<SceneDescription>,
        seed: u64,
    ) -> Answer<'a, GeneratedReference>;

    /// A reference image from which objects are taken one by one. Where they stand does not matter, so that an adapter
    /// may draw it smaller and without a view from above.
    fn reference_of_objects<'a>(
        &'a self,
        call: &'a Call,
        description: Arc<SceneDescription>,
        seed: u64,
    ) -> Answer<'a, GeneratedReference> {
        self.reference(call, description, seed)
    }

    /// A clean, unoccluded image of one instance.
    fn complete<'a>(&'a self, call: &'a Call, request: CompletionRequest) -> Answer<'a, Completion>;

    /// The table from straight above, orthographic, with every instance in place.
    fn top_view<'a>(&'a self, call: &'a Call, request: TopViewRequest) -> Answer<'a, TopViewImage>;
}

/// A generated reference image.
#[derive(Clone, Debug)]
pub struct GeneratedReference {
    pub image: Image,
    /// Demands of the description that a known arrangement does not meet; empty where the arrangement is not known.
    pub unmet: Vec<Unmet>,
    /// Present where the image was rendered from a known arrangement.
    pub ground_truth: Option<SyntheticGroundTruth>,
}

/// Ground truth and auxiliary renders of a rendered reference image.
#[derive(Clone, Debug)]
pub struct SyntheticGroundTruth {
    pub known: ImageAnnotations,
    /// The demands that the finished scene is compared with.
    pub stated: SceneDescription,
    /// For tests and evaluation; no stage takes it as input.
    pub truth: Truth,
    /// Each object rendered without the others, as `complete` returns.
    pub alone: Vec<IsolatedRender>,
    /// The same arrangement from above, as `top_view` returns; absent where only the objects were wanted.
    pub top: Option<TopViewImage>,
}

/// `reference/known.json`: labels, masks and camera of a rendered image. Other embedded adapters may read it instead of
/// analyzing the image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImageAnnotations {
    /// Labels, categories, commonsense sizes, supports, camera and table.
    pub recognition: Recognition,
    /// Visible pixels of each object, in the order of `recognition.objects`; empty where the object is hidden.
    pub masks: Vec<InstanceMask>,
    /// Accuracy of `masks` along the edges of objects.
    pub mask_edges: MaskEdges,
    /// Visible pixels of the table.
    pub table_mask: Mask,
}

/// `reference/truth.json`: the rendered arrangement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Instances, named as in the scene.
    pub instances: Vec<TruthInstance>,
}

/// The pose of one object in the rendered arrangement, after settling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthInstance {
    pub name: InstanceId,
    pub translation_m: DVec3,
    pub rotation_xyzw: DQuat,
    /// `None` within 10 degrees of lying upside down.
    pub yaw_rad: Option<f64>,
    /// Extents of the mesh in the object frame, meters.
    pub size_m: DVec3,
    /// 0 = any angle.
    pub symmetry_order: u32,
}

/// One object rendered without the others, from the camera of the reference image.
#[derive(Clone, Debug, PartialEq)]
pub struct IsolatedRender {
    pub id: InstanceId,
    pub completion: Completion,
}

/// A reference image as input of the later ports.
#[derive(Clone)]
pub struct ReferenceImage {
    pub image: Arc<Image>,
    /// The annotations of a rendered image; `None` for any other image.
    pub known: Option<Arc<ImageAnnotations>>,
    /// Depths of the pixels, in the size of the image.
    pub depth: Option<Arc<DepthImage>>,
}

/// The instance to complete.
#[derive(Clone)]
pub struct CompletionRequest {
    pub reference: ReferenceImage,
    pub object: RecognizedObject,
    /// Visible pixels of the object.
    pub visible: Mask,
    /// Pixels of the other instances, which may hide the object.
    pub others: Mask,
    /// The camera of the image, where it is known.
    pub camera: Option<Camera>,
    /// The isolated render by the generator of the reference image, where there is one.
    pub alone: Option<Completion>,
}

/// A clean image of one instance.
#[derive(Clone, Debug, PartialEq)]
pub struct Completion {
    /// Transparent outside the instance.
    pub image: Image,
    /// The crop of the reference image that `image` shows: x0, y0, x1, y1, pixels.
    pub crop_px: [f64; 4],
    /// The amodal silhouette of the instance, of the size of the reference image.
    pub silhouette: Mask,
    /// Silhouette pixels that were not visible, as a share of the silhouette, 0..1.
    pub completed_share: f64,
    /// The methods that inferred hidden pixels without a generator, with shares of the silhouette.
    pub completed_by: Vec<CompletedBy>,
}

/// The share of a silhouette that one method inferred, 0..1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CompletedBy {
    pub way: CompletionWay,
    pub share: f64,
}

/// A method that infers the hidden part of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CompletionWay {
    /// The mirror image of the visible part.
    Symmetry,
    /// The continued shape, with the texture of the visible part.
    NeighboringTexture,
}

impl CompletionWay {
    /// The method in words, as in "completed by".
    pub fn words(self) -> &'static str {
        match self {
            Self::Symmetry => "symmetry",
            Self::NeighboringTexture => "neighboring texture",
        }
    }
}

/// The image whose table is to be shown from above.
#[derive(Clone)]
pub struct TopViewRequest {
    pub reference: ReferenceImage,
    pub recognition: Arc<Recognition>,
    /// Visible pixels of each instance, in the order of `recognition.objects`.
    pub masks: Arc<Vec<InstanceMask>>,
    /// The top view by the generator of the reference image, where there is one.
    pub rendered: Option<TopViewImage>,
    /// The reasons why earlier top views were rejected, in order.
    pub refused: Vec<String>,
}

/// The table from straight above: image right = world +x, image up = world +y, one scale throughout.
#[derive(Clone, Debug, PartialEq)]
pub struct TopViewImage {
    pub image: Image,
    /// The masks of a rendered top view; `None` for any other.
    pub known: Option<TopViewAnnotations>,
}

/// Masks on a top view, without its scale.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TopViewAnnotations {
    /// The whole table top, including occluded parts.
    pub table: Mask,
    /// Amodal masks of the objects (objects stacked on them do not hide them), in the order of recognition.
    pub objects: Vec<InstanceMask>,
}
