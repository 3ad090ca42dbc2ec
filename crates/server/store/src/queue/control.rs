//! The operator's connection beside running processes: it takes no lock of the data directory and touches no job.

use std::path::Path;

use sqlx::AnyConnection;

use super::switch::{QueueStatus, set_paused, status};
use crate::boxed;
use crate::{Settings, StoreError, database};

/// A connection that shows the queue, and pauses and resumes claiming.
pub struct QueueControl {
    connection: AnyConnection,
}

impl QueueControl {
    /// Connects to the database of a data directory or of the settings, which must exist and be up to date.
    ///
    /// # Errors
    ///
    /// [`StoreError::DataDir`] without a database in the directory, [`StoreError::Sql`] if it cannot be reached.
    #[boxed]
    pub async fn open(data_dir: &Path, settings: &Settings) -> Result<Self, StoreError> {
        Ok(Self { connection: database::bystander(data_dir, settings).await? })
    }

    /// Lets every worker finish the jobs that it holds, and claim no others. Workers notice within `worker.poll_ms`.
    #[boxed]
    pub async fn pause(&mut self, reason: &str) -> Result<(), StoreError> {
        set_paused(&mut self.connection, true, reason).await
    }

    /// Lets workers claim jobs again.
    #[boxed]
    pub async fn resume(&mut self) -> Result<(), StoreError> {
        set_paused(&mut self.connection, false, "").await
    }

    /// The state of the queue.
    #[boxed]
    pub async fn status(&mut self) -> Result<QueueStatus, StoreError> {
        status(&mut self.connection).await
    }
}
