//! Connections to the database: a SQLite file or PostgreSQL, behind sqlx's `Any` driver.
//!
//! One set of queries serves both. [`Dialect`] has the few texts that differ.

use std::path::Path;
use std::str::FromStr;
use std::time::Duration;

use sqlx::any::{AnyConnectOptions, AnyPoolOptions, AnyRow};
use sqlx::sqlite::{
    SqliteAutoVacuum, SqliteConnectOptions, SqliteConnection, SqliteJournalMode, SqliteSynchronous,
};
use sqlx::{AnyConnection, AssertSqlSafe, Connection, Row};

use super::readers::Readers;
use super::{DatabaseAddress, Settings, StoreError, migrations, postgres, private_files};
use scene::id::InvalidId;

/// The write-ahead log of SQLite shrinks to this after a burst of writes.
const MAX_IDLE_LOG_BYTES: u32 = 16 << 20;

/// The database behind a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dialect {
    Sqlite,
    Postgres,
}

impl Dialect {
    /// The database of a connection.
    pub(super) fn of(connection: &AnyConnection) -> Self {
        match connection.backend_name() {
            "SQLite" => Self::Sqlite,
            _ => Self::Postgres,
        }
    }

    /// Milliseconds since 1970 by the database's clock, as an expression.
    pub(super) fn now_ms(self) -> &'static str {
        match self {
            Self::Sqlite => "CAST(unixepoch('subsec') * 1000 AS INTEGER)",
            Self::Postgres => "CAST(EXTRACT(EPOCH FROM clock_timestamp()) * 1000 AS BIGINT)",
        }
    }

    /// Locks the rows of a `SELECT` until the end of the transaction. SQLite has one writer, so nothing is needed.
    pub(super) fn lock(self) -> &'static str {
        match self {
            Self::Sqlite => "",
            Self::Postgres => "FOR UPDATE",
        }
    }

    /// The same; rows that another transaction has locked are passed over.
    pub(super) fn lock_free_rows(self) -> &'static str {
        match self {
            Self::Sqlite => "",
            Self::Postgres => "FOR UPDATE SKIP LOCKED",
        }
    }

    /// Compares a text with a pattern in upper or lower case. SQLite knows the case of ASCII letters alone.
    pub(super) fn like_any_case(self) -> &'static str {
        match self {
            Self::Sqlite => "LIKE",
            Self::Postgres => "ILIKE",
        }
    }

    /// Joins the next table to the rows of the one before, in their order. PostgreSQL knows by its statistics.
    pub(super) fn join_to_first(self) -> &'static str {
        match self {
            Self::Sqlite => "CROSS JOIN",
            Self::Postgres => "JOIN",
        }
    }
}

/// SQLite's options of both kinds of connection.
fn sqlite_options(path: &Path, settings: &Settings) -> SqliteConnectOptions {
    SqliteConnectOptions::new()
        .filename(path)
        .create_if_missing(true)
        // Only a new file takes it; sweeps then give free pages back to the file system.
        .auto_vacuum(SqliteAutoVacuum::Incremental)
        .journal_mode(SqliteJournalMode::Wal)
        .synchronous(if settings.fsync { SqliteSynchronous::Full } else { SqliteSynchronous::Off })
        .busy_timeout(Duration::from_millis(settings.busy_timeout_ms))
}

/// The same as statements; the `Any` driver takes only an address. The journal mode stays with the file.
fn pragmas(settings: &Settings) -> String {
    let synchronous = if settings.fsync { "FULL" } else { "OFF" };
    format!(
        "PRAGMA busy_timeout = {}; PRAGMA synchronous = {synchronous}; PRAGMA foreign_keys = ON; \
         PRAGMA journal_size_limit = {MAX_IDLE_LOG_BYTES}",
        settings.busy_timeout_ms
    )
}

/// Address of a SQLite file.
fn sqlite_address(path: &Path, mode: &str) -> Result<AnyConnectOptions, StoreError> {
    let absolute =
        std::path::absolute(path).map_err(|source| StoreError::DataDir { path: path.to_owned(), source })?;
    let escaped: String = absolute
        .to_string_lossy()
        .chars()
        .map(|character| match character {
            '%' | '?' | '#' => format!("%{:02X}", u32::from(character)),
            other => other.to_string(),
        })
        .collect();
    AnyConnectOptions::from_str(&format!("sqlite://{escaped}?mode={mode}"))
        .map_err(|source| StoreError::Sql { doing: "open", source })
}

