//! Files of a version. Each is recorded as soon as its blob is there, so that no sweep takes the blob.

use sqlx::any::AnyRow;
use sqlx::{AnyConnection, Row};

use super::claim::guard;
use super::{DatasetLease, DatasetRow};
use crate::boxed;
use crate::{Digest, Store, StoreError};
use scene::DatasetId;

/// A file of a version.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DatasetFile {
    /// Relative to the folder of the version, such as `shards/train-000000.tar`.
    pub path: String,
    pub digest: Digest,
    /// Bytes.
    pub size: u64,
    pub media_type: String,
}

impl Store {
    /// The files of a version, by path. The caller checks the tenant.
    #[boxed]
    pub async fn dataset_files(&self, id: &DatasetId) -> Result<Vec<DatasetFile>, StoreError> {
        let rows = sqlx::query("SELECT * FROM dataset_files WHERE dataset_id = $1 ORDER BY path")
            .bind(id.as_str())
            .fetch_all(&self.readers)
            .await?;
        rows.iter().map(file_of).collect()
    }

    /// One file of a version. The caller checks the tenant.
    #[boxed]
    pub async fn dataset_file(&self, id: &DatasetId, path: &str) -> Result<Option<DatasetFile>, StoreError> {
        let row = sqlx::query("SELECT * FROM dataset_files WHERE dataset_id = $1 AND path = $2")
            .bind(id.as_str())
            .bind(path)
            .fetch_optional(&self.readers)
            .await?;
        row.as_ref().map(file_of).transpose()
    }

    /// Records a file whose blob was put.
    #[boxed]
    pub async fn record_dataset_file(
        &self,
        lease: &DatasetLease,
        file: DatasetFile,
    ) -> Result<(), StoreError> {
        let lease = lease.clone();
        self.writer
            .write("record a file of a dataset", move |connection| {
                Box::pin(async move {
                    guard(connection, &lease).await?;
                    note_progress(connection, &lease, &file.path).await?;
                    sqlx::query(
                        "INSERT INTO dataset_files (dataset_id, path, digest, size, media_type) VALUES ($1, $2, $3, $4, $5)
                         ON CONFLICT (dataset_id, path) DO UPDATE
                         SET digest = excluded.digest, size = excluded.size, media_type = excluded.media_type",
                    )
                    .bind(lease.id.as_str())
                    .bind(&file.path)
                    .bind(file.digest.as_str())
                    .bind(i64::try_from(file.size).unwrap_or(i64::MAX))
                    .bind(&file.media_type)
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            })
            .await
    }

    /// Gives a dataset the files of an earlier one, whose version it is.
    #[boxed]
    pub async fn share_dataset_files(
        &self,
        lease: &DatasetLease,
        earlier: &DatasetRow,
    ) -> Result<(), StoreError> {
        let (lease, earlier) = (lease.clone(), earlier.id.clone());
        self.writer
            .write("share the files of a dataset", move |connection| {
                Box::pin(async move {
                    guard(connection, &lease).await?;
                    sqlx::query("DELETE FROM dataset_files WHERE dataset_id = $1")
                        .bind(lease.id.as_str())
                        .execute(&mut *connection)
                        .await?;
                    sqlx::query(
                        "INSERT INTO dataset_files (dataset_id, path, digest, size, media_type)
                         SELECT $1, path, digest, size, media_type FROM dataset_files WHERE dataset_id = $2",
                    )
                    .bind(lease.id.as_str())
                    .bind(earlier.as_str())
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            })
            .await
    }
}

/// A file that no attempt has recorded before is progress: the current attempt is the first one since.
async fn note_progress(
    connection: &mut AnyConnection,
    lease: &DatasetLease,
    path: &str,
) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE datasets SET attempt = 1, shared_deaths = 0, lone_deaths = 0
         WHERE id = $1 AND NOT EXISTS (SELECT 1 FROM dataset_files WHERE dataset_id = $1 AND path = $2)",
    )
    .bind(lease.id.as_str())
    .bind(path)
    .execute(connection)
    .await?;
    Ok(())
}

fn file_of(row: &AnyRow) -> Result<DatasetFile, StoreError> {
    Ok(DatasetFile {
        path: row.try_get("path")?,
        digest: Digest::parse(&row.try_get::<String, _>("digest")?)?,
        size: u64::try_from(row.try_get::<i64, _>("size")?).unwrap_or(0),
        media_type: row.try_get("media_type")?,
    })
}
