//! The end of work on a dataset.

use serde_json::Value;
use sqlx::AnyConnection;

use super::DatasetLease;
use super::claim::guard;
use crate::boxed;
use crate::{Store, StoreError, database};

/// What came of a freeze.
#[derive(Clone, Debug, PartialEq)]
pub enum FreezeResult {
    Frozen(FrozenVersion),
    /// There is no version.
    Failed {
        /// Stable, `[a-z0-9_]+`.
        code: String,
        /// A sentence with advice.
        message: String,
    },
}

/// A version whose files are recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct FrozenVersion {
    pub version: i64,
    /// Digest of the manifest, as the manifest states it.
    pub digest: String,
    /// For clients, as JSON.
    pub summary: Value,
    /// Paths of the files; others that an interrupted freeze recorded are dropped.
    pub paths: Vec<String>,
}

impl Store {
    /// Ends a freeze.
    ///
    /// # Errors
    ///
    /// [`StoreError::DatasetLeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn finish_freeze(&self, lease: &DatasetLease, result: FreezeResult) -> Result<(), StoreError> {
        let lease = lease.clone();
        self.writer
            .write("finish a dataset", move |connection| {
                Box::pin(async move { finish(connection, &lease, &result).await })
            })
            .await?;
        self.announce();
        Ok(())
    }

    /// Ends a verification with what it found, as JSON.
    ///
    /// # Errors
    ///
    /// [`StoreError::DatasetLeaseLost`] if the lease is no longer valid.
    #[boxed]
    pub async fn finish_verification(&self, lease: &DatasetLease, found: Value) -> Result<(), StoreError> {
        let lease = lease.clone();
        self.writer
            .write("finish the verification of a dataset", move |connection| {
                Box::pin(async move {
                    guard(connection, &lease).await?;
                    sqlx::query(
                        "UPDATE datasets SET verify_state = 'finished', verification = $1, owner = NULL, lease_until = 0
                         WHERE id = $2",
                    )
                    .bind(found.to_string())
                    .bind(lease.id.as_str())
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            })
            .await?;
        self.announce();
        Ok(())
    }
}

async fn finish(
    connection: &mut AnyConnection,
    lease: &DatasetLease,
    result: &FreezeResult,
) -> Result<(), StoreError> {
    guard(connection, lease).await?;
    let now = database::now_ms(connection).await?;
    let (state, frozen, failure) = match result {
        FreezeResult::Frozen(frozen) => ("finished", Some(frozen), None),
        FreezeResult::Failed { code, message } => ("failed", None, Some((code, message))),
    };
    sqlx::query(
        "UPDATE datasets SET state = $1, version = $2, digest = $3, summary = $4, failure_code = $5,
                             failure_message = $6, finished_at = $7, owner = NULL, lease_until = 0
         WHERE id = $8",
    )
    .bind(state)
    .bind(frozen.map(|frozen| frozen.version))
    .bind(frozen.map(|frozen| frozen.digest.clone()))
    .bind(frozen.map(|frozen| frozen.summary.to_string()))
    .bind(failure.map(|(code, _)| code.clone()))
    .bind(failure.map(|(_, message)| message.clone()))
    .bind(now)
    .bind(lease.id.as_str())
    .execute(&mut *connection)
    .await?;
    let recorded: Vec<String> = sqlx::query_scalar("SELECT path FROM dataset_files WHERE dataset_id = $1")
        .bind(lease.id.as_str())
        .fetch_all(&mut *connection)
        .await?;
    let known: &[String] = frozen.map_or(&[], |frozen| &frozen.paths);
    for path in recorded.iter().filter(|path| !known.contains(path)) {
        sqlx::query("DELETE FROM dataset_files WHERE dataset_id = $1 AND path = $2")
            .bind(lease.id.as_str())
            .bind(path)
            .execute(&mut *connection)
            .await?;
    }
    Ok(())
}
