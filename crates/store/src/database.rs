//! Connections to the SQLite file: WAL, foreign keys, a busy timeout, and FULL synchronization unless
//! the settings waive it.

use std::path::Path;
use std::time::Duration;

use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{Connection, SqliteConnection, SqlitePool};

use super::{Settings, StoreError};

static MIGRATIONS: sqlx::migrate::Migrator = sqlx::migrate!("../../migrations/sqlite");

fn options(path: &Path, settings: &Settings) -> SqliteConnectOptions {
    let synchronous = if settings.fsync { SqliteSynchronous::Full } else { SqliteSynchronous::Off };
    SqliteConnectOptions::new()
        .filename(path)
        .create_if_missing(true)
        .journal_mode(SqliteJournalMode::Wal)
        .synchronous(synchronous)
        .foreign_keys(true)
        .busy_timeout(Duration::from_millis(settings.busy_timeout_ms))
}

/// The one connection that writes, with the schema brought up to date.
pub(super) async fn writer(path: &Path, settings: &Settings) -> Result<SqliteConnection, StoreError> {
    let mut connection = SqliteConnection::connect_with(&options(path, settings))
        .await
        .map_err(|source| StoreError::Sql { doing: "open", source })?;
    MIGRATIONS.run_direct(None, &mut connection, false).await?;
    Ok(connection)
}

/// The connections that read.
pub(super) async fn readers(path: &Path, settings: &Settings) -> Result<SqlitePool, StoreError> {
    SqlitePoolOptions::new()
        .max_connections(settings.readers.clamp(1, 64))
        .connect_with(options(path, settings).read_only(true))
        .await
        .map_err(|source| StoreError::Sql { doing: "open for reading", source })
}

/// Milliseconds since 1970 by the database's clock.
pub(super) async fn now_ms(connection: &mut SqliteConnection) -> Result<i64, StoreError> {
    let now = sqlx::query_scalar("SELECT CAST(unixepoch('subsec') * 1000 AS INTEGER)")
        .fetch_one(connection)
        .await?;
    Ok(now)
}
