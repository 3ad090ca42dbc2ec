//! The account of an input text: the parts that were understood, with their meaning, and the parts that were not.

mod sentences;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::InstanceId;
use super::description::RelationKind;
use super::name::Names;
use super::predicates::Unmet;

/// A part of the input text.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[schemars(description = "A part of the text; byte offsets and its words.")]
pub struct TextSpan {
    /// Byte offset of the first byte in the text.
    #[schemars(range(min = 0, max = 16_000))]
    pub start: usize,
    /// Byte offset after the last byte in the text.
    #[schemars(range(min = 0, max = 16_000))]
    pub end: usize,
    /// The words as the text has them.
    pub text: String,
}

/// The account of a text as scenes and the API show it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(
    description = "Parts of a text that were understood, and parts that were not. Every word is part of it, but for a closed list of ignorable ones."
)]
pub struct TextAccount {
    /// Parts of the text with a meaning, in the order of the text.
    pub understood: Vec<Understood>,
    /// Parts of the text without effect, in the order of the text.
    pub unrecognized: Vec<Unrecognized>,
    /// The goal of an instruction; the scene shows its start state.
    pub goal: Option<Goal>,
    /// Objects that the catalog does not have: those that have the mark of a stand-in.
    #[schemars(with = "Names")]
    pub stand_ins: Vec<InstanceId>,
    /// Objects that the text does not name; the theme added them.
    #[schemars(with = "Names")]
    pub fillings: Vec<InstanceId>,
    /// Demands of the text that the layout does not meet; empty before a layout exists, and where it is not known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unmet: Vec<Unmet>,
    /// Id of the scene that was made from the text, in its `scene.json`, where this scene is an edit of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of_scene: Option<String>,
    /// Parts of the text of which edits changed some or all, in the order of the text. `understood` has only what is
    /// left of their meaning.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changed: Vec<ChangedPart>,
}

/// A part of the text that an edit changed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ChangedPart {
    pub span: TextSpan,
    /// Change made by the operation, in one sentence.
    pub by: String,
}

/// A part of the text and its meaning.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Understood {
    pub span: TextSpan,
    #[serde(flatten)]
    pub meaning: TextMeaning,
}

/// The meaning of a part of the text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum TextMeaning {
    /// Objects of a category.
    Object { category: String, objects: Vec<InstanceId> },
    /// A property of objects, such as `color`, `material`, `size`, `state`, `mass`, and its value in words.
    Property { property: String, value: String, objects: Vec<InstanceId> },
    /// A spatial relation; without targets, to the table.
    Relation { relation: RelationKind, objects: Vec<InstanceId>, targets: Vec<InstanceId> },
    /// Objects of an arrangement of the description, by its index.
    Arrangement { index: usize, objects: Vec<InstanceId> },
    /// Categories that must be absent, also from fillings.
    Exclusion { categories: Vec<String> },
    /// A predicate of the goal, by its index.
    Goal { index: usize },
    /// The table, its shape, size or material.
    Table,
    /// The theme that supplies fillings.
    Theme { theme: String },
    /// Whether the scene is completed by its theme.
    Completion { complete: bool },
    /// A misspelled word and the word it is read as.
    Correction { corrected: String },
}

/// A part of the text that has no effect, and the reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Unrecognized {
    pub span: TextSpan,
    pub reason: UnrecognizedReason,
    /// The known word that is spelled most similarly.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nearest_by_spelling: Option<String>,
    /// The known object that is nearest in meaning.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nearest_by_meaning: Option<String>,
}

/// The reason why a part of the text has no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum UnrecognizedReason {
    /// A noun of which neither the catalog nor the lexicon of stand-ins has an object.
    UnknownObject,
    /// A word that is not known.
    UnknownWord,
    /// A known noun that denotes nothing that stands on a table: a person, a place, a substance.
    NotPlaceable,
    /// A number outside the supported range.
    OutOfRange,
    /// A property, state or relation that the objects cannot have.
    NotSupported,
    /// Contradiction of an earlier part of the text.
    Contradiction,
    /// A reference to an object that the text does not have.
    NoReferent,
    /// The text says more about it than the parser can express.
    NotExpressible,
    /// An object that the image beside the text does not show, as far as it is recognized.
    NotInImage,
    /// The image beside the text decides it: the table, places, arrangements.
    ShownByImage,
}

/// The goal of a task instruction. The scene shows the start state, which does not satisfy it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(description = "The goal of an instruction; the scene shows its start state.")]
pub struct Goal {
    /// The instruction as the text has it.
    pub instruction: String,
    /// All of them must hold at the end.
    pub predicates: Vec<GoalPredicate>,
}

/// A condition on the end state.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct GoalPredicate {
    pub predicate: PredicateKind,
    pub object: InstanceId,
    /// The second object of a relation; absent for properties and for relations to the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<InstanceId>,
    /// The third object of `between`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_target: Option<InstanceId>,
}

/// Kinds of conditions. Directions are as seen from the front edge of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PredicateKind {
    In,
    /// The object is not in the target.
    OutOf,
    On,
    /// The object is not on the target.
    Off,
    StackedOn,
    LeftOf,
    RightOf,
    InFrontOf,
    Behind,
    NextTo,
    Between,
    /// The object is farther from the target than at the start.
    AwayFrom,
    AtCenter,
    AtBack,
    AtFront,
    AtLeft,
    AtRight,
    AtBackLeft,
    AtBackRight,
    AtFrontLeft,
    AtFrontRight,
    /// The two objects have exchanged their positions.
    Swapped,
    Lifted,
    Opened,
    Closed,
    Upright,
    LyingOnSide,
    UpsideDown,
    /// The object is rotated about its vertical axis.
    Rotated,
    /// The object has moved along the table while it was in contact: pushed, pulled, slid.
    Moved,
    /// The content of the object is in the target.
    PouredInto,
    /// The object touches the target, which moves along the surface of the target: wiped, swept, cut.
    UsedOn,
    /// The button, switch or lever of the object is pressed.
    Pressed,
}

impl PredicateKind {
    pub const ALL: [Self; 33] = [
        Self::In,
        Self::OutOf,
        Self::On,
        Self::Off,
        Self::StackedOn,
        Self::LeftOf,
        Self::RightOf,
        Self::InFrontOf,
        Self::Behind,
        Self::NextTo,
        Self::Between,
        Self::AwayFrom,
        Self::AtCenter,
        Self::AtBack,
        Self::AtFront,
        Self::AtLeft,
        Self::AtRight,
        Self::AtBackLeft,
        Self::AtBackRight,
        Self::AtFrontLeft,
        Self::AtFrontRight,
        Self::Swapped,
        Self::Lifted,
        Self::Opened,
        Self::Closed,
        Self::Upright,
        Self::LyingOnSide,
        Self::UpsideDown,
        Self::Rotated,
        Self::Moved,
        Self::PouredInto,
        Self::UsedOn,
        Self::Pressed,
    ];
}
