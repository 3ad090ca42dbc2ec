//! Section `[store]` of the settings.

mod postgres;

use std::fmt;

use serde::{Deserialize, Serialize};

use super::blobs::s3::S3Settings;
use super::limits::LimitSettings;
use super::retention::RetentionSettings;
pub(crate) use postgres::Limits;
pub use postgres::PostgresSettings;

/// Section `[store]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Database of scenes, jobs and checkpoints.
    pub database: DatabaseAddress,
    /// Sync to disk at every commit and blob. `false` is faster and may lose the latest work if the machine (not only
    /// the process) stops; intended for temporary data directories.
    pub fsync: bool,
    /// Place of blobs.
    pub blobs: BlobPlace,
    /// Number of connections of this process that read the SQLite file (1..=64). More connections serve more API
    /// requests concurrently.
    pub readers: u32,
    /// Maximum number of connections of this process to PostgreSQL (2..=256).
    pub connections: u32,
    /// Time that a statement waits for a locked SQLite database before it fails, milliseconds.
    pub busy_timeout_ms: u64,
    pub postgres: PostgresSettings,
    pub s3: S3Settings,
    pub retention: RetentionSettings,
    pub limits: LimitSettings,
}

/// Place of blobs.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum BlobPlace {
    /// Files in the data directory.
    Files,
    /// Memory of the process: their content is computed again after a restart.
    Memory,
    /// A bucket of Amazon S3 or of a compatible server; section `[store.s3]`.
    S3,
}

/// The database of jobs. An address of PostgreSQL has no password, so that settings may be printed; the password comes
/// from the environment variable `PGPASSWORD` or from the file that `PGPASSFILE` names.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(try_from = "String", into = "String")]
pub enum DatabaseAddress {
    /// The file `tabletopgen.sqlite` in the data directory.
    Sqlite,
    /// `postgres://user@host:port/database?options`.
    Postgres(String),
}

/// Reason why a text is no address of a database.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DatabaseAddressError {
    #[error("use sqlite, or an address such as postgres://user@host:5432/database")]
    Unknown,
    #[error(
        "settings hold no passwords; set PGPASSWORD or PGPASSFILE in the environment and leave the password out of \
         the address"
    )]
    Password,
}

impl TryFrom<String> for DatabaseAddress {
    type Error = DatabaseAddressError;

    fn try_from(text: String) -> Result<Self, DatabaseAddressError> {
        let scheme = ["postgres://", "postgresql://"].into_iter().find(|scheme| text.starts_with(scheme));
        match scheme {
            None if text == "sqlite" => Ok(Self::Sqlite),
            None => Err(DatabaseAddressError::Unknown),
            Some(scheme) => {
                let authority = text[scheme.len()..].split(['/', '?']).next().unwrap_or_default();
                let user = authority.rsplit_once('@').map_or("", |(user, _)| user);
                if user.contains(':') || text.contains("password=") {
                    return Err(DatabaseAddressError::Password);
                }
                Ok(Self::Postgres(text))
            }
        }
    }
}

impl From<DatabaseAddress> for String {
    fn from(address: DatabaseAddress) -> Self {
        address.to_string()
    }
}

impl fmt::Display for DatabaseAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sqlite => f.write_str("sqlite"),
            Self::Postgres(address) => f.write_str(address),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_of_databases_hold_no_passwords() {
        let read = |text: &str| DatabaseAddress::try_from(text.to_owned());
        assert_eq!(read("sqlite"), Ok(DatabaseAddress::Sqlite));
        for address in ["postgres://me@db:5432/jobs", "postgresql:///jobs?host=/run/pg&user=me"] {
            assert_eq!(read(address), Ok(DatabaseAddress::Postgres(address.to_owned())));
        }
        for secret in ["postgres://me:secret@db/jobs", "postgres://db/jobs?password=secret"] {
            let message = read(secret).expect_err("holds a password").to_string();
            assert!(message.contains("PGPASSWORD") && !message.contains("secret@"), "{message}");
        }
        for unknown in ["", "sqlite://file", "mysql://db/jobs"] {
            assert_eq!(read(unknown), Err(DatabaseAddressError::Unknown));
        }
    }
}
