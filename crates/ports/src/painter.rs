//! Port 2, the painter: it paints the reference picture of a description, redraws instances without what
//! hides them, and paints the table from straight above. The paper asks Seedream.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use super::{Adapter, Answer, Call};
use geometry::Camera;
use imaging::{Image, Mask};
use scene::{InstanceId, InstanceMask, MaskEdges, Recognition, RecognizedObject, SceneDescription};

/// Paints pictures.
pub trait Painter: Send + Sync {
    fn adapter(&self) -> Adapter;

    /// The reference picture of a description; another seed, another arrangement and view.
    fn reference<'a>(
        &'a self,
        call: &'a Call,
        description: Arc<SceneDescription>,
        seed: u64,
    ) -> Answer<'a, Painting>;

    /// A clean, unoccluded picture of one instance, redrawn.
    fn complete<'a>(&'a self, call: &'a Call, request: CompletionRequest) -> Answer<'a, Completion>;

    /// The table from straight above, orthographic, every instance in its place.
    fn top_view<'a>(&'a self, call: &'a Call, request: TopViewRequest) -> Answer<'a, TopPicture>;
}

/// A painted reference picture.
#[derive(Clone, Debug)]
pub struct Painting {
    pub picture: Image,
    /// What only a painter that is a program has beside the picture itself.
    pub aside: Option<PaintingAside>,
}

/// What a painter that is a program knows of its own picture.
#[derive(Clone, Debug)]
pub struct PaintingAside {
    pub known: KnownPicture,
    /// For tests and evaluation; no stage takes it as input.
    pub truth: Truth,
    /// Each object drawn alone, as `complete` answers.
    pub alone: Vec<Alone>,
    /// The same arrangement from above, as `top_view` answers.
    pub top: TopPicture,
}

/// `reference/known.json`: labels, masks and camera of a painted picture. Other embedded adapters may
/// read it in place of looking.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KnownPicture {
    /// Labels, categories, commonsense sizes, supports, camera and table.
    pub recognition: Recognition,
    /// Visible pixels of each object, in the order of `recognition.objects`; empty where it is hidden.
    pub masks: Vec<InstanceMask>,
    /// How closely `masks` follow the picture.
    pub mask_edges: MaskEdges,
    /// Visible pixels of the table.
    pub table_mask: Mask,
}

/// `reference/truth.json`: the arrangement the picture was painted from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Named as in the scene.
    pub instances: Vec<TruthInstance>,
}

/// One object as it stood when it was painted (after settling).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthInstance {
    pub name: InstanceId,
    pub translation_m: DVec3,
    pub rotation_xyzw: DQuat,
    /// `None` within 10 degrees of lying upside down.
    pub yaw_rad: Option<f64>,
    /// Extents of its mesh in its own frame.
    pub size_m: DVec3,
    /// 0 = any angle.
    pub symmetry_order: u32,
}

/// One object drawn without the others, from the camera of the reference picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Alone {
    pub id: InstanceId,
    pub completion: Completion,
}

/// A reference picture as the later ports see it.
#[derive(Clone)]
pub struct Reference {
    pub picture: Arc<Image>,
    /// What its painter knows of it; `None` for a picture nobody here painted.
    pub known: Option<Arc<KnownPicture>>,
}

/// One instance to be redrawn.
#[derive(Clone)]
pub struct CompletionRequest {
    pub reference: Reference,
    pub object: RecognizedObject,
    /// Pixels where it shows.
    pub visible: Mask,
    /// Pixels of the other instances: they may hide it.
    pub others: Mask,
    /// What saw the picture, where it is known.
    pub camera: Option<Camera>,
    /// Drawn alone already, by the painter of the reference picture.
    pub alone: Option<Completion>,
}

/// A clean picture of one instance.
#[derive(Clone, Debug, PartialEq)]
pub struct Completion {
    /// Transparent where the instance is not.
    pub picture: Image,
    /// The part of the reference picture it shows: x0, y0, x1, y1, pixels.
    pub shown_px: [f64; 4],
    /// The instance's whole silhouette, as large as the reference picture.
    pub silhouette: Mask,
    /// Silhouette pixels that were not visible, as a share of the silhouette, 0..1.
    pub completed_share: f64,
    /// How they were guessed, as far as nobody drew them: shares of the silhouette.
    pub completed_by: Vec<CompletedBy>,
}

/// A share of a silhouette that was guessed in one way, 0..1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CompletedBy {
    pub way: CompletionWay,
    pub share: f64,
}

/// How what is hidden of a thing is guessed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CompletionWay {
    /// As the mirror image of what is visible.
    Symmetry,
    /// As the shape goes on, in the texture of what is visible.
    NeighboringTexture,
}

impl CompletionWay {
    /// The way in words, as in "completed by".
    pub fn words(self) -> &'static str {
        match self {
            Self::Symmetry => "symmetry",
            Self::NeighboringTexture => "neighboring texture",
        }
    }
}

/// The picture to be seen from above.
#[derive(Clone)]
pub struct TopViewRequest {
    pub reference: Reference,
    pub recognition: Arc<Recognition>,
    /// Pixels where each instance shows, in the order of `recognition.objects`.
    pub masks: Arc<Vec<InstanceMask>>,
    /// Painted already, by the painter of the reference picture.
    pub painted: Option<TopPicture>,
    /// Why earlier drawings were refused, in their order.
    pub refused: Vec<String>,
}

/// The table from straight above: picture right = world +x, picture up = world +y, one scale throughout.
#[derive(Clone, Debug, PartialEq)]
pub struct TopPicture {
    pub picture: Image,
    /// Where things are on it, if its maker knows.
    pub known: Option<KnownTop>,
}

/// Masks on a top view; its scale stays unsaid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KnownTop {
    /// The whole table top, whatever stands on it.
    pub table: Mask,
    /// Whole outlines of the objects (what is stacked on them does not hide them), in the order of the
    /// recognized objects.
    pub objects: Vec<InstanceMask>,
}
