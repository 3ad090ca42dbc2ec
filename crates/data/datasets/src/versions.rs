//! Versions of a dataset: folders `vNUMBER` of which the complete ones hold `dataset.json`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::dataset_manifest::{self, Changes, DatasetManifest};
use crate::error::DatasetError;
use crate::progress::PlannedScene;
use crate::splits::SplitPlan;

/// The scenes that the new version adds, those that it no longer has, and those in another split.
pub fn changes(before: &DatasetManifest, planned: &[PlannedScene]) -> Changes {
    let splits = before.scenes.iter().map(|scene| (scene.id.as_str(), scene.split.as_str()));
    let splits: BTreeMap<&str, &str> = splits.collect();
    let ids: BTreeSet<&str> = planned.iter().map(|scene| scene.id.as_str()).collect();
    let is_moved =
        |scene: &&PlannedScene| splits.get(scene.id.as_str()).is_some_and(|split| *split != scene.split);
    let mut moved: Vec<String> = planned.iter().filter(is_moved).map(|scene| scene.id.clone()).collect();
    moved.sort();
    Changes {
        since_version: before.version,
        since_digest: before.digest.clone(),
        added: ids.iter().filter(|id| !splits.contains_key(*id)).map(|id| (*id).to_owned()).collect(),
        removed: splits.keys().filter(|id| !ids.contains(*id)).map(|id| (*id).to_owned()).collect(),
        moved,
    }
}

/// The splits of the version before, by scene; none if that had another plan.
pub fn earlier_splits(before: Option<&DatasetManifest>, plan: &SplitPlan) -> BTreeMap<String, String> {
    let scenes =
        before.filter(|before| before.splits.plan == *plan).into_iter().flat_map(|before| &before.scenes);
    scenes.map(|scene| (scene.id.clone(), scene.split.clone())).collect()
}

/// The complete version with the largest number, and its folder.
///
/// # Errors
///
/// [`DatasetError`] if the folder or the version's manifest cannot be read.
pub fn latest(home: &Path) -> Result<Option<(DatasetManifest, PathBuf)>, DatasetError> {
    if !home.is_dir() {
        return Ok(None);
    }
    let mut latest: Option<(u32, PathBuf)> = None;
    for entry in std::fs::read_dir(home).map_err(DatasetError::file("list", home))? {
        let folder = entry.map_err(DatasetError::file("list", home))?.path();
        let name = folder.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let number: Option<u32> = name.strip_prefix('v').and_then(|number| number.parse().ok());
        if let Some(number) = number
            && folder.join(dataset_manifest::PATH).is_file()
            && latest.as_ref().is_none_or(|(other, _)| *other < number)
        {
            latest = Some((number, folder));
        }
    }
    latest.map(|(_, folder)| Ok((DatasetManifest::read(&folder)?.0, folder))).transpose()
}
