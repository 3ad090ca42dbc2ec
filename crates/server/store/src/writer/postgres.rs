//! Writes to PostgreSQL: one transaction per operation, on a connection of the pool.
//!
//! Transactions are READ COMMITTED. An operation locks the row of the job or scene that it decides about, so two
//! processes never decide about the same row at once. What collides all the same (a deadlock, the same idempotency key
//! inserted twice) is rolled back by the database and repeated here. No transaction is without a limit: the session
//! limits statements, locks and silence, and this process waits no longer than [`Limits::answer`] for a server that is
//! frozen or cut off.

use std::time::Duration;

use futures::future::BoxFuture;
use sqlx::{AnyConnection, AnyPool, AssertSqlSafe, Connection};

use crate::StoreError;
use crate::outage::{Health, Part};
use crate::readers::no_answer;
use crate::settings::Limits;

/// Maximum number of runs of a transaction that collides.
const MAX_RUNS: u32 = 10;

/// Handle on the pool; cloning shares it.
#[derive(Clone)]
pub(super) struct PostgresWriter {
    pool: AnyPool,
    limits: Limits,
    unhurried: Limits,
    health: Health,
}

impl PostgresWriter {
    pub(super) fn new(pool: AnyPool, limits: Limits, unhurried: Limits, health: Health) -> Self {
        Self { pool, limits, unhurried, health }
    }

    /// The same, for transactions that may take long.
    pub(super) fn unhurried(&self) -> Self {
        Self { limits: self.unhurried, ..self.clone() }
    }

    /// Runs `body` in a transaction of its own, in a task of its own.
    pub(super) async fn write<T, F>(&self, doing: &'static str, body: F) -> Result<T, StoreError>
    where
        F: for<'c> FnOnce(&'c mut AnyConnection) -> BoxFuture<'c, Result<T, StoreError>>
            + Clone
            + Send
            + 'static,
        T: Send + 'static,
    {
        let (pool, limits) = (self.pool.clone(), self.limits);
        let result = tokio::spawn(async move {
            let mut run = 1;
            loop {
                match transaction(&pool, limits, doing, body.clone()).await {
                    Err(error) if run < MAX_RUNS && error.is_collision() => {
                        metrics::counter!("tabletopgen_store_write_repeats_total").increment(1);
                        tokio::time::sleep(pause(run)).await;
                        run += 1;
                    }
                    result => return result,
                }
            }
        })
        .await
        .unwrap_or(Err(StoreError::WriterStopped));
        if result.is_ok() {
            self.health.succeeded(Part::Database);
        }
        result
    }
}

async fn transaction<T, F>(
    pool: &AnyPool,
    limits: Limits,
    doing: &'static str,
    body: F,
) -> Result<T, StoreError>
where
    F: for<'c> FnOnce(&'c mut AnyConnection) -> BoxFuture<'c, Result<T, StoreError>>,
{
    let failed = |source| StoreError::Sql { doing, source };
    let mut connection = pool.acquire().await.map_err(failed)?;
    match tokio::time::timeout(limits.answer, committed(&mut connection, limits, body)).await {
        Ok(result) => result.map_err(|error| error.while_doing(doing)),
        Err(_) => {
            // The server does not answer. Given back, the connection would wait for it; closed, it is rolled back.
            drop(connection.detach());
            Err(failed(no_answer(limits.answer)))
        }
    }
}

async fn committed<T, F>(connection: &mut AnyConnection, limits: Limits, body: F) -> Result<T, StoreError>
where
    F: for<'c> FnOnce(&'c mut AnyConnection) -> BoxFuture<'c, Result<T, StoreError>>,
{
    let mut transaction = connection.begin().await?;
    if let Some(limit) = limits.transaction() {
        sqlx::raw_sql(AssertSqlSafe(limit)).execute(&mut *transaction).await?;
    }
    match body(&mut transaction).await {
        Ok(value) => {
            transaction.commit().await?;
            Ok(value)
        }
        Err(error) => {
            // A connection that cannot roll back is closed, which rolls back too.
            let _ = transaction.rollback().await;
            Err(error)
        }
    }
}

/// The pause before a repetition: it doubles, with jitter, so that those that collided part.
fn pause(run: u32) -> Duration {
    let longest_ms = 5_u128 << run.min(6);
    let jitter = uuid::Uuid::new_v4().as_u128() % longest_ms;
    Duration::from_millis(u64::try_from(jitter).unwrap_or(0) + 1)
}
