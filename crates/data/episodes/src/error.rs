//! Errors of writing episodes and datasets: each states what was attempted, on what, and what to do.

use std::io;
use std::path::{Path, PathBuf};

use parquet::errors::ParquetError;
use rust_hdf5::Hdf5Error;
use video::{Mp4Error, VideoError};

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum EpisodeError {
    #[error("describing a dataset: {what}; {correction}")]
    Description { what: String, correction: &'static str },
    #[error("recording episode {episode}: {what}; {correction}")]
    Episode { episode: u64, what: String, correction: &'static str },
    #[error("recording frame {frame} of episode {episode}: {what}; {correction}")]
    Frame { episode: u64, frame: usize, what: String, correction: &'static str },
    #[error("reading an episode unit: {what}; record the episode again")]
    Unit { what: String },
    #[error("adding episode {episode} to a dataset: {what}; {correction}")]
    Order { episode: u64, what: String, correction: &'static str },
    #[error("writing a dataset to {folder}: {what}; {correction}")]
    Folder { folder: PathBuf, what: String, correction: &'static str },
    #[error(
        "writing {path}: the disk is full; free space there, or choose another folder, and write the dataset again"
    )]
    DiskFull { path: PathBuf },
    #[error("writing {path}: {source}; check the folder's permissions and its disk")]
    Write { path: PathBuf, source: io::Error },
    #[error("encoding the video of camera {camera} in episode {episode}: {source}")]
    Video { episode: u64, camera: String, source: Box<VideoError> },
}

impl EpisodeError {
    pub(crate) fn description(what: impl Into<String>, correction: &'static str) -> Self {
        Self::Description { what: what.into(), correction }
    }

    /// The error of the system at a path; a full disk has its own.
    pub(crate) fn write(path: &Path, source: io::Error) -> Self {
        if is_full(&source) {
            Self::DiskFull { path: path.to_owned() }
        } else {
            Self::Write { path: path.to_owned(), source }
        }
    }

    pub(crate) fn parquet(path: &Path, source: ParquetError) -> Self {
        match source {
            ParquetError::External(inner) => match inner.downcast::<io::Error>() {
                Ok(inner) => Self::write(path, *inner),
                Err(inner) => Self::write(path, io::Error::other(inner)),
            },
            other => Self::write(path, io::Error::other(other)),
        }
    }

    pub(crate) fn hdf5(path: &Path, source: Hdf5Error) -> Self {
        match source {
            Hdf5Error::Io(source) => Self::write(path, source),
            other => Self::write(path, io::Error::other(other.to_string())),
        }
    }

    pub(crate) fn video(episode: u64, camera: &str, source: VideoError) -> Self {
        Self::Video { episode, camera: camera.to_owned(), source: Box::new(source) }
    }

    pub(crate) fn mp4(path: &Path, source: Mp4Error) -> Self {
        match source {
            Mp4Error::Write(source) => Self::write(path, source),
            other => Self::write(path, io::Error::other(other)),
        }
    }
}

fn is_full(error: &io::Error) -> bool {
    let kinds = [io::ErrorKind::StorageFull, io::ErrorKind::QuotaExceeded];
    // Libraries pass on the text of the system and lose its kind.
    kinds.contains(&error.kind()) || error.to_string().contains("No space left on device")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_disk_is_named_through_every_library() {
        let full = || io::Error::from(io::ErrorKind::StorageFull);
        let path = Path::new("data.parquet");
        for error in [
            EpisodeError::write(path, full()),
            EpisodeError::parquet(path, ParquetError::from(full())),
            EpisodeError::mp4(path, Mp4Error::Write(full())),
            EpisodeError::write(path, io::Error::other("No space left on device (os error 28)")),
        ] {
            assert!(matches!(error, EpisodeError::DiskFull { .. }), "{error}");
            assert!(error.to_string().contains("free space"), "{error}");
        }
        let denied = io::Error::from(io::ErrorKind::PermissionDenied);
        assert!(matches!(EpisodeError::write(path, denied), EpisodeError::Write { .. }));
    }
}
