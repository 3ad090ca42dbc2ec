//! Connections to the SQLite file: WAL, foreign keys, a busy timeout, and FULL synchronization unless the settings
//! disable it.

use std::path::Path;
use std::str::FromStr;
use std::time::Duration;

use sqlx::sqlite::{
    SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteRow, SqliteSynchronous,
};
use sqlx::{Connection, Row, SqliteConnection, SqlitePool};

use super::{Settings, StoreError};
use scene::id::InvalidId;

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

/// Opens the writing connection and migrates the schema.
pub(super) async fn writer(path: &Path, settings: &Settings) -> Result<SqliteConnection, StoreError> {
    let mut connection = SqliteConnection::connect_with(&options(path, settings))
        .await
        .map_err(|source| StoreError::Sql { doing: "open", source })?;
    MIGRATIONS.run_direct(None, &mut connection, false).await?;
    Ok(connection)
}

/// Opens the read connections.
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

/// The id in a column of a row of `table`.
pub(super) fn id<T>(row: &SqliteRow, table: &'static str, column: &str) -> Result<T, StoreError>
where
    T: FromStr<Err = InvalidId>,
{
    parse_id(&row.try_get::<String, _>(column)?, table)
}

/// As [`id`], for a column that may be NULL.
pub(super) fn optional_id<T>(
    row: &SqliteRow,
    table: &'static str,
    column: &str,
) -> Result<Option<T>, StoreError>
where
    T: FromStr<Err = InvalidId>,
{
    let text: Option<String> = row.try_get(column)?;
    text.map(|text| parse_id(&text, table)).transpose()
}

/// An id that was read from `table`.
pub(super) fn parse_id<T>(text: &str, table: &'static str) -> Result<T, StoreError>
where
    T: FromStr<Err = InvalidId>,
{
    text.parse().map_err(|error: InvalidId| StoreError::Corrupt { table, reason: error.to_string() })
}
