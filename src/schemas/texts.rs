//! Parts of the account of a text as objects without alternatives.

use schemars::JsonSchema;

use scene::name::Names;
use scene::text_account::TextSpan;

/// A part of the text and its meaning.
#[derive(JsonSchema)]
pub struct Understood {
    pub span: TextSpan,
    pub kind: MeaningKind,
    /// Category of the objects.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub category: Option<String>,
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub objects: Option<Names>,
    /// The property, such as `color`.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub property: Option<String>,
    /// The value of the property in words.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub value: Option<String>,
    /// The relation, such as `left_of`.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub relation: Option<String>,
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub targets: Option<Names>,
    /// Index of the arrangement, or of the predicate of the goal.
    #[schemars(skip_serializing_if = "Option::is_none", range(min = 0, max = 10_000))]
    pub index: Option<u32>,
    /// Categories that are absent.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub categories: Option<Vec<String>>,
    /// The theme that supplies fillings.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub theme: Option<String>,
    /// Whether the theme completes the scene.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub complete: Option<bool>,
    /// The word that a misspelled one is read as.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub corrected: Option<String>,
}

/// Meaning of a part of the text.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum MeaningKind {
    Object,
    Property,
    Relation,
    Arrangement,
    Exclusion,
    Goal,
    Table,
    Theme,
    Completion,
    Correction,
}

/// A demand of the text that the layout does not meet, and its objects.
#[derive(JsonSchema)]
pub struct Unmet {
    pub objects: Names,
    pub kind: DemandKind,
    /// The relation, such as `left_of`; without targets, to the table.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub relation: Option<String>,
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub targets: Option<Names>,
    /// The stated distance.
    #[schemars(skip_serializing_if = "Option::is_none", range(min = 0.0, max = 1000.0))]
    pub distance_m: Option<f64>,
    /// Index of the arrangement.
    #[schemars(skip_serializing_if = "Option::is_none", range(min = 0, max = 10_000))]
    pub index: Option<u32>,
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub arrangement: Option<ArrangementKind>,
    /// Columns of a grid.
    #[schemars(skip_serializing_if = "Option::is_none", range(min = 1, max = 10_000))]
    pub columns: Option<u32>,
    /// The stated rotation about the vertical axis, counter-clockwise from above.
    #[schemars(skip_serializing_if = "Option::is_none", range(min = -1000.0, max = 1000.0))]
    pub yaw_rad: Option<f64>,
    /// The stated position from the center of the table top, to the right.
    #[schemars(skip_serializing_if = "Option::is_none", range(min = -1000.0, max = 1000.0))]
    pub x_m: Option<f64>,
    /// The stated position from the center of the table top, to the back.
    #[schemars(skip_serializing_if = "Option::is_none", range(min = -1000.0, max = 1000.0))]
    pub y_m: Option<f64>,
}

/// Kind of a demand.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum DemandKind {
    Relation,
    Arrangement,
    Yaw,
    Position,
}

/// Form of an arrangement.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum ArrangementKind {
    Row,
    Column,
    Circle,
    Grid,
    Pile,
    Pyramid,
}
