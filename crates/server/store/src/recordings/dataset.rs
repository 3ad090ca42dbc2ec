//! The dataset of a recording while it is assembled. Parts are recorded as soon as their blobs are there, so that no
//! sweep takes them.

use serde::{Deserialize, Serialize};
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, Row};

use super::{RecordingFile, corrupt, count, stored};
use crate::boxed;
use crate::queue::guard;
use crate::{Digest, Lease, Store, StoreError, database};
use scene::RecordingId;

/// A format of a dataset: a tar archive, as the parts it is stored in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordingArchive {
    pub format: String,
    /// Of the archive; `None` until it is complete.
    pub digest: Option<Digest>,
    /// Bytes.
    pub size: u64,
    /// Number of files in it.
    pub files: u64,
    pub parts: Vec<ArchivePart>,
}

/// A part of an archive: the blob that has its bytes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ArchivePart {
    pub digest: Digest,
    /// Bytes.
    pub size: u64,
}

impl Store {
    /// Begins to assemble: drops what an interrupted process recorded.
    ///
    /// # Errors
    ///
    /// [`StoreError::LeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn begin_assembly(&self, lease: &Lease) -> Result<(), StoreError> {
        let lease = lease.clone();
        self.writer
            .write("begin to assemble", move |connection| {
                Box::pin(async move {
                    let id = assembled(connection, &lease).await?;
                    drop_dataset(connection, &id).await
                })
            })
            .await
    }

    /// Records the parts of an archive so far.
    ///
    /// # Errors
    ///
    /// [`StoreError::LeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn record_recording_archive(
        &self,
        lease: &Lease,
        archive: RecordingArchive,
    ) -> Result<(), StoreError> {
        let lease = lease.clone();
        let parts = serde_json::to_string(&archive.parts).unwrap_or_default();
        self.writer
            .write("record an archive of a recording", move |connection| {
                Box::pin(async move {
                    let id = assembled(connection, &lease).await?;
                    sqlx::query(
                        "INSERT INTO recording_archives (recording_id, format, digest, size, files, parts)
                         VALUES ($1, $2, $3, $4, $5, $6)
                         ON CONFLICT (recording_id, format) DO UPDATE
                         SET digest = excluded.digest, size = excluded.size, files = excluded.files,
                             parts = excluded.parts",
                    )
                    .bind(id.as_str())
                    .bind(&archive.format)
                    .bind(archive.digest.as_ref().map(Digest::to_string))
                    .bind(stored(archive.size))
                    .bind(stored(archive.files))
                    .bind(&parts)
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            })
            .await
    }

    /// Records files in archives; the first one has this place in the list of all.
    ///
    /// # Errors
    ///
    /// [`StoreError::LeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn record_recording_files(
        &self,
        lease: &Lease,
        first_place: u64,
        files: Vec<RecordingFile>,
    ) -> Result<(), StoreError> {
        let lease = lease.clone();
        self.writer
            .write("record files of a recording", move |connection| {
                Box::pin(async move {
                    let id = assembled(connection, &lease).await?;
                    for (place, file) in (first_place..).zip(&files) {
                        sqlx::query(
                            "INSERT INTO recording_files (recording_id, place, path, digest, start, size)
                             VALUES ($1, $2, $3, $4, $5, $6)",
                        )
                        .bind(id.as_str())
                        .bind(stored(place))
                        .bind(&file.path)
                        .bind(file.digest.as_str())
                        .bind(stored(file.start))
                        .bind(stored(file.size))
                        .execute(&mut *connection)
                        .await?;
                    }
                    Ok(())
                })
            })
            .await
    }

    /// The archives of a recording, by format. The caller checks the tenant, and that it is finished.
    #[boxed]
    pub async fn recording_archives(&self, id: &RecordingId) -> Result<Vec<RecordingArchive>, StoreError> {
        let rows = sqlx::query("SELECT * FROM recording_archives WHERE recording_id = $1 ORDER BY format")
            .bind(id.as_str())
            .fetch_all(&self.readers)
            .await?;
        rows.iter().map(archive_of).collect()
    }
}

/// The recording whose dataset a job assembles; fails unless the lease is still valid.
async fn assembled(connection: &mut AnyConnection, lease: &Lease) -> Result<RecordingId, StoreError> {
    guard(connection, lease).await?;
    let row = sqlx::query("SELECT recording_id FROM jobs WHERE id = $1")
        .bind(lease.job_id.as_str())
        .fetch_one(connection)
        .await?;
    database::id(&row, "jobs", "recording_id")
}

/// Drops files and archives.
pub(super) async fn drop_dataset(connection: &mut AnyConnection, id: &RecordingId) -> Result<(), StoreError> {
    for query in [
        "DELETE FROM recording_files WHERE recording_id = $1",
        "DELETE FROM recording_archives WHERE recording_id = $1",
    ] {
        sqlx::query(query).bind(id.as_str()).execute(&mut *connection).await?;
    }
    Ok(())
}

fn archive_of(row: &AnyRow) -> Result<RecordingArchive, StoreError> {
    let parts: String = row.try_get("parts")?;
    let parts = serde_json::from_str(&parts).map_err(|error| corrupt(format!("parts: {error}")))?;
    let digest: Option<String> = row.try_get("digest")?;
    Ok(RecordingArchive {
        format: row.try_get("format")?,
        digest: digest.map(|digest| Digest::parse(&digest)).transpose()?,
        size: count(row, "size")?,
        files: count(row, "files")?,
        parts,
    })
}
