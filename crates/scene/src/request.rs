//! What a client asks for.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{MicroUsd, TableSpec};

/// Largest seed: it must survive JavaScript numbers and signed SQL integers.
pub const MAX_SEED: u64 = (1 << 53) - 1;

/// Largest budget of a scene, US dollars.
pub const MAX_BUDGET_USD: f64 = 10_000.0;

/// A request as it is stored with the scene: its version, its input, its seed and its options.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneRequest {
    /// Raised when the meaning of a stored request changes.
    pub version: u32,
    pub input: Input,
    /// 0..=[`MAX_SEED`].
    pub seed: u64,
    pub options: RequestOptions,
}

impl SceneRequest {
    pub const VERSION: u32 = 1;

    /// Without what decides nothing about the scene: the budget.
    pub fn shaping(self) -> Self {
        Self { options: RequestOptions { budget_usd: None, ..self.options }, ..self }
    }
}

impl RequestOptions {
    /// What calls of remote models may cost together: the request's own budget, or the server's usual one.
    pub fn budget(&self, usual_usd: f64) -> MicroUsd {
        MicroUsd::of_usd(self.budget_usd.unwrap_or(usual_usd))
    }
}

/// Where the scene comes from. Edits and variants of existing scenes will be further kinds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Input {
    Text {
        text: String,
    },
    /// The picture's bytes lie in the object store under their content digest.
    Image {
        sha256: String,
        media_type: String,
    },
}

/// Everything a client may tune per scene; absent means the server's configuration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RequestOptions {
    /// Overrides what the analyst would choose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<TableSpec>,
    /// A known length in the scene, which overrides the anchor object.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metric_anchor: Option<MetricAnchor>,
    /// Refuse descriptions with more objects than this (1..=64).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_objects: Option<u32>,
    /// The most that calls of remote models may cost together, US dollars (0..=[`MAX_BUDGET_USD`]).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub budget_usd: Option<f64>,
    /// `key = value` overrides of the resolved settings, validated against the configuration.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub set: BTreeMap<String, String>,
}

/// "The mug is 9 cm wide": a length along the named object's (or the table's) width.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MetricAnchor {
    /// An instance label, or `table`.
    pub object: String,
    /// Its width (x extent as it stands in the picture), meters.
    pub width_m: f64,
}
