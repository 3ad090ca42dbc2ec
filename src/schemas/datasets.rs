//! Words and documents of datasets that no type of the crate `datasets` is.

use std::collections::BTreeMap;

use schemars::JsonSchema;

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
