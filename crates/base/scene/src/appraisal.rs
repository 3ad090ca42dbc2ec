//! Optional answers of a vision-language model about a finished scene: ratings by the paper's criteria, and proposed
//! robot tasks.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::InstanceId;

/// Lowest and highest score of a rating.
pub const SCORES: [u8; 2] = [1, 7];

/// Rating criterion (the paper's Sec. Experiments). [`Self::OF_IMAGE`] lists the criteria of scenes made from an image,
/// [`Self::OF_TEXT`] those of scenes made from text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Criterion {
    /// VF: visual quality and realism.
    VisualFidelity,
    /// IA: agreement with the image in style, counts, kinds and layout.
    ImageAlignment,
    /// CwT: agreement with the text.
    ConsistencyWithText,
    /// OQR: quality and recognizability of the objects.
    ObjectQuality,
    /// LCR: functional plausibility of the arrangement.
    LayoutCoherence,
    /// PP: no object floats, penetrates another or would fall.
    PhysicalPlausibility,
}

impl Criterion {
    pub const OF_IMAGE: [Self; 3] = [Self::VisualFidelity, Self::ImageAlignment, Self::PhysicalPlausibility];
    pub const OF_TEXT: [Self; 4] =
        [Self::ConsistencyWithText, Self::ObjectQuality, Self::LayoutCoherence, Self::PhysicalPlausibility];

    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::VisualFidelity => "visual_fidelity",
            Self::ImageAlignment => "image_alignment",
            Self::ConsistencyWithText => "consistency_with_text",
            Self::ObjectQuality => "object_quality",
            Self::LayoutCoherence => "layout_coherence",
            Self::PhysicalPlausibility => "physical_plausibility",
        }
    }
}

/// Score of one criterion.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Rating {
    pub criterion: Criterion,
    /// 1 (very poor) to 7 (excellent).
    #[schemars(range(min = SCORES[0], max = SCORES[1]))]
    pub score: u8,
    /// The reason in one sentence.
    pub why: String,
}

/// A proposed robot task in a scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "SuggestedTask")]
pub struct ProposedTask {
    /// The instruction in natural language.
    pub instruction: String,
    pub kind: TaskKind,
    /// Names of the involved objects of the scene; moved objects come first.
    #[schemars(length(min = 1))]
    pub objects: Vec<InstanceId>,
}

/// The task kinds of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TaskKind {
    PickAndPlace,
    Swap,
    Stack,
    MultiStep,
}

impl TaskKind {
    /// The names in files.
    pub const NAMES: [&str; 4] = ["pick_and_place", "swap", "stack", "multi_step"];
}

/// An answer of a model with its source.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModelResponse<T> {
    /// Name of the adapter.
    pub by: String,
    pub model: String,
    /// Name and version of the prompt.
    pub prompt: String,
    /// The answer.
    pub said: T,
}

/// All model answers about a finished scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(
    description = "Ratings of the scene by a model; absent where none was asked. The verdict does not depend on it."
)]
pub struct Appraisal {
    /// In the order of the criteria; absent if ratings were not requested or not returned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ratings: Option<ModelResponse<Vec<Rating>>>,
    /// Easiest first; absent if tasks were not requested or not returned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tasks: Option<ModelResponse<Vec<ProposedTask>>>,
    /// Requested answers that are missing, with the reason. There is no substitute for them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<String>,
}
