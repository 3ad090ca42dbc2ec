//! `dataset.json`: what a version of a dataset holds, with digests of every byte.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::canonical;
use crate::error::DatasetError;
use crate::filter::Filter;
use crate::members::Members;
use crate::selection::Selection;
use crate::sharing::{LeakageRules, Shareable};
use crate::splits::SplitPlan;

/// Path of the manifest in a version's folder.
pub const PATH: &str = "dataset.json";

/// The format's name and version.
pub const FORMAT: &str = "tabletopgen-dataset/1";

/// The content of `dataset.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DatasetManifest {
    pub format: String,
    pub name: String,
    pub version: u32,
    pub generator: Generator,
    /// SHA-256 of the canonical form of this document without this member.
    #[serde(default)]
    pub digest: String,
    /// SHA-256 of what was asked for: scenes, splits, filter, layout. Equal inputs are one version.
    pub inputs_digest: String,
    pub counts: Counts,
    /// Scenes that there were, and reasons why some are not in the dataset.
    pub selection: Selection,
    pub filter: Filter,
    pub splits: Splits,
    pub layout: Layout,
    /// Against the version before; absent for the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub changes: Option<Changes>,
    /// Licenses, statistics and tar shards, sorted by path. Scenes that are files of their own are in `scenes`.
    pub files: Vec<FileEntry>,
    /// Sorted by split, in the order of the plan, then by id.
    pub scenes: Vec<SceneEntry>,
}

/// The program that froze the dataset.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Generator {
    pub name: String,
    pub version: String,
}

/// Sizes of the dataset.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    pub scenes: usize,
    pub objects: usize,
    pub groups: usize,
    /// Scenes of the largest group: no split differs from its ratio by so many.
    pub largest_group: usize,
    /// Scenes per split.
    pub splits: BTreeMap<String, usize>,
}

/// Division of the scenes into splits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Splits {
    pub plan: SplitPlan,
    pub method: String,
    /// Kinds of sharing that count as leakage.
    pub leakage_rules: LeakageRules,
    /// Plan and rules in sentences.
    pub statement: Vec<String>,
}

/// Storage of the scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Layout {
    /// `scenes/<key>.zip`, one bundle archive per scene.
    Scenes,
    /// `shards/<split>-<number>.tar`. A scene that is larger than the bound has a shard of its own.
    Shards {
        max_bytes: u64,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        max_scenes: Option<usize>,
    },
}

/// Difference between two versions, by ids of scenes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Changes {
    pub since_version: u32,
    pub since_digest: String,
    pub added: Vec<String>,
    pub removed: Vec<String>,
    /// Scenes that are in another split than in the version before.
    pub moved: Vec<String>,
}

/// A file of the dataset.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileEntry {
    pub path: String,
    pub size: u64,
    pub sha256: String,
}

/// A scene of the dataset.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneEntry {
    pub id: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub custom_id: Option<String>,
    pub split: String,
    /// The split in the version before, if that had the same plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub earlier_split: Option<String>,
    /// Scenes of one group share something that counts as leakage, directly or through others.
    pub group: String,
    /// The shard or the archive that holds the scene.
    pub path: String,
    /// Of the bundle's archive, bytes.
    pub size: u64,
    /// Of the bundle's archive.
    pub sha256: String,
    /// Of the bundle's `manifest.json`.
    pub manifest_sha256: String,
    pub verdict: String,
    pub objects: usize,
    /// Number of objects per category.
    pub categories: BTreeMap<String, u32>,
    #[serde(flatten)]
    pub shares: Shareable,
    /// Files of the scene in its shard, by the part of their name behind the key; empty without shards.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub members: Members,
}

impl DatasetManifest {
    /// The digest of the canonical form, without the member `digest`.
    ///
    /// # Errors
    ///
    /// [`DatasetError::Dataset`] if the value has no JSON form.
    pub fn computed_digest(&self) -> Result<String, DatasetError> {
        let json = serde_json::to_value(self)
            .map_err(|error| DatasetError::dataset(Path::new(PATH), error.to_string()))?;
        Ok(digest_of(json))
    }

    /// Reads the manifest in a version's folder, and the digest of the file as it stands.
    ///
    /// # Errors
    ///
    /// [`DatasetError`] if the file is missing or of another format.
    pub fn read(folder: &Path) -> Result<(Self, String), DatasetError> {
        let path = folder.join(PATH);
        let bytes = std::fs::read(&path).map_err(DatasetError::file("read", &path))?;
        let refuse = |error: serde_json::Error| DatasetError::dataset(&path, error.to_string());
        let json: Value = serde_json::from_slice(&bytes).map_err(refuse)?;
        if json.get("format").and_then(Value::as_str) != Some(FORMAT) {
            return Err(DatasetError::dataset(&path, format!("its format is not {FORMAT}")));
        }
        let digest = digest_of(json);
        let mut manifest: Self = serde_json::from_slice(&bytes).map_err(refuse)?;
        for scene in &mut manifest.scenes {
            scene.shares.id.clone_from(&scene.id);
        }
        let paths = manifest.files.iter().map(|file| &file.path);
        let mut paths = paths.chain(manifest.scenes.iter().map(|scene| &scene.path));
        match paths.find(|path| !crate::bundle::is_inside(path)) {
            Some(outside) => {
                Err(DatasetError::dataset(&path, format!("it lists {outside:?}, outside its folder")))
            }
            None => Ok((manifest, digest)),
        }
    }
}

fn digest_of(mut json: Value) -> String {
    if let Some(members) = json.as_object_mut() {
        members.remove("digest");
    }
    crate::bundle::sha256(canonical::text(&json).as_bytes())
}
