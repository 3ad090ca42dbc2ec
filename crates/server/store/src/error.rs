//! Errors of the store.

use std::error::Error;
use std::path::PathBuf;

use super::outage::Outage;
use super::postgres;
use scene::JobId;

/// Errors of the store. Messages name the operation, its target, and a remedy if there is one.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    #[error(
        "data directory {path} is in use by another process; stop that one, or give this one its own \
         directory with --data-dir"
    )]
    Locked { path: PathBuf },
    #[error("cannot use data directory {path}; check that it exists and may be written")]
    DataDir { path: PathBuf, source: std::io::Error },
    #[error(
        "there is no database of tabletopgen in {place} (expected {expected}); check --data-dir and store.database, or \
         create one with `tabletopgen serve` or `tabletopgen migrate --create`"
    )]
    NoDatabase { place: String, expected: &'static str },
    #[error(
        "the settings name {what}, and this program was built without it; build with `--features {feature}`"
    )]
    NotBuilt { what: &'static str, feature: &'static str },
    #[error("cannot bring the database up to date; it may belong to a newer version")]
    Migrate(#[from] sqlx::migrate::MigrateError),
    #[error("the database failed to {doing}")]
    Sql { doing: &'static str, source: sqlx::Error },
    #[error("the database's transaction could not be committed while it tried to {doing}: {reason}")]
    Commit { doing: &'static str, reason: String, outage: Option<Outage> },
    #[error("the database's writer has stopped; restart the process")]
    WriterStopped,
    #[error("job {job_id} is no longer leased to this worker; its result is dropped")]
    LeaseLost { job_id: JobId },
    #[error("row of {table} cannot be read: {reason}")]
    Corrupt { table: &'static str, reason: String },
    #[error("blob {name} could not be {doing}")]
    Blob { name: String, doing: &'static str, source: object_store::Error },
    #[error("blob {name} does not match its digest; it is set aside and made again when it is wanted")]
    BlobDamaged { name: String },
    #[error("the checkpoint was removed; the stage runs again")]
    CheckpointGone,
    #[error("the earlier version of the dataset was deleted meanwhile; freeze again")]
    VersionGone,
    #[error("{0:?} is no SHA-256 digest (64 lower-case hex digits)")]
    InvalidDigest(String),
    #[error("the system gave no random bytes for a key")]
    NoRandomBytes(#[source] getrandom::Error),
}

impl From<sqlx::Error> for StoreError {
    fn from(source: sqlx::Error) -> Self {
        Self::Sql { doing: "answer", source }
    }
}

impl StoreError {
    /// The error of a command that wants existing data and found none.
    pub(super) fn no_database(place: &str, expected: &'static str) -> Self {
        Self::NoDatabase { place: place.to_owned(), expected }
    }

    /// The reason why no write can succeed at present; `None` for errors of a single operation.
    pub fn outage(&self) -> Option<Outage> {
        match self {
            Self::Sql { source, .. } => sql_outage(source),
            Self::Commit { outage, .. } => *outage,
            Self::Blob { source, .. } => Some(io_outage(source)),
            Self::DataDir { source, .. } => Some(io_outage(source)),
            Self::WriterStopped => Some(Outage::Other),
            Self::Locked { .. }
            | Self::NoDatabase { .. }
            | Self::NotBuilt { .. }
            | Self::Migrate(_)
            | Self::LeaseLost { .. }
            | Self::Corrupt { .. }
            | Self::BlobDamaged { .. }
            | Self::CheckpointGone
            | Self::VersionGone
            | Self::InvalidDigest(_)
            | Self::NoRandomBytes(_) => None,
        }
    }

    /// Whether the database rolled a transaction back because of another one: a serialization failure, a deadlock, the
    /// same key inserted twice, or a silence that others could not wait for. Repeated, it sees what the others wrote.
    pub(super) fn is_collision(&self) -> bool {
        let Self::Sql { source: sqlx::Error::Database(error), .. } = self else { return false };
        matches!(error.code().as_deref(), Some("40001" | "40P01" | "23505" | "25P03"))
    }

    /// Message and causes on one line, for the log.
    pub fn chain(&self) -> String {
        runtime::error_chain(self)
    }

    /// Sets the operation of an SQL error.
    pub(super) fn while_doing(self, doing: &'static str) -> Self {
        match self {
            Self::Sql { source, .. } => Self::Sql { doing, source },
            other => other,
        }
    }
}

/// The outage that an SQL error means, rather than a wrong statement.
fn sql_outage(error: &sqlx::Error) -> Option<Outage> {
    match error {
        sqlx::Error::Database(error) => {
            let code = error.code()?;
            match postgres::is_error(error.as_ref()) {
                true => postgres_outage(&code),
                false => sqlite_outage(&code),
            }
        }
        sqlx::Error::Io(error) => Some(io_outage(error)),
        sqlx::Error::PoolTimedOut
        | sqlx::Error::PoolClosed
        | sqlx::Error::WorkerCrashed
        | sqlx::Error::Tls(_)
        | sqlx::Error::Protocol(_) => Some(Outage::Other),
        _ => None,
    }
}

/// Maps SQLite's result codes (low byte): BUSY, LOCKED, READONLY, IOERR, CORRUPT, FULL, CANTOPEN, NOTADB.
fn sqlite_outage(code: &str) -> Option<Outage> {
    match code.parse::<i64>().ok()? & 0xff {
        13 => Some(Outage::Full),
        5 | 6 | 8 | 10 | 11 | 14 | 26 => Some(Outage::Other),
        _ => None,
    }
}

/// Maps PostgreSQL's classes of SQLSTATE: connection exceptions, insufficient resources, operator intervention
/// (shutdown, starting up, a statement past its limit), system errors, a read-only server, and a lock that was not
/// free in time.
fn postgres_outage(code: &str) -> Option<Outage> {
    match code {
        "53100" => Some(Outage::Full),
        "25006" | "55P03" => Some(Outage::Other),
        _ => matches!(code.get(..2)?, "08" | "53" | "57" | "58" | "XX").then_some(Outage::Other),
    }
}

fn io_outage(error: &(dyn Error + 'static)) -> Outage {
    let mut cause = Some(error);
    while let Some(error) = cause {
        let kind = error.downcast_ref::<std::io::Error>().map(std::io::Error::kind);
        if matches!(kind, Some(std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded)) {
            return Outage::Full;
        }
        cause = error.source();
    }
    Outage::Other
}