/// Migrates the SQLite file and opens the writing connection.
pub(super) async fn sqlite_writer(path: &Path, settings: &Settings) -> Result<AnyConnection, StoreError> {
    sqlx::any::install_default_drivers();
    private(path)?;
    let opened = |source| StoreError::Sql { doing: "open", source };
    let mut direct = SqliteConnection::connect_with(&sqlite_options(path, settings)).await.map_err(opened)?;
    migrations::SQLITE.run_direct(None, &mut direct, false).await?;
    direct.close().await.map_err(opened)?;
    let mut connection = AnyConnection::connect_with(&sqlite_address(path, "rw")?).await.map_err(opened)?;
    sqlx::raw_sql(AssertSqlSafe(pragmas(settings))).execute(&mut connection).await.map_err(opened)?;
    Ok(connection)
}

/// Makes the file private, which is created if it is missing; SQLite gives its mode to the files beside it.
fn private(path: &Path) -> Result<(), StoreError> {
    let failed = |source| StoreError::DataDir { path: path.to_owned(), source };
    drop(private_files::file(path).map_err(failed)?);
    for suffix in ["-wal", "-shm"] {
        let mut beside = path.as_os_str().to_owned();
        beside.push(suffix);
        match private_files::closed(Path::new(&beside)) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            closed => drop(closed.map_err(failed)?),
        }
    }
    Ok(())
}

/// Opens the connections that read the SQLite file.
pub(super) async fn sqlite_readers(path: &Path, settings: &Settings) -> Result<Readers, StoreError> {
    let pragmas = pragmas(settings);
    AnyPoolOptions::new()
        .max_connections(settings.readers.clamp(1, 64))
        .after_connect(move |connection, _| {
            let pragmas = pragmas.clone();
            Box::pin(async move {
                sqlx::raw_sql(AssertSqlSafe(pragmas)).execute(connection).await?;
                Ok(())
            })
        })
        .connect_with(sqlite_address(path, "ro")?)
        .await
        .map(Readers::of_file)
        .map_err(|source| StoreError::Sql { doing: "open for reading", source })
}

/// Fails with [`StoreError::NoDatabase`] unless the file of a SQLite database is there.
pub(super) fn sqlite_exists(path: &Path) -> Result<(), StoreError> {
    match std::fs::metadata(path) {
        Ok(about) if about.len() > 0 => Ok(()),
        Ok(_) => Err(StoreError::no_database(&path.display().to_string(), "a file that is not empty")),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let folder = path.parent().unwrap_or(path);
            let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
            Err(StoreError::no_database(&folder.display().to_string(), super::backup::DATABASE_FILE))
        }
        Err(source) => Err(StoreError::DataDir { path: path.to_owned(), source }),
    }
}

/// A connection beside the processes that use the database, without its lock and without migrations.
pub(super) async fn bystander(data_dir: &Path, settings: &Settings) -> Result<AnyConnection, StoreError> {
    sqlx::any::install_default_drivers();
    let opened = |source| StoreError::Sql { doing: "open", source };
    let DatabaseAddress::Postgres(url) = &settings.database else {
        let path = data_dir.join(super::backup::DATABASE_FILE);
        sqlite_exists(&path)?;
        let mut connection =
            AnyConnection::connect_with(&sqlite_address(&path, "rw")?).await.map_err(opened)?;
        sqlx::raw_sql(AssertSqlSafe(pragmas(settings))).execute(&mut connection).await.map_err(opened)?;
        return Ok(connection);
    };
    postgres::session(url, settings).await
}

/// Milliseconds since 1970 by the database's clock.
pub(super) async fn now_ms(connection: &mut AnyConnection) -> Result<i64, StoreError> {
    let query = format!("SELECT {}", Dialect::of(connection).now_ms());
    Ok(sqlx::query_scalar(AssertSqlSafe(query)).fetch_one(connection).await?)
}

/// The id in a column of a row of `table`.
pub(super) fn id<T>(row: &AnyRow, table: &'static str, column: &str) -> Result<T, StoreError>
where
    T: FromStr<Err = InvalidId>,
{
    parse_id(&row.try_get::<String, _>(column)?, table)
}

/// As [`id`], for a column that may be NULL.
pub(super) fn optional_id<T>(row: &AnyRow, table: &'static str, column: &str) -> Result<Option<T>, StoreError>
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
