//! Recipes and lines of batches, and their results: types of the crate `batches`.

use std::collections::BTreeMap;

use schemars::JsonSchema;

use super::scene_request::Labels;
use super::values::{Id, Link, MAX_INTEGER, OptionalSeed, SceneText};
use super::words::RequestState;
use ::batches::output::OutputError;
use scene::request::RequestOptions;

/// Templates with slots in braces, times the values of the slots, times seeds, times options. Seeds vary fastest, then
/// options, then slots from the last to the first, then templates.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct BatchRecipe {
    #[schemars(length(min = 1, max = 100_000), extend("uniqueItems" = true))]
    pub templates: Vec<SceneText>,
    /// Values of each slot; every slot that a template uses has at least one.
    #[schemars(default)]
    pub slots: BTreeMap<String, SlotValues>,
    /// One seed, derived from the text, when absent.
    pub seeds: Option<RecipeSeeds>,
    pub options: Option<RecipeOptions>,
    #[schemars(default)]
    pub labels: Labels,
    pub select: Option<RecipeSelection>,
}

/// Consecutive seeds.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct SeedRange {
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub first: u64,
    #[schemars(range(min = 1, max = 1_000_000))]
    pub count: u64,
}

/// All combinations, as when absent.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct RecipeProduct {
    #[schemars(extend("const" = "product"))]
    pub mode: String,
}

/// So many different combinations, drawn with a seed.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct RecipeSample {
    #[schemars(extend("const" = "sample"))]
    pub mode: String,
    #[schemars(range(min = 1, max = 1_000_000))]
    pub count: u64,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub seed: u64,
}

/// A line of the body of a batch.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct BatchRequestLine {
    /// Unique in its batch.
    #[schemars(length(min = 1, max = 64), regex(pattern = r"^[A-Za-z0-9][A-Za-z0-9_.-]*$"))]
    pub custom_id: String,
    pub body: BatchRequestBody,
}

/// A scene from a text. Without a seed it has one that depends on the rest alone.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct BatchRequestBody {
    pub text: SceneText,
    #[schemars(default)]
    pub seed: OptionalSeed,
    #[schemars(default)]
    pub labels: Labels,
    #[schemars(default)]
    pub options: RequestOptions,
}

/// A line of the output or of the errors of a batch.
#[derive(JsonSchema)]
pub struct BatchResult {
    /// Null for a line whose name cannot be read.
    pub custom_id: Option<String>,
    pub scene_id: Option<Id>,
    pub state: RequestState,
    /// `pass` or `quarantine`, once certified.
    pub verdict: Option<String>,
    pub bundle: Option<Link>,
    pub error: Option<OutputError>,
    /// Duration of all computed stages together.
    #[schemars(range(min = 0.0, max = 9_000_000_000.0))]
    pub stages_s: f64,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub attempts: u64,
    /// The request that asks for the same scene.
    #[schemars(skip_serializing_if = "Option::is_none")]
    pub duplicate_of: Option<String>,
}

/// Values of a slot.
#[derive(JsonSchema)]
#[schemars(inline)]
pub struct SlotValues(
    #[schemars(length(min = 1, max = 100_000), extend("uniqueItems" = true))] pub Vec<String>,
);

/// Consecutive seeds, or a list.
#[derive(JsonSchema)]
#[schemars(inline, untagged)]
pub enum RecipeSeeds {
    Range(SeedRange),
    List(
        #[schemars(length(min = 1), inner(range(min = 0, max = MAX_INTEGER)), extend("uniqueItems" = true))]
        Vec<u64>,
    ),
}

/// Options of each scene, or a list of options.
#[derive(JsonSchema)]
#[schemars(inline, untagged)]
pub enum RecipeOptions {
    One(Box<RequestOptions>),
    List(#[schemars(length(min = 1), extend("uniqueItems" = true))] Vec<RequestOptions>),
}

/// All combinations, or some of them.
#[derive(JsonSchema)]
#[schemars(inline, untagged)]
pub enum RecipeSelection {
    Product(RecipeProduct),
    Sample(RecipeSample),
}
