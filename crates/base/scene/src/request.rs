//! Scene requests of clients.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::clutter::Clutter;
use super::{MicroUsd, Randomize, TableSpec};
use crate::edit::{self, EditOperation};
use crate::validation::{Violation, Violations, validated};

/// Largest seed that JavaScript numbers and signed SQL integers represent exactly.
pub const MAX_SEED: u64 = (1 << 53) - 1;

/// Largest budget of a scene, US dollars.
pub const MAX_BUDGET_USD: f64 = 10_000.0;

/// A request as stored with its scene. A deserialized value is valid: the version is at most [`Self::VERSION`], and the
/// seed and the options are in their ranges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Self")]
#[schemars(
    rename = "StoredRequest",
    description = "The request as it is kept, with the seed that was drawn."
)]
pub struct SceneRequest {
    /// Version of the stored format: the first one that has the kind of its input, and its options. A worker leaves
    /// jobs alone whose version is newer than it reads.
    #[schemars(range(min = 1, max = 1000), description = "Version of the stored format.")]
    pub version: u32,
    pub input: Input,
    /// Selects one of many possible results.
    #[schemars(range(min = 0, max = MAX_SEED))]
    pub seed: u64,
    pub options: RequestOptions,
}

validated!(SceneRequest);

impl SceneRequest {
    /// The newest version that this program reads. Raised when a stored request has something new.
    pub const VERSION: u32 = 6;

    /// A request in the oldest version that has its input and its options.
    pub fn new(input: Input, seed: u64, options: RequestOptions) -> Self {
        Self { version: input.version().max(options.version()), input, seed, options }
    }

    /// Every violation of the guarantees.
    fn violations(&self) -> Vec<Violation> {
        let mut violations = Violations::default();
        let version = (1..=Self::VERSION).contains(&self.version);
        violations.require(version, "/version", format!("must be from 1 to {}", Self::VERSION));
        violations.require(self.seed <= MAX_SEED, "/seed", format!("must be at most {MAX_SEED}"));
        violations.extend("/options", self.options.violations());
        if let Input::Edit { operations, words, .. } = &self.input {
            violations.extend("/input/operations", edit::violations(operations));
            let is_complete = words.is_empty() || words.len() == operations.len();
            violations.require(is_complete, "/input/words", "must have one entry for each operation");
        }
        if let Input::Variant { randomize, .. } = &self.input {
            violations.extend("/input/randomize", randomize.violations());
        }
        violations.into_vec()
    }

    /// The request without its budget, which does not influence the scene.
    pub fn without_budget(self) -> Self {
        Self { options: RequestOptions { budget_usd: None, ..self.options }, ..self }
    }
}

impl RequestOptions {
    /// Every option that is out of its range, with a JSON pointer relative to the options.
    pub fn violations(&self) -> Vec<Violation> {
        let mut violations = Violations::default();
        let count = self.max_objects.is_none_or(|count| (1..=64).contains(&count));
        violations.require(count, "/max_objects", "must be from 1 to 64");
        let budget = self.budget_usd.is_none_or(|budget| (0.0..=MAX_BUDGET_USD).contains(&budget));
        violations.require(budget, "/budget_usd", format!("must be from 0 to {MAX_BUDGET_USD} US dollars"));
        if let Some(anchor) = &self.metric_anchor {
            let width = (0.001..=10.0).contains(&anchor.width_m);
            violations.require(width, "/metric_anchor/width_m", "must be from 0.001 to 10 meters");
            let object = (1..=100).contains(&anchor.object.chars().count());
            violations.require(object, "/metric_anchor/object", "must have 1 to 100 characters");
        }
        if let Some(table) = &self.table {
            if let Some(size) = table.size_m {
                for (axis, extent, low, high) in
                    [("0", size.x, 0.2, 5.0), ("1", size.y, 0.2, 5.0), ("2", size.z, 0.1, 2.0)]
                {
                    let pointer = format!("/table/size_m/{axis}");
                    let detail = format!("must be from {low} to {high} meters");
                    violations.require((low..=high).contains(&extent), pointer, detail);
                }
            }
            for (name, word) in
                [("model", &table.model), ("material", &table.material), ("color", &table.color)]
            {
                let length = word.as_ref().is_none_or(|word| (1..=63).contains(&word.chars().count()));
                violations.require(length, format!("/table/{name}"), "must have 1 to 63 characters");
            }
        }
        let robot = self.robot.as_ref().is_none_or(|name| (1..=63).contains(&name.chars().count()));
        violations.require(robot, "/robot", "must have 1 to 63 characters");
        let density = self.clutter.is_none_or(|clutter| (0.0..=1.0).contains(&clutter.density));
        violations.require(density, "/clutter/density", "must be from 0 to 1");
        violations.require(self.set.len() <= 64, "/set", "has more than 64 entries");
        for (key, value) in self.set.iter().take(65) {
            let short = key.len() <= 100 && value.len() <= 1000;
            violations.require(short, "/set", "keys have at most 100 bytes and values at most 1000");
        }
        violations.into_vec()
    }

