//! Request of a dataset, as it is stored.

use serde::{Deserialize, Serialize};

use datasets::filter::Filter;
use datasets::sharing::LeakageRules;
use datasets::splits::SplitPlan;
use scene::{BatchId, SceneId};

/// The stored request of a dataset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DatasetRequest {
    /// Form of the document, [`Self::VERSION`].
    pub version: u32,
    pub source: DatasetSource,
    pub filter: Filter,
    pub splits: SplitPlan,
    /// Parts that scenes of different splits must not share.
    pub disjoint: LeakageRules,
    /// Largest shard, bytes.
    pub shard_bytes: u64,
    /// Largest number of scenes in a shard.
    pub shard_scenes: Option<usize>,
}

impl DatasetRequest {
    pub const VERSION: u32 = 1;
}

/// Scenes that are read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DatasetSource {
    /// Scenes of a batch.
    Batch(BatchId),
    Scenes(Vec<SceneId>),
    /// Scenes with this label.
    Label {
        key: String,
        value: String,
    },
}
