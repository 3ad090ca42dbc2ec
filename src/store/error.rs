//! What can go wrong with what survives a restart.

use std::path::PathBuf;

/// Each says what was attempted, on what, and what to do where somebody can do something.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    #[error(
        "data directory {path} is in use by another process; stop that one, or give this one its own \
         directory with --data-dir"
    )]
    Locked { path: PathBuf },
    #[error("cannot use data directory {path}; check that it exists and may be written")]
    DataDir { path: PathBuf, source: std::io::Error },
    #[error("cannot bring the database up to date; it may belong to a newer version")]
    Migrate(#[from] sqlx::migrate::MigrateError),
    #[error("the database failed to {doing}")]
    Sql { doing: &'static str, source: sqlx::Error },
    #[error("the database's transaction could not be committed while it tried to {doing}: {reason}")]
    Commit { doing: &'static str, reason: String },
    #[error("the database's writer has stopped; restart the process")]
    WriterStopped,
    #[error("job {job_id} is no longer leased to this worker; its result is dropped")]
    LeaseLost { job_id: String },
    #[error("row of {table} cannot be read: {reason}")]
    Corrupt { table: &'static str, reason: String },
    #[error("blob {name} could not be {doing}")]
    Blob { name: String, doing: &'static str, source: object_store::Error },
    #[error("{0:?} is no SHA-256 digest (64 lower-case hex digits)")]
    InvalidDigest(String),
}

impl From<sqlx::Error> for StoreError {
    fn from(source: sqlx::Error) -> Self {
        Self::Sql { doing: "answer", source }
    }
}

impl StoreError {
    /// Names the operation on an SQL error that does not name one yet.
    pub(super) fn while_doing(self, doing: &'static str) -> Self {
        match self {
            Self::Sql { source, .. } => Self::Sql { doing, source },
            other => other,
        }
    }
}
