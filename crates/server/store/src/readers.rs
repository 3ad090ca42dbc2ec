//! Connections that read. On PostgreSQL every read has a limit, also where the server cannot keep one, as it is frozen
//! or cut off: the connection is closed then, and the read fails as an outage.
//!
//! `&Readers` runs one statement, as a pool does. Several statements take a connection ([`Readers::acquire`]) inside
//! [`Readers::within_limit`]. [`Readers::unhurried`] gives statements that read much a longer limit, and a transaction
//! of their own.

use std::fmt;
use std::io;
use std::ops::{Deref, DerefMut};
use std::time::Duration;

use futures::future::BoxFuture;
use futures::stream::BoxStream;
use futures::{StreamExt, TryStreamExt, stream};
use sqlx::any::{Any, AnyQueryResult, AnyRow, AnyStatement, AnyTypeInfo};
use sqlx::pool::PoolConnection;
use sqlx::{AnyConnection, AnyPool, AssertSqlSafe, Either, Execute, Executor, SqlStr};
use tokio::time::Instant;

use super::database::Dialect;
use super::settings::Limits;
use super::{StoreError, database};

/// The connections of a process that read; cloning shares them.
#[derive(Clone)]
pub(crate) struct Readers {
    pool: AnyPool,
    /// `None` in a SQLite file, which answers or fails by itself.
    limits: Option<Limits>,
    unhurried: Option<Limits>,
}

/// A connection out of the pool. One whose limit has passed is closed instead of given back.
pub(crate) struct ReadConnection {
    /// Empty only while it is dropped.
    connection: Option<PoolConnection<Any>>,
    until: Option<Instant>,
}

impl Readers {
    /// Connections to a SQLite file.
    pub(crate) fn of_file(pool: AnyPool) -> Self {
        Self { pool, limits: None, unhurried: None }
    }

    /// Connections to PostgreSQL with the limits of a usual read, and of one that takes long.
    pub(crate) fn limited(pool: AnyPool, usual: Limits, unhurried: Limits) -> Self {
        Self { pool, limits: Some(usual), unhurried: Some(unhurried) }
    }

    /// The database that they read.
    pub(crate) fn dialect(&self) -> Dialect {
        if self.limits.is_some() { Dialect::Postgres } else { Dialect::Sqlite }
    }

    /// The same connections, for statements that may take long.
    pub(crate) fn unhurried(&self) -> Self {
        Self { limits: self.unhurried, ..self.clone() }
    }

    /// A connection for several statements; [`Self::within_limit`] bounds what is done with it.
    pub(crate) async fn acquire(&self) -> Result<ReadConnection, sqlx::Error> {
        let connection = self.pool.acquire().await?;
        let until = self.limits.map(|limits| Instant::now() + limits.answer);
        Ok(ReadConnection { connection: Some(connection), until })
    }

    /// Runs reads that belong together, at most for the limit of one.
    pub(crate) async fn within_limit<T>(
        &self,
        reads: impl Future<Output = Result<T, StoreError>>,
    ) -> Result<T, StoreError> {
        let Some(limits) = self.limits else { return reads.await };
        // A connection counts from its own begin, which is later: it is past its limit only when this one has passed.
        match tokio::time::timeout(limits.answer, reads).await {
            Ok(read) => read,
            Err(_) => Err(no_answer(limits.answer).into()),
        }
    }

    /// Milliseconds since 1970 by the database's clock.
    pub(crate) async fn now_ms(&self) -> Result<i64, StoreError> {
        self.within_limit(async { database::now_ms(&mut *self.acquire().await?).await }).await
    }

    /// Closes the pool.
    pub(crate) async fn close(&self) {
        self.pool.close().await;
    }

    /// Every step of a statement.
    async fn run<'q, E>(&self, query: E) -> Result<Vec<Either<AnyQueryResult, AnyRow>>, sqlx::Error>
    where
        E: Execute<'q, Any> + 'q,
    {
        let mut connection = self.pool.acquire().await?;
        let Some(limits) = self.limits else {
            return (&mut *connection).fetch_many(query).try_collect().await;
        };
        match tokio::time::timeout(limits.answer, steps(&mut connection, limits, query)).await {
            Ok(steps) => steps,
            Err(_) => {
                // Given back, it would wait for the server, and keep its place in the pool meanwhile.
                drop(connection.detach());
                Err(no_answer(limits.answer))
            }
        }
    }
}

async fn steps<'q, E>(
    connection: &mut AnyConnection,
    limits: Limits,
    query: E,
) -> Result<Vec<Either<AnyQueryResult, AnyRow>>, sqlx::Error>
where
    E: Execute<'q, Any> + 'q,
{
    let Some(limit) = limits.transaction() else { return connection.fetch_many(query).try_collect().await };
    let mut transaction = sqlx::Connection::begin(connection).await?;
    sqlx::raw_sql(AssertSqlSafe(limit)).execute(&mut *transaction).await?;
    let steps = (&mut *transaction).fetch_many(query).try_collect().await?;
    transaction.commit().await?;
    Ok(steps)
}

/// The error of a database that does not answer.
pub(crate) fn no_answer(limit: Duration) -> sqlx::Error {
    let message = format!(
        "no answer within {} ms; see whether the server runs, and what it waits for",
        limit.as_millis()
    );
    sqlx::Error::Io(io::Error::new(io::ErrorKind::TimedOut, message))
}

impl Deref for ReadConnection {
    type Target = AnyConnection;

    fn deref(&self) -> &AnyConnection {
        self.connection.as_ref().expect("it is taken only while it is dropped")
    }
}

impl DerefMut for ReadConnection {
    fn deref_mut(&mut self) -> &mut AnyConnection {
        self.connection.as_mut().expect("it is taken only while it is dropped")
    }
}

impl Drop for ReadConnection {
    fn drop(&mut self) {
        let is_late = self.until.is_some_and(|until| until <= Instant::now());
        if let Some(connection) = self.connection.take()
            && is_late
        {
            drop(connection.detach());
        }
    }
}

impl fmt::Debug for Readers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Readers").field("limits", &self.limits).finish_non_exhaustive()
    }
}

impl<'c> Executor<'c> for &Readers {
    type Database = Any;

    fn fetch_many<'e, 'q: 'e, E>(
        self,
        query: E,
    ) -> BoxStream<'e, Result<Either<AnyQueryResult, AnyRow>, sqlx::Error>>
    where
        'c: 'e,
        E: 'q + Execute<'q, Any>,
    {
        let readers = self.clone();
        let steps = async move { readers.run(query).await };
        stream::once(steps).map_ok(|steps| stream::iter(steps.into_iter().map(Ok))).try_flatten().boxed()
    }

    fn fetch_optional<'e, 'q: 'e, E>(self, query: E) -> BoxFuture<'e, Result<Option<AnyRow>, sqlx::Error>>
    where
        'c: 'e,
        E: 'q + Execute<'q, Any>,
    {
        let readers = self.clone();
        Box::pin(async move {
            let steps = readers.run(query).await?;
            Ok(steps.into_iter().find_map(Either::right))
        })
    }

    fn prepare_with<'e>(
        self,
        sql: SqlStr,
        parameters: &'e [AnyTypeInfo],
    ) -> BoxFuture<'e, Result<AnyStatement, sqlx::Error>>
    where
        'c: 'e,
    {
        let pool = self.pool.clone();
        Box::pin(async move { pool.acquire().await?.prepare_with(sql, parameters).await })
    }
}
