//! Finished attempts as files, so that an order goes on where it was stopped.
//!
//! `order.json` says what the attempts are of. `000017.unit` is an episode, `000017.json` the outcome of the attempt,
//! which is written last. Both get their names when they are complete. `dataset` is what is assembled of them.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use demonstrations::Attempted;

const ORDER: &str = "order.json";
const DATASET: &str = "dataset";

/// Result of an attempt.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AttemptOutcome {
    /// `success`, or the reason of the failure.
    pub outcome: String,
    /// Details of the outcome, for people.
    pub detail: String,
    /// Whether there is an episode of it.
    pub is_recorded: bool,
}

impl AttemptOutcome {
    pub fn is_success(&self) -> bool {
        self.outcome == "success"
    }
}

/// The folder of an order's attempts.
pub struct UnitFolder {
    path: PathBuf,
}

/// A folder that will not do, or a disk that does not.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    #[error("{path} holds episodes of another order; give another --out, or remove the folder to begin anew")]
    OtherOrder { path: PathBuf },
    #[error("{path} holds files that are no episodes; give another --out, or move them")]
    OtherFiles { path: PathBuf },
    #[error(
        "keeping finished episodes, at {path}: {source}; free space or set permissions there, and run the same command"
    )]
    Disk { path: PathBuf, source: std::io::Error },
}

impl UnitFolder {
    /// Opens or begins the folder beside the dataset's, for the order with this description.
    ///
    /// # Errors
    ///
    /// [`FolderError`].
    pub fn open(dataset: &Path, order: &str) -> Result<Self, FolderError> {
        let mut name = dataset.file_name().unwrap_or_default().to_owned();
        name.push(".units");
        let folder = Self { path: dataset.with_file_name(name) };
        std::fs::create_dir_all(&folder.path).map_err(|source| folder.error(&folder.path, source))?;
        let path = folder.path.join(ORDER);
        match std::fs::read_to_string(&path) {
            Ok(found) if found == order => Ok(folder),
            Ok(_) => Err(FolderError::OtherOrder { path: folder.path }),
            Err(error) if error.kind() == ErrorKind::NotFound => {
                // The folder is removed in the end, so it must hold nothing but episodes.
                if folder.holds_other_files()? {
                    return Err(FolderError::OtherFiles { path: folder.path });
                }
                folder.write(ORDER, order.as_bytes())?;
                Ok(folder)
            }
            Err(source) => Err(folder.error(&path, source)),
        }
    }

    /// Whether there is more than what a stop leaves of the very beginning.
    fn holds_other_files(&self) -> Result<bool, FolderError> {
        let begun = format!("{ORDER}.part");
        let entries = std::fs::read_dir(&self.path).map_err(|source| self.error(&self.path, source))?;
        for entry in entries {
            let name = entry.map_err(|source| self.error(&self.path, source))?.file_name();
            if name != *begun {
                return Ok(true);
            }
        }
        Ok(false)
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The attempts that are finished.
    ///
    /// # Errors
    ///
    /// [`FolderError`].
    pub fn outcomes(&self) -> Result<BTreeMap<u64, AttemptOutcome>, FolderError> {
        let mut outcomes = BTreeMap::new();
        let entries = std::fs::read_dir(&self.path).map_err(|source| self.error(&self.path, source))?;
        for entry in entries {
            let path = entry.map_err(|source| self.error(&self.path, source))?.path();
            let stem = path.file_stem().and_then(|stem| stem.to_str()).and_then(|stem| stem.parse().ok());
            let (Some(number), true) = (stem, path.extension().is_some_and(|end| end == "json")) else {
                continue;
            };
            let bytes = std::fs::read(&path).map_err(|source| self.error(&path, source))?;
            // What cannot be read was not finished.
            if let Ok(outcome) = serde_json::from_slice(&bytes) {
                outcomes.insert(number, outcome);
            }
        }
        Ok(outcomes)
    }

    /// Keeps an attempt.
    ///
    /// # Errors
    ///
    /// [`FolderError`].
    pub fn keep(&self, number: u64, attempted: &Attempted) -> Result<AttemptOutcome, FolderError> {
        let (unit, outcome) = match attempted {
            Attempted::Succeeded(unit) => {
                let outcome = AttemptOutcome {
                    outcome: "success".to_owned(),
                    detail: String::new(),
                    is_recorded: true,
                };
                (Some(unit), outcome)
            }
            Attempted::Failed { reason, detail, unit } => {
                let outcome = AttemptOutcome {
                    outcome: reason.clone(),
                    detail: detail.clone(),
                    is_recorded: unit.is_some(),
                };
                (unit.as_ref(), outcome)
            }
        };
        if let Some(unit) = unit {
            self.write(&format!("{number:06}.unit"), &unit.to_bytes())?;
        }
        self.write(&format!("{number:06}.json"), serde_json::json!(outcome).to_string().as_bytes())?;
        Ok(outcome)
    }

    /// The bytes of an episode.
    ///
    /// # Errors
    ///
    /// [`FolderError`].
    pub fn unit(&self, number: u64) -> Result<Vec<u8>, FolderError> {
        let path = self.path.join(format!("{number:06}.unit"));
        std::fs::read(&path).map_err(|source| self.error(&path, source))
    }

    /// The folder of the dataset.
    pub fn dataset(&self) -> PathBuf {
        self.path.join(DATASET)
    }

    /// The same, without a dataset that did not get its place.
    ///
    /// # Errors
    ///
    /// [`FolderError`].
    pub fn free_dataset(&self) -> Result<PathBuf, FolderError> {
        let path = self.dataset();
        if path.exists() {
            std::fs::remove_dir_all(&path).map_err(|source| self.error(&path, source))?;
        }
        Ok(path)
    }

    /// Forgets an attempt, which is then made again.
    ///
    /// # Errors
    ///
    /// [`FolderError`].
    pub fn forget(&self, number: u64) -> Result<(), FolderError> {
        let path = self.path.join(format!("{number:06}.json"));
        std::fs::remove_file(&path).map_err(|source| self.error(&path, source))
    }

    /// Removes the folder.
    ///
    /// # Errors
    ///
    /// [`FolderError`].
    pub fn remove(self) -> Result<(), FolderError> {
        std::fs::remove_dir_all(&self.path).map_err(|source| self.error(&self.path, source))
    }

    /// A file is there as a whole or not at all, also after a loss of power.
    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), FolderError> {
        let (path, part) = (self.path.join(name), self.path.join(format!("{name}.part")));
        let written = std::fs::File::create(&part).and_then(|mut file| {
            file.write_all(bytes)?;
            file.sync_all()
        });
        written.and_then(|()| std::fs::rename(&part, &path)).map_err(|source| self.error(&path, source))
    }

    fn error(&self, path: &Path, source: std::io::Error) -> FolderError {
        FolderError::Disk { path: path.to_owned(), source }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_of_other_files_is_left_alone() {
        let home = tempfile::tempdir().expect("a folder");
        let dataset = home.path().join("mug");
        let units = home.path().join("mug.units");
        std::fs::create_dir(&units).expect("made");
        std::fs::write(units.join("thesis.tex"), "words").expect("written");
        assert!(matches!(UnitFolder::open(&dataset, "{}"), Err(FolderError::OtherFiles { .. })));
        assert!(units.join("thesis.tex").exists());
        std::fs::rename(units.join("thesis.tex"), units.join("order.json.part")).expect("renamed");
        assert!(UnitFolder::open(&dataset, "{}").is_ok(), "what a stop leaves of the beginning");
        assert!(UnitFolder::open(&dataset, "{}").is_ok(), "the same order again");
    }
}
