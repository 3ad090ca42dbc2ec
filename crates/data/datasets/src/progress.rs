//! Records of finished containers, by which an interrupted freeze goes on.
//!
//! A record beside the dataset (`.freeze/`) states what a shard holds and which scene no longer fitted. A shard is
//! kept if a fresh freeze would write the same: the scenes, the next scene, the bounds and the bytes are equal.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::dataset_manifest::{FileEntry, Layout};
use crate::error::DatasetError;
use crate::files;
use crate::members::Members;

/// Folder of records and unfinished files, inside the version's folder until the dataset is complete.
pub const FOLDER: &str = ".freeze";

/// A scene that is to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannedScene {
    pub id: String,
    pub manifest_sha256: String,
    pub split: String,
    /// Folder or archive of the bundle.
    pub place: PathBuf,
}

/// A scene that was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoredScene {
    pub id: String,
    pub manifest_sha256: String,
    /// Of the bundle's archive.
    pub size: u64,
    /// Of the bundle's archive.
    pub sha256: String,
    pub members: Members,
}

/// A finished container: a shard, or the archive of one scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ContainerRecord {
    pub layout: Layout,
    pub file: FileEntry,
    pub scenes: Vec<StoredScene>,
    /// Id and manifest digest of the scene that follows in the same split; `None` at its end.
    pub next: Option<(String, String)>,
}

impl ContainerRecord {
    /// The record of the container at `path`, if it begins the planned scenes and its bytes are whole.
    pub fn reusable(folder: &Path, path: &str, layout: Layout, planned: &[PlannedScene]) -> Option<Self> {
        let bytes = std::fs::read(record_path(folder, path)).ok()?;
        let record: Self = serde_json::from_slice(&bytes).ok()?;
        let count = record.scenes.len();
        let are_planned = count > 0
            && count <= planned.len()
            && record.scenes.iter().zip(planned).all(|(stored, planned)| {
                stored.id == planned.id && stored.manifest_sha256 == planned.manifest_sha256
            });
        if !are_planned
            || record.layout != layout
            || record.file.path != path
            || record.next != next(planned, count)
        {
            return None;
        }
        let (size, sha256) = files::measure(&folder.join(path)).ok()?;
        (size == record.file.size && sha256 == record.file.sha256).then_some(record)
    }

    /// Writes the record.
    ///
    /// # Errors
    ///
    /// [`DatasetError::File`].
    pub fn write(&self, folder: &Path) -> Result<(), DatasetError> {
        let bytes = serde_json::to_vec(self)
            .map_err(|error| DatasetError::dataset(Path::new(&self.file.path), error.to_string()))?;
        let path = record_path(folder, &self.file.path);
        // It is not synced: a record that is lost or torn costs its container, which is written again.
        std::fs::write(&path, bytes).map_err(DatasetError::file("write", &path))
    }
}

/// Id and manifest digest of the scene at `index`.
pub fn next(planned: &[PlannedScene], index: usize) -> Option<(String, String)> {
    planned.get(index).map(|scene| (scene.id.clone(), scene.manifest_sha256.clone()))
}

fn record_path(folder: &Path, path: &str) -> PathBuf {
    folder.join(FOLDER).join(format!("{}.json", path.replace('/', "-")))
}
