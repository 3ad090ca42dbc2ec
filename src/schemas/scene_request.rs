//! Labels, and the source of a scene as one object.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::edits::EditOperations;
use super::values::Sha256;
use scene::Randomize;
use store::scenes::SceneKind;

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

/// The source of a scene; each kind has the fields that name it.
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
    /// Of an image with a depth image beside it: the digest of that.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub depth_sha256: Option<Sha256>,
    /// Of an edit or a variant: the id in the `scene.json` of the parent.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// Of an edit or a variant: the archive of the parent.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub bundle_sha256: Option<Sha256>,
    /// Of an edit.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub operations: Option<EditOperations>,
    /// Of an edit in words: the words that each operation comes from, in order.
    #[schemars(skip_serializing_if = "Option::is_none", length(max = 64))]
    pub words: Option<Vec<String>>,
    /// Of an edit in words: those that ask for nothing.
    #[schemars(skip_serializing_if = "Option::is_none", length(max = 4000))]
    pub asides: Option<Vec<String>>,
    /// Of a variant.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub randomize: Option<Randomize>,
}

/// The source of the scene.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum InputKind {
    Text,
    Image,
    Edit,
    Variant,
}

impl InputKind {
    /// As the store filters by it.
    pub fn of_store(self) -> SceneKind {
        match self {
            Self::Text => SceneKind::Text,
            Self::Image => SceneKind::Image,
            Self::Edit => SceneKind::Edit,
            Self::Variant => SceneKind::Variant,
        }
    }
}
