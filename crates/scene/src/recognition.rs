//! What is seen in a picture: the camera, the table, the objects, and where each one shows.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::{InstanceId, TableShape};
use geometry::{Camera, Outline, Rgb, SolidFit};
use imaging::Mask;

/// The category of an object that no category of the catalog describes.
pub const UNNAMED_CATEGORY: &str = "object";

/// Open-vocabulary recognition of a reference picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recognition {
    /// Intrinsics and pose relative to the table frame (its height above the table is up to scale
    /// until the anchor is known).
    pub camera: Camera,
    /// What the camera's angles come from.
    pub camera_is: CameraKnowledge,
    pub table: RecognizedTable,
    /// The table is not among them.
    pub objects: Vec<RecognizedObject>,
}

/// How well a recognized camera is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraKnowledge {
    /// Exactly: its picture was painted with it.
    Known,
    /// Read off lines in the picture.
    Measured,
    /// A model said so; its angles may be some degrees off.
    Judged,
}

/// The table as recognized.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecognizedTable {
    pub label: String,
    pub shape: TableShape,
    /// Catalog model that looks like it.
    pub model: String,
    /// Edge of the top in the world, where no model has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outline_m: Option<Outline>,
    /// Commonsense extents: width, depth of the top, height above the floor; meters.
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
    /// Commonsense extents as it stands: width, depth, height; meters.
    pub size_m: DVec3,
    pub color: Option<Rgb>,
    pub material: Option<String>,
    pub seed: u64,
    /// What it stands on or in, as far as it can be told from picture and words.
    pub stands_on: StandsOn,
    /// Box around what shows of it: x0, y0, x1, y1, pixels; `None` where recognition does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen_px: Option<[f64; 4]>,
    /// The solid that its pixels were read as, in the world; where it stands on another thing, as if it stood on the table
    /// along the same rays. `None` where recognition does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen_as: Option<SolidFit>,
    /// The catalog's mesh of its category that shows where it shows; `None` where no category is known or none shows so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen_like: Option<CategoryStance>,
}

/// A mesh of the catalog, stood where a thing was seen; where that stands on another thing, as if it stood on the table along
/// the same rays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CategoryStance {
    /// Seed of the catalog's recipe.
    pub variant: u64,
    /// Middle of its base in the world, meters.
    pub center: DVec2,
    /// Turn about +z.
    pub yaw_rad: f64,
    /// Extents in its own frame, meters.
    pub size_m: DVec3,
    /// Intersection over union of its outline with the thing's pixels, 0..1.
    pub overlap: f64,
}

/// Stacking relation of one object.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", content = "object", rename_all = "snake_case")]
pub enum StandsOn {
    Table,
    On(InstanceId),
    In(InstanceId),
}

impl StandsOn {
    /// The supporting object; `None` = the table.
    pub fn object(&self) -> Option<&InstanceId> {
        match self {
            Self::Table => None,
            Self::On(id) | Self::In(id) => Some(id),
        }
    }
}

/// One instance's pixels in the reference picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InstanceMask {
    pub id: InstanceId,
    /// Pixels where it shows.
    pub visible: Mask,
}

/// How closely masks follow the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MaskEdges {
    /// To the pixel: the picture was painted with them, or every pixel was looked at.
    Sharp,
    /// A model drew them: edges may be eaten into, thin parts gone, insides holed.
    Rough,
}

/// One instance's box in the top view, pixels: x0, y0, x1, y1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TopBox {
    pub id: InstanceId,
    pub box_px: [f64; 4],
}
