//! The files of a finished recording.

use sqlx::Row;
use sqlx::any::AnyRow;

use super::{count, stored};
use crate::boxed;
use crate::{Digest, Store, StoreError};
use scene::RecordingId;

/// A file of a dataset, and where it is in the archive of its format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordingFile {
    /// Begins with the format, such as `robomimic/dataset.hdf5`.
    pub path: String,
    pub digest: Digest,
    /// Of its first byte in the archive.
    pub start: u64,
    /// Bytes.
    pub size: u64,
}

impl Store {
    /// Files of a recording behind a place in the list of all, each with its place. The caller checks the tenant.
    #[boxed]
    pub async fn recording_files(
        &self,
        id: &RecordingId,
        after_place: Option<u64>,
        limit: u32,
    ) -> Result<Vec<(u64, RecordingFile)>, StoreError> {
        let rows = sqlx::query(
            "SELECT * FROM recording_files WHERE recording_id = $1 AND place > $2 ORDER BY place LIMIT $3",
        )
        .bind(id.as_str())
        .bind(after_place.map_or(-1, stored))
        .bind(i64::from(limit))
        .fetch_all(&self.readers)
        .await?;
        rows.iter().map(|row| Ok((count(row, "place")?, file_of(row)?))).collect()
    }

    /// One file of a recording. The caller checks the tenant.
    #[boxed]
    pub async fn recording_file(
        &self,
        id: &RecordingId,
        path: &str,
    ) -> Result<Option<RecordingFile>, StoreError> {
        let row = sqlx::query("SELECT * FROM recording_files WHERE recording_id = $1 AND path = $2")
            .bind(id.as_str())
            .bind(path)
            .fetch_optional(&self.readers)
            .await?;
        row.as_ref().map(file_of).transpose()
    }
}

fn file_of(row: &AnyRow) -> Result<RecordingFile, StoreError> {
    Ok(RecordingFile {
        path: row.try_get("path")?,
        digest: Digest::parse(&row.try_get::<String, _>("digest")?)?,
        start: count(row, "start")?,
        size: count(row, "size")?,
    })
}
