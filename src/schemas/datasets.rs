//! Conditions of a freeze, and what is said of a version: types of the crate `datasets`.

use std::collections::BTreeMap;

use schemars::JsonSchema;

use super::values::MAX_INTEGER;

/// Conditions; a scene must meet all. Those that are absent hold, but that the verdict must be `pass`.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct DatasetFilter {
    #[schemars(default)]
    pub verdict: VerdictCondition,
    #[schemars(range(min = 0, max = 1_000_000))]
    pub min_objects: Option<u64>,
    #[schemars(range(min = 0, max = 1_000_000))]
    pub max_objects: Option<u64>,
    #[schemars(default)]
    pub required_categories: Vec<String>,
    #[schemars(default)]
    pub excluded_categories: Vec<String>,
    #[schemars(default)]
    pub labels: BTreeMap<String, String>,
}

/// Condition on the verdict of a scene.
#[derive(Default, JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum VerdictCondition {
    #[default]
    Pass,
    Quarantine,
    Any,
}

/// Part that two scenes may share.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum SharingKind {
    Lineage,
    Text,
    Image,
    Mesh,
}

/// A document whose members are those of the manifest; docs/datasets.md describes them.
#[derive(JsonSchema)]
#[schemars(extend("additionalProperties" = {}))]
pub struct OpenDocument(pub BTreeMap<String, ()>);

/// From the manifest of the version.
#[derive(JsonSchema)]
pub struct DatasetSummary {
    pub counts: OpenDocument,
    pub selection: OpenDocument,
    pub changes: Option<OpenDocument>,
    /// The version existed already.
    pub unchanged: bool,
}

/// Findings of the last verification.
#[derive(JsonSchema)]
pub struct VerificationResult {
    pub intact: bool,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub scenes: u64,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub bytes: u64,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub fault_count: u64,
    /// The first hundred.
    pub faults: Vec<DatasetFault>,
}

/// A fault of a file of a dataset.
#[derive(JsonSchema)]
pub struct DatasetFault {
    pub path: String,
    pub reason: String,
}

/// State of a verification.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum VerificationState {
    Queued,
    Running,
    Finished,
}

/// Ratios of splits by name.
#[derive(JsonSchema)]
#[schemars(inline, extend("propertyNames" = { "pattern": "^[a-z0-9_]{1,32}$" }))]
pub struct SplitRatios(pub BTreeMap<String, SplitRatio>);

/// Ratio of a split.
#[derive(JsonSchema)]
#[schemars(inline)]
pub struct SplitRatio(#[schemars(range(min = 0.0, max = 1.0))] pub f64);
