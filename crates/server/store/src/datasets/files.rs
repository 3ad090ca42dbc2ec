//! Files of a version. Each is recorded as soon as its blob is there, so that no sweep takes the blob.

use sqlx::any::AnyRow;
use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::DatasetRow;
use crate::boxed;
use crate::database::Dialect;
use crate::queue::{guard, note_progress};
use crate::{Digest, Lease, Store, StoreError, database};
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

    /// Records a file of a job's dataset, whose blob was put. A file that no attempt recorded before is progress.
    ///
    /// # Errors
    ///
    /// [`StoreError::LeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn record_dataset_file(&self, lease: &Lease, file: DatasetFile) -> Result<(), StoreError> {
        let lease = lease.clone();
        self.writer
            .write("record a file of a dataset", move |connection| {
                Box::pin(async move {
                    guard(connection, &lease).await?;
                    let id = dataset_of_job(connection, &lease).await?;
                    if !is_recorded(connection, &id, &file.path).await? {
                        note_progress(connection, &lease.job_id).await?;
                    }
                    sqlx::query(
                        "INSERT INTO dataset_files (dataset_id, path, digest, size, media_type) VALUES ($1, $2, $3, $4, $5)
                         ON CONFLICT (dataset_id, path) DO UPDATE
                         SET digest = excluded.digest, size = excluded.size, media_type = excluded.media_type",
                    )
                    .bind(id.as_str())
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

    /// Gives the dataset of a job the files of an earlier one, whose version it is.
    ///
    /// # Errors
    ///
    /// [`StoreError::LeaseLost`] if the lease is no longer valid, [`StoreError::VersionGone`] if the earlier one was
    /// deleted.
    #[boxed]
    pub async fn share_dataset_files(&self, lease: &Lease, earlier: &DatasetRow) -> Result<(), StoreError> {
        let (lease, earlier) = (lease.clone(), earlier.id.clone());
        self.writer
            .write("share the files of a dataset", move |connection| {
                Box::pin(async move {
                    guard(connection, &lease).await?;
                    let id = dataset_of_job(connection, &lease).await?;
                    // The lock keeps a deletion, and the sweep that follows it, waiting until the files are shared.
                    let lock = Dialect::of(connection).lock();
                    let query =
                        format!("SELECT id FROM datasets WHERE id = $1 AND deleted_at IS NULL {lock}");
                    let is_there: Option<String> = sqlx::query_scalar(AssertSqlSafe(query))
                        .bind(earlier.as_str())
                        .fetch_optional(&mut *connection)
                        .await?;
                    if is_there.is_none() {
                        return Err(StoreError::VersionGone);
                    }
                    sqlx::query("DELETE FROM dataset_files WHERE dataset_id = $1")
                        .bind(id.as_str())
                        .execute(&mut *connection)
                        .await?;
                    sqlx::query(
                        "INSERT INTO dataset_files (dataset_id, path, digest, size, media_type)
                         SELECT $1, path, digest, size, media_type FROM dataset_files WHERE dataset_id = $2",
                    )
                    .bind(id.as_str())
                    .bind(earlier.as_str())
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            })
            .await
    }

    /// Notes how far the work on a job's dataset is: steps that are done, and all.
    ///
    /// # Errors
    ///
    /// [`StoreError::LeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn note_dataset_steps(&self, lease: &Lease, steps: (i64, i64)) -> Result<(), StoreError> {
        let lease = lease.clone();
        self.writer
            .write("note the progress of a dataset", move |connection| {
                Box::pin(async move {
                    guard(connection, &lease).await?;
                    sqlx::query(
                        "UPDATE datasets SET steps_done = $1, steps_all = $2
                         WHERE id = (SELECT dataset_id FROM jobs WHERE id = $3)",
                    )
                    .bind(steps.0)
                    .bind(steps.1)
                    .bind(lease.job_id.as_str())
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            })
            .await
    }
}

/// The dataset that a job works on.
async fn dataset_of_job(connection: &mut AnyConnection, lease: &Lease) -> Result<DatasetId, StoreError> {
    let row = sqlx::query("SELECT dataset_id FROM jobs WHERE id = $1")
        .bind(lease.job_id.as_str())
        .fetch_one(connection)
        .await?;
    database::id(&row, "jobs", "dataset_id")
}

async fn is_recorded(connection: &mut AnyConnection, id: &DatasetId, path: &str) -> Result<bool, StoreError> {
    let found: Option<i64> =
        sqlx::query_scalar("SELECT CAST(1 AS BIGINT) FROM dataset_files WHERE dataset_id = $1 AND path = $2")
            .bind(id.as_str())
            .bind(path)
            .fetch_optional(connection)
            .await?;
    Ok(found.is_some())
}

fn file_of(row: &AnyRow) -> Result<DatasetFile, StoreError> {
    Ok(DatasetFile {
        path: row.try_get("path")?,
        digest: Digest::parse(&row.try_get::<String, _>("digest")?)?,
        size: u64::try_from(row.try_get::<i64, _>("size")?).unwrap_or(0),
        media_type: row.try_get("media_type")?,
    })
}
