//! Operations on blobs in files alone: the lock between sweeps and backups, and the removal of unfinished puts.
//!
//! A put whose process ended leaves a file `<digest>#<number>`. `object_store` writes such a file and renames it; it
//! never lists one.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::{Backend, Blobs, StoreError};
use crate::private_files;

/// Removes the files of unfinished puts in `folder` that are older than `before`; their number and bytes.
pub(super) fn remove_unfinished(
    folder: &Path,
    before: SystemTime,
    dry_run: bool,
) -> std::io::Result<(u64, u64)> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok((0, 0)),
        Err(error) => return Err(error),
    };
    let (mut count, mut bytes) = (0, 0);
    for entry in entries {
        let entry = entry?;
        let name = entry.file_name();
        let is_unfinished = name.to_str().and_then(|name| name.split_once('#')).is_some_and(|(_, number)| {
            !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())
        });
        let Some(meta) = is_unfinished.then(|| entry.metadata().ok()).flatten() else { continue };
        if meta.modified().is_ok_and(|modified| modified < before)
            && (dry_run || std::fs::remove_file(entry.path()).is_ok())
        {
            count += 1;
            bytes += meta.len();
        }
    }
    Ok((count, bytes))
}

/// A lock that keeps sweeps and backups apart; released when it is dropped.
pub(crate) struct SweepLock(
    /// `None` where blobs are no files.
    #[expect(dead_code, reason = "the lock lives as long as the file is open")]
    Option<File>,
);

impl Blobs {
    /// Locks out backups; `None` if one is under way.
    pub(crate) fn lock_for_sweep(&self) -> Result<Option<SweepLock>, StoreError> {
        let Some((path, file)) = self.lock_file()? else { return Ok(Some(SweepLock(None))) };
        match file.try_lock() {
            Ok(()) => Ok(Some(SweepLock(Some(file)))),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(source)) => Err(StoreError::DataDir { path, source }),
        }
    }

    /// Locks out sweeps; waits for the end of one that is under way.
    pub(crate) async fn lock_against_sweep(&self) -> Result<SweepLock, StoreError> {
        let Some((path, file)) = self.lock_file()? else { return Ok(SweepLock(None)) };
        let locked = tokio::task::spawn_blocking(move || file.lock_shared().map(|()| file)).await;
        match locked {
            Ok(Ok(file)) => Ok(SweepLock(Some(file))),
            Ok(Err(source)) => Err(StoreError::DataDir { path, source }),
            Err(died) => Err(StoreError::DataDir { path, source: std::io::Error::other(died) }),
        }
    }

    fn lock_file(&self) -> Result<Option<(PathBuf, File)>, StoreError> {
        let Backend::Files { directory } = &self.backend else { return Ok(None) };
        let path = directory.join("sweep.lock");
        match private_files::file(&path) {
            Ok(file) => Ok(Some((path, file))),
            Err(source) => Err(StoreError::DataDir { path, source }),
        }
    }
}
