//! The operator's connection beside running processes: it takes no lock of the data directory and touches no job.
//!
//! It pauses and resumes claiming, makes and revokes keys, reads the record of changes, and shows and sets the limits of
//! tenants. The methods lie with what they change.

use std::path::Path;

use sqlx::AnyConnection;

use super::limits::LimitSettings;
use super::queue::switch::{QueueStatus, set_paused, status};
use super::{Settings, StoreError, database};
use crate::boxed;

/// A connection with the rights of an operator.
pub struct Operator {
    pub(super) connection: AnyConnection,
    /// Limits of tenants without values of their own.
    pub(super) limits: LimitSettings,
}

impl Operator {
    /// Connects to the database of a data directory or of the settings, which must exist and be up to date.
    ///
    /// # Errors
    ///
    /// [`StoreError::NoDatabase`] without a database in the directory, [`StoreError::Sql`] if it cannot be reached.
    #[boxed]
    pub async fn open(data_dir: &Path, settings: &Settings) -> Result<Self, StoreError> {
        Ok(Self { connection: database::bystander(data_dir, settings).await?, limits: settings.limits })
    }

    /// Lets every worker finish the jobs that it holds, and claim no others. Workers notice within `worker.poll_ms`.
    #[boxed]
    pub async fn pause_queue(&mut self, reason: &str) -> Result<(), StoreError> {
        set_paused(&mut self.connection, true, reason).await
    }

    /// Lets workers claim jobs again.
    #[boxed]
    pub async fn resume_queue(&mut self) -> Result<(), StoreError> {
        set_paused(&mut self.connection, false, "").await
    }

    /// The state of the queue.
    #[boxed]
    pub async fn queue_status(&mut self) -> Result<QueueStatus, StoreError> {
        status(&mut self.connection).await
    }
}
