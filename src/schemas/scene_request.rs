//! Requests for scenes as clients send them and as they are kept, and their options: types of the crate `scene`.

use std::collections::BTreeMap;

use schemars::JsonSchema;

use super::edits::EditOperations;
use super::scene_settings::SceneSettings;
use super::values::{MAX_INTEGER, Sha256};

/// Pairs of words for the client's own use.
#[derive(Default, JsonSchema)]
#[schemars(extend(
    "maxProperties" = 32,
    "propertyNames" = { "pattern": r"^[A-Za-z0-9_.-]{1,63}$" },
))]
pub struct Labels(pub BTreeMap<String, LabelValue>);

/// Labels to set; null removes one.
#[derive(Default, JsonSchema)]
#[schemars(extend("propertyNames" = { "pattern": r"^[A-Za-z0-9_.-]{1,63}$" }))]
pub struct LabelsPatch(pub BTreeMap<String, Option<LabelValue>>);

/// Value of a label.
#[derive(JsonSchema)]
#[schemars(inline)]
pub struct LabelValue(
    #[schemars(length(max = 255), regex(pattern = r"^[^\x00-\x1F\x7F-\x9F]*$"))] pub String,
);

/// Options of each scene.
#[derive(Default, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Options {
    pub table: Option<TableSpec>,
    pub metric_anchor: Option<MetricAnchor>,
    /// More objects are refused.
    #[schemars(range(min = 1, max = 64))]
    pub max_objects: Option<u32>,
    pub on_unknown: Option<OnUnknown>,
    /// The most that calls of remote models may cost together; the server's usual budget when absent.
    #[schemars(range(min = 0.0, max = 10000.0))]
    pub budget_usd: Option<f64>,
    /// A robot that is tried in the finished scene, such as `panda`: its grasps of each object, what it can pick up,
    /// and tasks. Takes seconds for each object.
    #[schemars(length(min = 1, max = 63))]
    pub robot: Option<String>,
    #[schemars(default)]
    pub set: SceneSettings,
}

/// Properties of the table; the catalog chooses those that are absent.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct TableSpec {
    pub shape: Option<TableShape>,
    /// Width and depth of the top and its height above the floor, meters.
    pub size_m: Option<TableSize>,
    #[schemars(length(min = 1, max = 63))]
    pub model: Option<String>,
    #[schemars(length(min = 1, max = 63))]
    pub material: Option<String>,
    #[schemars(length(min = 1, max = 63))]
    pub color: Option<String>,
}

/// A known width in the scene.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct MetricAnchor {
    /// A label of an object, or `table`.
    #[schemars(length(min = 1, max = 100))]
    pub object: String,
    #[schemars(range(min = 0.001, max = 10.0))]
    pub width_m: f64,
}

/// Treatment of parts of the text that are not understood; `stand_in` when absent.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum OnUnknown {
    Fail,
    StandIn,
    Drop,
}

/// Outline of the top of the table.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum TableShape {
    Rectangular,
    Square,
    Round,
    Oval,
    Triangular,
    Irregular,
}

/// The request as it is kept, with the seed that was drawn.
#[derive(JsonSchema)]
pub struct StoredRequest {
    #[schemars(range(min = 1, max = 1000))]
    pub version: u32,
    pub input: Input,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub seed: u64,
    pub options: Options,
}

/// The source of a scene.
#[derive(JsonSchema)]
pub struct Input {
    pub kind: InputKind,
    /// The text; of an image, the one beside it; of an edit, its instruction.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// Of an image.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub sha256: Option<Sha256>,
    /// Of an image.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub media_type: Option<String>,
    /// Of an edit or a variant: the id in the `scene.json` of the parent.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// Of an edit or a variant: the archive of the parent.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub bundle_sha256: Option<Sha256>,
    /// Of an edit.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub operations: Option<EditOperations>,
    /// Of a variant.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub randomize: Option<Randomize>,
}

/// The source of the scene.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum InputKind {
    Text,
    Image,
    Edit,
    Variant,
}

/// The axes along which variants differ.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Randomize {
    /// Places on the table, within the stated relations.
    #[schemars(default)]
    pub layout: bool,
    /// Other meshes of the same category.
    #[schemars(default)]
    pub meshes: bool,
    /// Sizes by a factor from 1 - x to 1 + x.
    #[schemars(default, range(min = 0.0, max = 0.3))]
    pub sizes: f64,
    /// Colors of objects.
    #[schemars(default)]
    pub colors: bool,
    /// Materials of vessels and dishes, which change mass and friction.
    #[schemars(default)]
    pub materials: bool,
    /// The material of the table.
    #[schemars(default)]
    pub table: bool,
    /// Direction and brightness of the light.
    #[schemars(default)]
    pub light: bool,
    /// Azimuth, elevation, distance and focal length of the reference camera.
    #[schemars(default)]
    pub camera: bool,
    /// Masses by a factor from 1 - x to 1 + x.
    #[schemars(default, range(min = 0.0, max = 0.5))]
    pub mass: f64,
    /// Friction by a factor from 1 - x to 1 + x.
    #[schemars(default, range(min = 0.0, max = 0.5))]
    pub friction: f64,
}

/// Width and depth of the top and its height above the floor, meters.
#[derive(JsonSchema)]
#[schemars(inline)]
pub struct TableSize(
    #[schemars(range(min = 0.2, max = 5.0))] pub f64,
    #[schemars(range(min = 0.2, max = 5.0))] pub f64,
    #[schemars(range(min = 0.1, max = 2.0))] pub f64,
);
