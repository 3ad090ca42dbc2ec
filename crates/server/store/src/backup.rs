//! Backup of a data directory while a service uses it, its restoration, and the check that every blob is there.
//!
//! A backup is a data directory itself: a consistent copy of the database (`VACUUM INTO`) and, below `blobs/`, every
//! blob that the copy refers to. The database is copied first and gets its name last; no sweep runs between. A second
//! backup into the same folder copies only blobs that are new.
//!
//! PostgreSQL and S3 have tools of their own for that; [`Store::verify`] checks what they restored.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use futures::{StreamExt, TryStreamExt, stream};
use serde::Serialize;

use super::blobs::sweeping::Volume;
use super::blobs::{Blobs, Read};
use super::outage::Health;
use super::retention::{ReferenceKind, for_each_reference};
use super::{Digest, Settings, Store, StoreError, database, private_files};
use crate::boxed;
use sqlx::Connection;
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};

/// Name of the database in a data directory.
pub(crate) const DATABASE_FILE: &str = "tabletopgen.sqlite";
/// Blobs that are read or copied at the same time.
const CONCURRENT_BLOBS: usize = 8;

/// A blob that a row refers to and that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LostBlob {
    pub digest: Digest,
    pub kind: ReferenceKind,
    /// The blob is there, and does not match its digest.
    pub is_damaged: bool,
}

/// Result of a backup, a restoration or a check.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct BackupReport {
    /// Blobs that were read and match their digests, or that the backup had already.
    pub intact: Volume,
    /// Blobs among these that were copied.
    pub copied: Volume,
    pub lost: Vec<LostBlob>,
}

/// Takes the number of blobs that were read, and of all.
pub type BlobCount = dyn FnMut(u64, u64) + Send;

/// Backs up a data directory of SQLite into `target`, which is created if missing.
///
/// # Errors
///
/// A [`StoreError`] if `data_dir` has no database, or if something cannot be read or written. Lost blobs are no error:
/// the report lists them.
#[boxed]
pub async fn backup(
    data_dir: &Path,
    target: &Path,
    settings: &Settings,
    notify: &mut BlobCount,
) -> Result<BackupReport, StoreError> {
    let source = data_dir.join(DATABASE_FILE);
    database::sqlite_exists(&source)?;
    let blobs = Blobs::open(data_dir, settings, Health::new())?;
    let _no_sweep = blobs.lock_against_sweep().await?;
    private_files::whole_directory(target).map_err(|error| data_dir_error(target, error))?;
    let snapshot = target.join(format!("{DATABASE_FILE}.partial"));
    remove_if_there(&snapshot)?;
    // SQLite writes into an empty file, and leaves its mode.
    private_files::file(&snapshot).map_err(|error| data_dir_error(&snapshot, error))?;
    copy_database(&source, &snapshot).await?;
    let copies = Blobs::local(&target.join("blobs"), true, Health::new())?;
    let report = copy_blobs(&snapshot, settings, &blobs, &copies, notify).await?;
    rename_durably(&snapshot, &target.join(DATABASE_FILE))?;
    Ok(report)
}

/// Restores a backup into a data directory without a database; blobs go where the settings keep them.
///
/// # Errors
///
/// A [`StoreError`] if the data directory has a database or is in use, or if something cannot be read or written. The
/// database is written last, and only if nothing but lost blobs was found.
#[boxed]
pub async fn restore(
    backup: &Path,
    data_dir: &Path,
    settings: &Settings,
    notify: &mut BlobCount,
) -> Result<BackupReport, StoreError> {
    let source = backup.join(DATABASE_FILE);
    database::sqlite_exists(&source)?;
    let _lock = super::directory(data_dir)?;
    let destination = data_dir.join(DATABASE_FILE);
    if destination.exists() {
        let kind = std::io::ErrorKind::AlreadyExists;
        return Err(data_dir_error(&destination, kind.into()));
    }
    let originals = Blobs::local(&backup.join("blobs"), false, Health::new())?;
    let blobs = Blobs::open(data_dir, settings, Health::new())?;
    let report = copy_blobs(&source, settings, &originals, &blobs, notify).await?;
    let partial = data_dir.join(format!("{DATABASE_FILE}.partial"));
    // The copy has the mode of the backup.
    std::fs::copy(&source, &partial)
        .and_then(|_| private_files::set(&partial))
        .map_err(|error| data_dir_error(&partial, error))?;
    rename_durably(&partial, &destination)?;
    Ok(report)
}

/// Checks a backup without restoring it: every blob that a row refers to is read and compared with its digest.
///
/// # Errors
///
/// A [`StoreError`] if `backup` has no database, or if something cannot be read.
#[boxed]
pub async fn verify(
    backup: &Path,
    settings: &Settings,
    notify: &mut BlobCount,
) -> Result<BackupReport, StoreError> {
    let source = backup.join(DATABASE_FILE);
    database::sqlite_exists(&source)?;
    let blobs = Blobs::local(&backup.join("blobs"), false, Health::new())?;
    check_blobs(references(&source, settings).await?, &blobs, notify).await
}

