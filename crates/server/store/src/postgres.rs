//! The driver of PostgreSQL: migrations, connections, notifications, and its errors.

use std::str::FromStr;
use std::time::Duration;

use sqlx::any::{AnyConnectOptions, AnyPoolOptions};
use sqlx::error::DatabaseError;
use sqlx::postgres::{PgConnectOptions, PgConnection, PgDatabaseError, PgListener};
use sqlx::{AnyConnection, AnyPool, AssertSqlSafe, Connection};

use super::readers::no_answer;
use super::{Intent, Settings, StoreError, migrations};

/// A connection that rested longer is tested before its next use; a test costs a round trip.
const UNTESTED: Duration = Duration::from_secs(1);

/// Migrates a PostgreSQL database, one process at a time, and opens the pool of this process.
pub(super) async fn pool(url: &str, settings: &Settings, intent: Intent) -> Result<AnyPool, StoreError> {
    sqlx::any::install_default_drivers();
    let opened = |source| StoreError::Sql { doing: "open", source };
    let options = PgConnectOptions::from_str(url).map_err(opened)?;
    let limits = &settings.postgres;
    let mut direct = in_time(limits.acquire_timeout(), PgConnection::connect_with(&options)).await?;
    if intent == Intent::Existing {
        let versions = sqlx::query_scalar("SELECT CAST(to_regclass('_sqlx_migrations') AS TEXT)");
        let found: Option<String> = in_time(limits.prompt().answer, versions.fetch_one(&mut direct)).await?;
        if found.is_none() {
            return Err(StoreError::no_database(url, "the table _sqlx_migrations"));
        }
    }
    let long = limits.long_timeout();
    let limit = format!("SET statement_timeout = {0}; SET lock_timeout = {0}", long.as_millis());
    in_time(limits.prompt().answer, sqlx::raw_sql(AssertSqlSafe(limit)).execute(&mut direct)).await?;
    match tokio::time::timeout(long, migrations::POSTGRES.run(&mut direct)).await {
        Ok(migrated) => migrated?,
        Err(_) => return Err(opened(no_answer(long))),
    }
    in_time(limits.acquire_timeout(), direct.close()).await?;
    let session = limits.session();
    let pool = AnyPoolOptions::new()
        .max_connections(settings.connections.clamp(2, 256))
        .acquire_timeout(limits.acquire_timeout())
        .test_before_acquire(false)
        .after_connect(move |connection, _| {
            let session = session.clone();
            Box::pin(async move {
                sqlx::raw_sql(AssertSqlSafe(session)).execute(connection).await?;
                Ok(())
            })
        })
        .before_acquire(|connection, metadata| {
            Box::pin(async move {
                if metadata.idle_for > UNTESTED {
                    connection.ping().await?;
                }
                Ok(true)
            })
        });
    pool.connect_with(AnyConnectOptions::from_str(url).map_err(opened)?).await.map_err(opened)
}

/// The answer of a server that may be frozen or cut off.
async fn in_time<T>(
    limit: Duration,
    answer: impl Future<Output = Result<T, sqlx::Error>>,
) -> Result<T, StoreError> {
    let answered = tokio::time::timeout(limit, answer).await.unwrap_or_else(|_| Err(no_answer(limit)));
    answered.map_err(|source| StoreError::Sql { doing: "open", source })
}

/// A connection beside those of the pool, with the limits of a session.
pub(super) async fn session(url: &str, settings: &Settings) -> Result<AnyConnection, StoreError> {
    let opened = |source| StoreError::Sql { doing: "open", source };
    let limits = &settings.postgres;
    let address = AnyConnectOptions::from_str(url).map_err(opened)?;
    let mut connection = in_time(limits.acquire_timeout(), AnyConnection::connect_with(&address)).await?;
    let session = sqlx::raw_sql(AssertSqlSafe(limits.session()));
    in_time(limits.prompt().answer, session.execute(&mut connection)).await?;
    Ok(connection)
}

/// Whether an error is one of the server's.
pub(super) fn is_error(error: &dyn DatabaseError) -> bool {
    error.try_downcast_ref::<PgDatabaseError>().is_some()
}

/// A connection that hears notifications.
pub(super) struct Listener(PgListener);

impl Listener {
    /// Connects within the limit.
    pub(super) async fn connect(url: &str, limit: Duration) -> Result<Self, StoreError> {
        let connected = tokio::time::timeout(limit, PgListener::connect(url)).await;
        let connected = connected.unwrap_or_else(|_| Err(no_answer(limit)));
        connected.map(Self).map_err(|source| StoreError::Sql { doing: "listen for changes", source })
    }

    /// Begins to hear a channel.
    pub(super) async fn listen(&mut self, channel: &str) -> Result<(), sqlx::Error> {
        self.0.listen(channel).await
    }

    /// The text of the next notification; `None` where the connection broke.
    pub(super) async fn heard(&mut self) -> Result<Option<String>, sqlx::Error> {
        Ok(self.0.try_recv().await?.map(|notification| notification.payload().to_owned()))
    }
}
