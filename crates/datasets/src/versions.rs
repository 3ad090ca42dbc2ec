//! Versions of a dataset: folders `vNUMBER` of which the complete ones hold `dataset.json`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::dataset_manifest::{self, Changes, DatasetManifest};
use crate::error::DatasetError;
use crate::progress::PlannedScene;

/// The scenes that the new version adds and those that it no longer has.
pub fn changes(before: &DatasetManifest, planned: &[PlannedScene]) -> Changes {
    let old: BTreeSet<&str> = before.scenes.iter().map(|scene| scene.id.as_str()).collect();
    let new: BTreeSet<&str> = planned.iter().map(|scene| scene.id.as_str()).collect();
    let owned = |ids: Vec<&&str>| ids.into_iter().map(|id| (*id).to_owned()).collect();
    Changes {
        since_version: before.version,
        since_digest: before.digest.clone(),
        added: owned(new.difference(&old).collect()),
        removed: owned(old.difference(&new).collect()),
    }
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
