//! Measurements of a finished scene: documents of the pipeline.

use schemars::JsonSchema;

use super::edit_accounts::EditAccount;
use super::texts::TextAccount;
use super::values::Nullable;

/// Measurements of a finished scene; `docs/formats.md` defines them.
#[derive(JsonSchema)]
pub struct Metrics {
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub col_o: Option<Fraction>,
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub col_s: Option<Fraction>,
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub ss: Option<Fraction>,
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub dss_aligned: Option<Fraction>,
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub dss_shipped: Option<Fraction>,
}

/// Summary of a finished scene.
#[derive(JsonSchema)]
pub struct Summary {
    /// The id of the scene in its bundle (`id` of `scene.json`), a digest of what it was made from.
    #[schemars(skip_serializing_if = "Option::is_none", regex(pattern = r"^[0-9a-f]{20}$"))]
    pub bundle_id: Option<String>,
    /// Number of objects.
    #[schemars(skip_serializing_if = "Option::is_none", range(min = 0, max = 10_000))]
    pub objects: Option<u32>,
    /// Label of the table.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub table: Option<String>,
    /// The verdict in words, with the number of stand-ins.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub verdict_text: Option<String>,
    /// The account of the text; null for an image. That of an edited scene has what still holds.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub text: Option<Nullable<TextAccount>>,
    /// Result of the edit; null for other scenes.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub edit: Option<Nullable<EditAccount>>,
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub fidelity: Option<Fidelity>,
    /// Changes made by the stage `resolve`.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub resolve: Option<Vec<String>>,
    /// Objects that were made smaller or moved for lack of space.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub gave_way: Option<Vec<Relaxation>>,
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub robot: Option<RobotFinding>,
}

/// Abilities of the robot of the request in the scene, as in `report.json`; absent where none was asked for.
#[derive(JsonSchema)]
pub struct RobotFinding {
    /// Name of the robot.
    pub name: String,
    /// Number of objects that are for grippers.
    #[schemars(range(min = 0, max = 10_000))]
    pub objects: u32,
    /// Number of them that it can pick up where they are.
    #[schemars(range(min = 0, max = 10_000))]
    pub pickable: u32,
    /// Number of tasks that were proposed.
    #[schemars(range(min = 0, max = 3))]
    pub tasks_proposed: u32,
    /// Number of them that it did in simulation.
    #[schemars(range(min = 0, max = 3))]
    pub tasks_done: u32,
    #[schemars(length(max = 3))]
    pub tasks: Vec<TriedTask>,
}

/// A proposed task, and what became of it.
#[derive(JsonSchema)]
pub struct TriedTask {
    /// In words.
    pub instruction: String,
    /// `done`, or the code of a failure or a refusal.
    #[schemars(regex(pattern = r"^[a-z_]+$"))]
    pub outcome: String,
}

/// Similarity of the finished scene to the reference image from the same camera, as in `report.json`.
#[derive(JsonSchema)]
pub struct Fidelity {
    /// Whether the verdict depends on it; not where the program rendered the reference image. Absent in scenes of
    /// earlier versions, where it does.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub is_judged: Option<bool>,
    pub silhouette_iou: Fraction,
    /// Mean CIELAB distance (CIE 1976) where both show the same object.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub color_difference: Option<f64>,
    /// Boxes of what was found in the image and does not stand on the table. Absent where there is none.
    #[schemars(
        skip_serializing_if = "Option::is_none",
        inner(inner(range(min = 0, max = 100_000)), length(equal = 4))
    )]
    pub left_out_px: Option<Vec<Vec<u32>>>,
    pub missed: Regions,
    pub invented: Regions,
    pub methods: Vec<MethodShare>,
    pub appearance: Appearance,
}

/// Pixels with objects in only one of the two images.
#[derive(JsonSchema)]
pub struct Regions {
    pub share: Fraction,
    pub largest: Vec<Region>,
}

/// A connected region.
#[derive(JsonSchema)]
pub struct Region {
    /// The object with most of its pixels; the table where the image shows something there that no object is.
    pub body: String,
    /// Left and upper side, both inclusive; right and lower side, both exclusive.
    #[schemars(inner(range(min = 0, max = 65_535)), length(equal = 4))]
    pub bbox_px: Vec<u32>,
    pub image_share: Fraction,
}

/// Number of objects whose meshes were made in one way.
#[derive(JsonSchema)]
pub struct MethodShare {
    pub method: ReconstructionMethod,
    #[schemars(range(min = 0, max = 10_000))]
    pub objects: u32,
    pub share: Fraction,
}

/// Method by which the shape of a mesh was found.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum ReconstructionMethod {
    Category,
    Turned,
    Box,
    Slab,
    Extrusion,
    Inflation,
    Generated,
}

/// Similarity by a feature extractor; those of different extractors cannot be compared.
#[derive(JsonSchema)]
pub struct Appearance {
    pub extractor: String,
    pub model: String,
    #[schemars(range(min = -1.001, max = 1.001))]
    pub similarity: f64,
}

/// An object that was made smaller or moved for lack of space.
#[derive(JsonSchema)]
pub struct Relaxation {
    pub name: String,
    pub outcome: RelaxationOutcome,
    /// Of what was shrunk: the factor on its size.
    #[schemars(skip_serializing_if = "Option::is_none", range(min = 0.0, max = 1.0))]
    pub scale: Option<f64>,
    /// Of what was moved to the table: what was to carry it.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub from: Option<String>,
}

/// Change of an object that has no room.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum RelaxationOutcome {
    Shrunk,
    Moved,
}

/// A share.
#[derive(JsonSchema)]
pub struct Fraction(#[schemars(range(min = 0.0, max = 1.0))] pub f64);