impl Store {
    /// Reads every blob that a row refers to and compares it with its digest.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if something cannot be read.
    #[boxed]
    pub async fn verify(&self, notify: &mut BlobCount) -> Result<BackupReport, StoreError> {
        let mut found = BTreeMap::new();
        for_each_reference(&self.readers.unhurried(), |kind, digest| {
            found.entry(digest).or_insert(kind);
        })
        .await?;
        check_blobs(found, &self.blobs, notify).await
    }
}

/// Writes a consistent copy of a SQLite database that others may use.
async fn copy_database(from: &Path, to: &Path) -> Result<(), StoreError> {
    let failed = |source| StoreError::Sql { doing: "copy itself", source };
    let options = SqliteConnectOptions::new().filename(from).create_if_missing(false);
    let mut connection = SqliteConnection::connect_with(&options).await.map_err(failed)?;
    let name = to.to_string_lossy().into_owned();
    sqlx::query("VACUUM INTO ?").bind(name).execute(&mut connection).await.map_err(failed)?;
    connection.close().await.map_err(failed)
}

/// Every blob that a database file refers to, once.
async fn references(
    database: &Path,
    settings: &Settings,
) -> Result<BTreeMap<Digest, ReferenceKind>, StoreError> {
    sqlx::any::install_default_drivers();
    let pool = database::sqlite_readers(database, settings).await?;
    let mut found = BTreeMap::new();
    let read = for_each_reference(&pool, |kind, digest| {
        found.entry(digest).or_insert(kind);
    })
    .await;
    pool.close().await;
    read.map(|()| found)
}

async fn copy_blobs(
    database: &Path,
    settings: &Settings,
    from: &Blobs,
    to: &Blobs,
    notify: &mut BlobCount,
) -> Result<BackupReport, StoreError> {
    let references = references(database, settings).await?;
    let count = references.len() as u64;
    let copied = stream::iter(references).map(|(digest, kind)| async move {
        if let Some(bytes) = to.size(&digest).await? {
            return Ok(BlobResult::Intact { bytes, is_copied: false });
        }
        match from.intact(&digest).await? {
            Read::Intact(bytes) => {
                let size = bytes.len() as u64;
                to.put(bytes).await?;
                Ok(BlobResult::Intact { bytes: size, is_copied: true })
            }
            lost => Ok(BlobResult::Lost(lost_blob(digest, kind, &lost))),
        }
    });
    report(copied.buffer_unordered(CONCURRENT_BLOBS), count, notify).await
}

async fn check_blobs(
    references: BTreeMap<Digest, ReferenceKind>,
    blobs: &Blobs,
    notify: &mut BlobCount,
) -> Result<BackupReport, StoreError> {
    let count = references.len() as u64;
    let checked = stream::iter(references).map(|(digest, kind)| async move {
        Ok(match blobs.intact(&digest).await? {
            Read::Intact(bytes) => BlobResult::Intact { bytes: bytes.len() as u64, is_copied: false },
            lost => BlobResult::Lost(lost_blob(digest, kind, &lost)),
        })
    });
    report(checked.buffer_unordered(CONCURRENT_BLOBS), count, notify).await
}

enum BlobResult {
    Intact { bytes: u64, is_copied: bool },
    Lost(LostBlob),
}

fn lost_blob(digest: Digest, kind: ReferenceKind, read: &Read) -> LostBlob {
    LostBlob { digest, kind, is_damaged: matches!(read, Read::Damaged) }
}

async fn report(
    results: impl futures::Stream<Item = Result<BlobResult, StoreError>>,
    count: u64,
    notify: &mut BlobCount,
) -> Result<BackupReport, StoreError> {
    let mut report = BackupReport::default();
    let mut results = std::pin::pin!(results);
    let mut done = 0;
    while let Some(result) = results.try_next().await? {
        match result {
            BlobResult::Intact { bytes, is_copied } => {
                report.intact.add(bytes);
                if is_copied {
                    report.copied.add(bytes);
                }
            }
            BlobResult::Lost(blob) => report.lost.push(blob),
        }
        done += 1;
        notify(done, count);
    }
    report.lost.sort_by(|a, b| (b.kind, &a.digest).cmp(&(a.kind, &b.digest)));
    Ok(report)
}

fn remove_if_there(path: &Path) -> Result<(), StoreError> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(data_dir_error(path, error)),
        _ => Ok(()),
    }
}

/// Syncs a file, gives it its name, and syncs the name.
fn rename_durably(from: &Path, to: &Path) -> Result<(), StoreError> {
    let done = std::fs::File::open(from)
        .and_then(|file| file.sync_all())
        .and_then(|()| std::fs::rename(from, to))
        .and_then(|()| match to.parent() {
            Some(folder) if cfg!(unix) => std::fs::File::open(folder)?.sync_all(),
            _ => Ok(()),
        });
    done.map_err(|error| data_dir_error(to, error))
}

fn data_dir_error(path: &Path, source: std::io::Error) -> StoreError {
    StoreError::DataDir { path: PathBuf::from(path), source }
}

#[cfg(test)]
mod tests;
