//! Measurements of a finished scene as rows of the store have them, also those of earlier versions.

use schemars::JsonSchema;

pub use certificate::SceneSummary;
use certificate::{Appearance, MethodShare, Regions};
use geometry::json_numbers::Fraction;
use scene::DepthAccount;

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
    /// Absent without a depth image.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub depth: Option<DepthAccount>,
    pub missed: Regions,
    pub invented: Regions,
    pub methods: Vec<MethodShare>,
    pub appearance: Appearance,
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
