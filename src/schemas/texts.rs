//! Parts of a text that were understood, and parts that were not: types of the crate `scene`.

use schemars::JsonSchema;

use super::values::Names;

/// Parts of a text that were understood, and parts that were not. Every word is part of it, but for a closed list of
/// ignorable ones.
#[derive(JsonSchema)]
pub struct TextAccount {
    pub understood: Vec<Understood>,
    pub unrecognized: Vec<Unrecognized>,
    pub goal: Option<Goal>,
    /// Objects outside the catalog; what stands there has the mark of a stand-in.
    pub stand_ins: Vec<String>,
    /// Objects that the text does not name; the theme added them.
    pub fillings: Vec<String>,
    /// Demands of the text that yielded in the layout. Absent where there is none, and before there is a layout.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub unmet: Option<Vec<Unmet>>,
    /// Of an edited scene, the id of the scene that was made from the text, as in its `scene.json`.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub of_scene: Option<String>,
    /// Parts of the text that edits changed. `understood` has only what is left of their meaning.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub changed: Option<Vec<ChangedPart>>,
}

/// A part of the text; byte offsets and its words.
#[derive(JsonSchema)]
pub struct TextSpan {
    #[schemars(range(min = 0, max = 16_000))]
    pub start: u32,
    #[schemars(range(min = 0, max = 16_000))]
    pub end: u32,
    pub text: String,
}

/// A part of the text that an edit changed.
#[derive(JsonSchema)]
pub struct ChangedPart {
    pub span: TextSpan,
    /// Change made by the operation, such as `removed teapot_1`.
    pub by: String,
}

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

/// A part of the text without effect, and the reason.
#[derive(JsonSchema)]
pub struct Unrecognized {
    pub span: TextSpan,
    pub reason: UnrecognizedReason,
    /// The known word that is spelled most similarly.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub nearest_by_spelling: Option<String>,
    /// The known object that is nearest in meaning.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub nearest_by_meaning: Option<String>,
}

/// Reason why a part of the text has no effect.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum UnrecognizedReason {
    UnknownObject,
    UnknownWord,
    NotPlaceable,
    OutOfRange,
    NotSupported,
    Contradiction,
    NoReferent,
    NotExpressible,
    NotInImage,
    ShownByImage,
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

/// The goal of an instruction; the scene shows its start state.
#[derive(JsonSchema)]
pub struct Goal {
    pub instruction: String,
    pub predicates: Vec<GoalPredicate>,
}

/// A condition on the end state.
#[derive(JsonSchema)]
pub struct GoalPredicate {
    pub predicate: String,
    pub object: String,
    #[schemars(default, with = "String", skip_serializing_if = "Option::is_none")]
    pub target: Option<String>,
    #[schemars(default, with = "String", skip_serializing_if = "Option::is_none")]
    pub second_target: Option<String>,
}
