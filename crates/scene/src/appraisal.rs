//! What a model thinks of a finished scene, where one was asked: ratings as the paper has them, and tasks for
//! a robot.

use serde::{Deserialize, Serialize};

use super::InstanceId;

/// Lowest and highest score.
pub const SCORES: [u8; 2] = [1, 7];

/// What a scene is rated by (the paper's Sec. Experiments): the first three for scenes made after a picture,
/// the last four for scenes made after a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Criterion {
    /// VF: how good and how real it looks.
    VisualFidelity,
    /// IA: as in the picture, in style, counts, kinds and layout.
    ImageAlignment,
    /// CwT: as the text says.
    ConsistencyWithText,
    /// OQR: how well made the things are, and whether one sees what they are.
    ObjectQuality,
    /// LCR: whether things lie as they do where people use them.
    LayoutCoherence,
    /// PP: nothing floats, sticks in another or would fall.
    PhysicalPlausibility,
}

impl Criterion {
    pub const OF_A_PICTURE: [Self; 3] =
        [Self::VisualFidelity, Self::ImageAlignment, Self::PhysicalPlausibility];
    pub const OF_A_TEXT: [Self; 4] =
        [Self::ConsistencyWithText, Self::ObjectQuality, Self::LayoutCoherence, Self::PhysicalPlausibility];

    /// The word in files.
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

/// One score.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rating {
    pub criterion: Criterion,
    /// 1 (very poor) to 7 (excellent).
    pub score: u8,
    /// Why, in a sentence.
    pub why: String,
}

/// Something for a robot to do in a scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProposedTask {
    /// What a person would say to the robot.
    pub instruction: String,
    pub kind: TaskKind,
    /// Names of the objects that it is about, all of the scene; those that are moved come first.
    pub objects: Vec<InstanceId>,
}

/// The paper's kinds of tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskKind {
    PickAndPlace,
    Swap,
    Stack,
    MultiStep,
}

impl TaskKind {
    /// The words in files.
    pub const NAMES: [&str; 4] = ["pick_and_place", "swap", "stack", "multi_step"];
}

/// What a model said, and which it was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Opinion<T> {
    /// The adapter that answered.
    pub by: String,
    pub model: String,
    /// Name and version of the prompt.
    pub prompt: String,
    pub said: T,
}

/// What was asked about a finished scene, and what came of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Appraisal {
    /// In the order of the criteria; absent where ratings were not asked for, or not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ratings: Option<Opinion<Vec<Rating>>>,
    /// Those that are easiest first; absent where tasks were not asked for, or not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tasks: Option<Opinion<Vec<ProposedTask>>>,
    /// What was asked for and not given, and why; nothing stands in its place.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<String>,
}