    /// The first version of the stored format that has these options.
    fn version(&self) -> u32 {
        match (&self.clutter, &self.robot) {
            (Some(_), _) => 4,
            (None, Some(_)) => 3,
            (None, None) => 1,
        }
    }

    /// Maximum total cost of remote calls: the request's budget, else the server's default in US dollars.
    pub fn budget(&self, default_usd: f64) -> MicroUsd {
        MicroUsd::of_usd(self.budget_usd.unwrap_or(default_usd))
    }
}

/// Source of the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[schemars(description = "The source of a scene.")]
pub enum Input {
    Text {
        text: String,
    },
    /// The image's bytes are in the object store under their content digest.
    Image {
        #[schemars(regex(pattern = "^[0-9a-f]{64}$"))]
        sha256: String,
        media_type: String,
        /// Description of the content, beside the image. The image decides where objects are.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        text: Option<String>,
        /// Digest of the depth image beside the image, which is in the object store too.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(regex(pattern = "^[0-9a-f]{64}$"))]
        depth_sha256: Option<String>,
    },
    /// A finished scene with operations on it.
    Edit {
        /// Id of the parent in its `scene.json`.
        #[schemars(length(min = 1))]
        parent: String,
        /// Digest of the parent's bundle archive in the object store.
        #[schemars(regex(pattern = "^[0-9a-f]{64}$"))]
        bundle_sha256: String,
        #[schemars(length(min = 1, max = 64))]
        operations: Vec<EditOperation>,
        /// The instruction that the operations were read from.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        text: Option<String>,
        /// The words of the instruction that each operation comes from, in order.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        #[schemars(length(max = 64))]
        words: Vec<String>,
        /// Words of the instruction that ask for nothing.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        #[schemars(length(max = 4000))]
        asides: Vec<String>,
    },
    /// A finished scene with operations on it that the seed draws.
    Variant {
        /// Id of the parent in its `scene.json`.
        #[schemars(length(min = 1))]
        parent: String,
        /// Digest of the parent's bundle archive in the object store.
        #[schemars(regex(pattern = "^[0-9a-f]{64}$"))]
        bundle_sha256: String,
        randomize: Randomize,
    },
}

impl Input {
    /// The first version of the stored format that has this kind of input.
    fn version(&self) -> u32 {
        match self {
            Self::Image { depth_sha256: Some(_), .. } => 5,
            Self::Text { .. } | Self::Image { .. } => 1,
            Self::Edit { words, .. } if !words.is_empty() => 6,
            Self::Edit { .. } | Self::Variant { .. } => 2,
        }
    }

    /// The text that describes objects, alone or beside an image.
    pub fn text(&self) -> Option<&str> {
        match self {
            Self::Text { text } => Some(text),
            Self::Image { text, .. } => text.as_deref(),
            Self::Edit { .. } | Self::Variant { .. } => None,
        }
    }

    /// The input of the reference image: the text beside an image does not change it.
    pub fn of_reference(&self) -> Self {
        match self.clone() {
            Self::Image { sha256, media_type, text: _, depth_sha256 } => {
                Self::Image { sha256, media_type, text: None, depth_sha256 }
            }
            text => text,
        }
    }
}

/// Options per scene; absent values come from the server's configuration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "Options", description = "Options of each scene.")]
pub struct RequestOptions {
    /// Overrides the choice of the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<TableSpec>,
    /// A known length in the scene, which sets its scale.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metric_anchor: Option<MetricAnchor>,
    /// More objects are refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 64))]
    pub max_objects: Option<u32>,
    /// The most that calls of remote models may cost together; the server's usual budget when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_BUDGET_USD))]
    pub budget_usd: Option<f64>,
    /// Treatment of objects of the text that the catalog does not have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_unknown: Option<OnUnknown>,
    /// A robot that is tried in the finished scene, such as `panda`: its grasps of each object, what it can pick up,
    /// and tasks. Takes seconds for each object.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = 63))]
    pub robot: Option<String>,
    /// Objects without a stated place are dropped onto each other, so that they lean, overlap and lie at random.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clutter: Option<Clutter>,
    /// Values of settings by name, in place of the server's.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(with = "SceneSettings")]
    pub set: BTreeMap<String, String>,
}

/// Settings of a scene by name, as text.
#[derive(JsonSchema)]
pub struct SceneSettings(pub BTreeMap<String, String>);

/// Policy for the parts of a text that are not understood.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(description = "Treatment of parts of the text that are not understood; `stand_in` when absent.")]
pub enum OnUnknown {
    /// The request fails if any part is not understood.
    Fail,
    /// A plain shape stands in for an object that the catalog does not have; what has no stand-in is reported.
    #[default]
    StandIn,
    /// Unknown objects are reported and left out.
    Drop,
}

/// "The mug is 9 cm wide": a length along the named object's (or the table's) width.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(description = "A known width in the scene.")]
pub struct MetricAnchor {
    /// A label of an object, or `table`.
    #[schemars(length(min = 1, max = 100))]
    pub object: String,
    /// Width of the object (x extent as placed in the image), meters.
    #[schemars(range(min = 0.001, max = 10.0))]
    pub width_m: f64,
}
