//! Transactions that write, on either database.
//!
//! SQLite has one writing connection, and waiting operations are committed as a group ([`sqlite`]). PostgreSQL runs
//! the transactions of many processes side by side and repeats those that collide ([`postgres`]). In both, an
//! operation runs to its end even if the caller is dropped, so no transaction is left half done.

mod sqlite;
mod postgres;

use std::path::Path;
use std::time::Instant;

use futures::future::BoxFuture;
use sqlx::{AnyConnection, AnyPool};

use super::outage::{Health, Part};
use super::settings::Limits;
use super::{Settings, StoreError};

use postgres::PostgresWriter;
use sqlite::SqliteWriter;

/// Handle on the writing side of the database; cloning shares it.
#[derive(Clone)]
pub(super) struct Writer {
    database: Database,
    health: Health,
}

#[derive(Clone)]
enum Database {
    Sqlite(SqliteWriter),
    Postgres(PostgresWriter),
}

impl Writer {
    /// Opens and migrates the file, and starts the thread that writes to it.
    pub(super) async fn sqlite(path: &Path, settings: &Settings, health: Health) -> Result<Self, StoreError> {
        let writer = SqliteWriter::start(path, settings, health.clone()).await?;
        Ok(Self { database: Database::Sqlite(writer), health })
    }

    /// A writer on the pool of a database that is migrated already, with the limits of a usual transaction, and of one
    /// that takes long.
    pub(super) fn postgres(pool: AnyPool, usual: Limits, unhurried: Limits, health: Health) -> Self {
        let writer = PostgresWriter::new(pool, usual, unhurried, health.clone());
        Self { database: Database::Postgres(writer), health }
    }

    /// The same writer, for transactions that may take long. SQLite has one writer, which others wait for: there,
    /// transactions are kept small instead.
    pub(super) fn unhurried(&self) -> Self {
        let database = match &self.database {
            Database::Sqlite(writer) => Database::Sqlite(writer.clone()),
            Database::Postgres(writer) => Database::Postgres(writer.unhurried()),
        };
        Self { database, health: self.health.clone() }
    }

    /// Runs `body` in a transaction; `Ok` means it is committed, `Err` that it changed nothing. `body` runs again if
    /// its transaction collides with that of another process.
    pub(super) async fn write<T, F>(&self, doing: &'static str, body: F) -> Result<T, StoreError>
    where
        F: for<'c> FnOnce(&'c mut AnyConnection) -> BoxFuture<'c, Result<T, StoreError>>
            + Clone
            + Send
            + 'static,
        T: Send + 'static,
    {
        let started = Instant::now();
        let result = match &self.database {
            Database::Sqlite(writer) => writer.write(doing, body).await,
            Database::Postgres(writer) => writer.write(doing, body).await,
        };
        metrics::histogram!("tabletopgen_store_write_seconds").record(started.elapsed().as_secs_f64());
        if let Err(error) = &result {
            // A lost lease or an unknown row is an answer, not a failure of the store.
            if matches!(error, StoreError::Sql { .. } | StoreError::Commit { .. } | StoreError::WriterStopped)
            {
                metrics::counter!("tabletopgen_store_write_failures_total").increment(1);
            }
            self.health.failed(Part::Database, error);
        }
        result
    }
}
