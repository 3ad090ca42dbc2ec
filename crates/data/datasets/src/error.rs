//! The reasons why a dataset is not written or not read.

use std::path::{Path, PathBuf};

/// The reason why a dataset is not written or not read. Every message states the file and the correction.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    #[error("cannot {attempt} {path}: {source}")]
    File { attempt: &'static str, path: PathBuf, source: std::io::Error },
    #[error("{place} is no usable bundle: {reason}")]
    Bundle { place: PathBuf, reason: String },
    #[error("{place} is no dataset: {reason}")]
    Dataset { place: PathBuf, reason: String },
    #[error("{path}, line {line}: {reason}")]
    BatchOutput { path: PathBuf, line: usize, reason: String },
    #[error("{0}")]
    Request(String),
    /// Splits with a share above 0 would have no scene.
    #[error("{0}")]
    EmptySplits(String),
    #[error("the bundle {place} could not be packed: {source}")]
    Packing { place: PathBuf, source: export::ExportError },
}

impl DatasetError {
    /// Wraps an input or output error of `path`.
    pub(crate) fn file(attempt: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { attempt, path, source }
    }

    pub(crate) fn bundle(place: &Path, reason: impl Into<String>) -> Self {
        Self::Bundle { place: place.to_owned(), reason: reason.into() }
    }

    pub(crate) fn dataset(place: &Path, reason: impl Into<String>) -> Self {
        Self::Dataset { place: place.to_owned(), reason: reason.into() }
    }
}
