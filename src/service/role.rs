//! Role of a process: the HTTP interface, jobs, or both.
//!
//! Processes with separate roles work on one database and one blob store. Combinations in which they could not see each
//! other's rows or blobs are refused before anything starts.

use clap::ValueEnum;

use crate::config::Config;
use store::{BlobPlace, DatabaseAddress};

/// The duties of one process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Role {
    /// HTTP interface and worker
    All,
    /// HTTP interface only
    Api,
    /// Worker only, with probes and metrics
    Worker,
}

impl Role {
    pub fn as_str(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Api => "api",
            Self::Worker => "worker",
        }
    }

    /// Refuses a role that the configured storage cannot support.
    ///
    /// # Errors
    ///
    /// [`UnsafeRole`] with the reason and the remedy.
    pub fn check(self, config: &Config) -> Result<(), UnsafeRole> {
        let refuse = |reason, remedy| Err(UnsafeRole { role: self, reason, remedy });
        match self {
            Self::All => Ok(()),
            _ if config.store.database == DatabaseAddress::Sqlite => refuse(
                "the database is a SQLite file, which one process at a time may use",
                "set store.database to a PostgreSQL address, or use --role all",
            ),
            _ if config.store.blobs != BlobPlace::S3 => refuse(
                "blobs are kept on this machine, where the other processes do not find them",
                "set store.blobs = s3 with a bucket in store.s3, or use --role all",
            ),
            _ => Ok(()),
        }
    }
}

/// A role that the configured storage cannot support.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("--role {role} is not possible: {reason}; {remedy}", role = role.as_str())]
pub struct UnsafeRole {
    pub role: Role,
    pub reason: &'static str,
    pub remedy: &'static str,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Sources, layers};

    fn refusal(role: Role, database: &str, blobs: &str) -> Option<String> {
        let set = [("store.database", database), ("store.blobs", blobs), ("store.s3.bucket", "scenes")];
        let arguments = set.map(|(key, value)| (key.to_owned(), value.to_owned(), "--set")).to_vec();
        let resolved = layers::load(Sources { arguments, ..Sources::default() }).expect("valid");
        role.check(&resolved.config).err().map(|refusal| refusal.to_string())
    }

    #[test]
    fn separate_roles_need_a_shared_database_and_shared_blobs() {
        let postgres = "postgres://jobs@db/jobs";
        for role in [Role::Api, Role::Worker] {
            let message = refusal(role, "sqlite", "s3").expect("is refused");
            assert!(message.contains("SQLite file") && message.contains("store.database"), "{message}");
            for blobs in ["files", "memory"] {
                let message = refusal(role, postgres, blobs).expect("is refused");
                assert!(message.contains("on this machine") && message.contains("store.blobs"), "{message}");
            }
            assert_eq!(refusal(role, postgres, "s3"), None);
        }
        for (database, blobs) in [("sqlite", "files"), ("sqlite", "s3"), (postgres, "files")] {
            assert_eq!(refusal(Role::All, database, blobs), None);
        }
    }
}
