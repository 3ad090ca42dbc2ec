//! Recognition of an image: camera, table, objects and their masks.

use glam::{DQuat, DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{InstanceId, RequestedPose, StandIn, TableShape};
use crate::instance::SupportRelation;
use crate::support_tree::{InvalidSupport, SupportTree, Supporter};
use crate::validation::{Violation, Violations, validated};
use geometry::{Camera, Outline, PosedPrimitive, Rgb};
use imaging::Mask;

/// Category of an object without a matching catalog category.
pub const UNNAMED_CATEGORY: &str = "object";

/// Open-vocabulary recognition of a reference image. A deserialized value is valid: names are unique and none is
/// `table`, sizes are positive, and the supports form a tree rooted at the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub struct Recognition {
    /// Intrinsics and pose relative to the table frame. The height above the table is up to scale until the metric
    /// anchor is known.
    pub camera: Camera,
    /// Source of the camera's angles.
    pub camera_is: CameraKnowledge,
    pub table: RecognizedTable,
    /// All objects without the table.
    pub objects: Vec<RecognizedObject>,
    /// Boxes of what was found in the image and left out, as it does not stand on the table: x0, y0 inclusive; x1, y1
    /// exclusive.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out_px: Vec<[u32; 4]>,
    /// Account of the depth image beside the image; `None` without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth: Option<DepthAccount>,
}

/// Account of the use of a depth image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(description = "Use of the depth image beside the image.")]
pub struct DepthAccount {
    /// Whether camera, scale and heights are from the depth; else they are from the image alone.
    pub is_used: bool,
    /// The same in words, with the reason where the depth was not used.
    pub note: String,
}

validated!(Recognition);

impl Recognition {
    /// Every violation of the guarantees.
    fn violations(&self) -> Vec<Violation> {
        let mut violations = Violations::default();
        violations.require_size(self.table.size_m, "/table/size_m");
        for (index, object) in self.objects.iter().enumerate() {
            let id = &object.id;
            let unique = !self.objects[..index].iter().any(|other| &other.id == id);
            violations.require(
                unique,
                format!("/objects/{index}/id"),
                format!("the name {id} is not unique"),
            );
            let allowed = id.as_str() != "table";
            violations.require(allowed, format!("/objects/{index}/id"), "the name table is reserved");
            violations.require_size(object.size_m, format!("/objects/{index}/size_m"));
            let mass = object.mass_kg.is_none_or(|mass_kg| mass_kg.is_finite() && mass_kg > 0.0);
            violations.require(mass, format!("/objects/{index}/mass_kg"), "must be positive");
        }
        if let Err(error @ (InvalidSupport::UnknownParent(index) | InvalidSupport::Cycle(index))) =
            self.support_tree()
        {
            violations.require(false, format!("/objects/{index}/stands_on"), error.to_string());
        }
        violations.into_vec()
    }

    /// The supports of the objects.
    ///
    /// # Errors
    ///
    /// [`InvalidSupport`] for an unknown supporter or a cycle, which a deserialized value cannot have.
    pub fn support_tree(&self) -> Result<SupportTree, InvalidSupport> {
        let position = |id: &InstanceId| self.objects.iter().position(|object| &object.id == id);
        // An unknown id becomes an index that is out of range.
        let parent = |id: &InstanceId| Some(position(id).unwrap_or(self.objects.len()));
        let supporter = |object: &RecognizedObject| match &object.stands_on {
            StandsOn::Table => Supporter::TABLE,
            StandsOn::On(id) => Supporter { parent: parent(id), relation: SupportRelation::On },
            StandsOn::In(id) => Supporter { parent: parent(id), relation: SupportRelation::In },
        };
        SupportTree::new(self.objects.iter().map(supporter).collect())
    }

