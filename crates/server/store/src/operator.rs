//! The operator's connection beside running processes: it takes no lock of the data directory and touches no job.
//!
//! It pauses and resumes claiming, makes and revokes keys, reads the record of changes, and shows and sets the limits
//! of tenants. The methods lie with what they change.

use std::path::Path;

use sqlx::AnyConnection;

use super::limits::LimitSettings;
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
}