    /// Height above the table of what an object stands on or in, meters: the sum of the heights of its supporters.
    /// `supports` is the tree of [`Self::support_tree()`].
    pub fn support_height_m(&self, supports: &SupportTree, index: usize) -> f64 {
        supports.ancestors(index).fold(0.0, |height_m, below| height_m + self.objects[below].size_m.z)
    }
}

/// Source of a recognized camera, by decreasing accuracy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraKnowledge {
    /// Exact: the image was rendered with this camera.
    Known,
    /// Measured from lines in the image.
    Measured,
    /// Estimated by a model; angles may be off by some degrees.
    Judged,
}

/// The table as recognized.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecognizedTable {
    pub label: String,
    pub shape: TableShape,
    /// The most similar catalog model.
    pub model: String,
    /// Outline of the top in the world, if no catalog model has this outline.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outline_m: Option<Outline>,
    /// Typical extents: width and depth of the top, height above the floor; meters.
    pub size_m: DVec3,
    pub color: Option<Rgb>,
    pub material: Option<String>,
    pub seed: u64,
}

/// One object as recognized.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecognizedObject {
    pub id: InstanceId,
    pub label: String,
    pub category: String,
    /// Typical extents as it stands: width, depth, height; meters.
    pub size_m: DVec3,
    /// Rotation of the upright mesh before anything else, where the object does not stand upright. `None` if it stands
    /// upright, or if the recognition adapter does not know.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tipped: Option<TippedPose>,
    pub color: Option<Rgb>,
    pub material: Option<String>,
    pub seed: u64,
    /// Supporter of the object, inferred from image and text.
    pub stands_on: StandsOn,
    /// Box of its visible part: x0, y0, x1, y1, pixels. `None` if the recognition adapter gives none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen_px: Option<[f64; 4]>,
    /// The primitive fitted to its pixels, in the world. For an object on another object, the primitive stands on the
    /// table along the same rays. `None` if the recognition adapter gives none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen_as: Option<PosedPrimitive>,
    /// The catalog mesh of its category that matches its pixels. `None` if the category is unknown or no mesh matches.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen_like: Option<CategoryStance>,
    /// The mass that a text states; otherwise it follows from volume and substance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// The requested object that this category replaces, where a text asks for one that the catalog does not have.
    #[serde(flatten, with = "crate::stand_in::fields")]
    pub stand_in: Option<StandIn>,
}

/// The pose of an object that does not stand upright.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TippedPose {
    pub pose: RequestedPose,
    /// Upright extents: width, depth, height; meters.
    pub upright_size_m: DVec3,
    /// Rotation from the frame of the upright object to that of the image.
    #[serde(default, rename = "tipped_from_upright_xyzw")]
    pub tipped_from_upright: DQuat,
}

/// Pose and size of a catalog mesh fitted to an object's pixels. For an object on another object, the mesh stands on
/// the table along the same rays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CategoryStance {
    /// Seed of the parametric catalog model.
    pub variant: u64,
    /// Center of its base in the world, meters.
    pub center: DVec2,
    /// Rotation about +z.
    pub yaw_rad: f64,
    /// Extents in its own frame, meters.
    pub size_m: DVec3,
    /// Intersection over union of its outline and the object's pixels, 0..1.
    pub overlap: f64,
}

/// Stacking relation of one object in a serialized recognition. Code works with [`Recognition::support_tree()`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", content = "object", rename_all = "snake_case")]
pub enum StandsOn {
    Table,
    On(InstanceId),
    In(InstanceId),
}

/// Mask of one instance in the reference image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InstanceMask {
    pub id: InstanceId,
    /// Visible pixels.
    pub visible: Mask,
}

/// Accuracy of mask edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MaskEdges {
    /// Exact to the pixel: from rendering, or from a per-pixel classification.
    Sharp,
    /// Generated by a model: edges may be eroded, thin parts may be missing, and there may be holes.
    Rough,
}

/// Box of one instance in the top view, pixels: x0, y0, x1, y1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TopBox {
    pub id: InstanceId,
    pub box_px: [f64; 4],
}
