//! Writes to SQLite: an actor on its own thread that owns the only writing connection.
//!
//! A caller submits an operation and waits for its result. An operation runs to its end even if the caller is dropped,
//! so no transaction is left half done. Waiting operations are committed as a group (one `BEGIN IMMEDIATE`, one
//! savepoint per operation), and results are delivered after the commit. The own thread keeps the writer
//! responsive while the runtime's threads compute.

use std::path::Path;
use std::time::{Duration, Instant};

use futures::future::BoxFuture;
use sqlx::AnyConnection;
use tokio::sync::{mpsc, oneshot};

use crate::outage::{Health, Part};
use crate::{Outage, Settings, StoreError, database};

/// Maximum number of operations in one transaction.
const MAX_GROUP: usize = 64;

/// A transaction takes no further operation after this long: the first ones wait for its commit.
const MAX_GROUP_TIME: Duration = Duration::from_millis(5);

/// Handle on the actor; cloning shares it.
#[derive(Clone)]
pub(super) struct SqliteWriter {
    operations: mpsc::Sender<Box<dyn Operation>>,
}

/// Called after the commit, with the failure of the commit if there was one.
type Deliver = Box<dyn FnOnce(Option<CommitFailure>) + Send>;

/// Reason why a transaction failed.
#[derive(Clone)]
struct CommitFailure {
    reason: String,
    outage: Option<Outage>,
}

impl From<sqlx::Error> for CommitFailure {
    fn from(error: sqlx::Error) -> Self {
        StoreError::from(error).into()
    }
}

impl From<StoreError> for CommitFailure {
    fn from(error: StoreError) -> Self {
        Self { reason: error.chain(), outage: error.outage() }
    }
}

/// An operation inside a transaction.
trait Operation: Send {
    fn run<'c>(self: Box<Self>, connection: &'c mut AnyConnection) -> BoxFuture<'c, Execution>;

    /// Delivers the failure without running.
    fn refuse(self: Box<Self>, failure: CommitFailure);
}

struct Execution {
    /// The reason for the rollback of the operation, if it failed.
    failure: Option<CommitFailure>,
    deliver: Deliver,
}

struct TypedOperation<F, T> {
    doing: &'static str,
    body: F,
    answer: oneshot::Sender<Result<T, StoreError>>,
}

impl<F, T> Operation for TypedOperation<F, T>
where
    F: for<'c> FnOnce(&'c mut AnyConnection) -> BoxFuture<'c, Result<T, StoreError>> + Send + 'static,
    T: Send + 'static,
{
    fn run<'c>(self: Box<Self>, connection: &'c mut AnyConnection) -> BoxFuture<'c, Execution> {
        Box::pin(async move {
            let Self { doing, body, answer } = *self;
            let result = body(connection).await.map_err(|error| error.while_doing(doing));
            let failure = result
                .as_ref()
                .err()
                .map(|error| CommitFailure { reason: error.chain(), outage: error.outage() });
            let deliver: Deliver = Box::new(move |commit_failure| {
                let result = match (result, commit_failure) {
                    (Ok(_), Some(CommitFailure { reason, outage })) => {
                        Err(StoreError::Commit { doing, reason, outage })
                    }
                    (result, _) => result,
                };
                // The caller may have been dropped; the operation is still complete.
                let _ = answer.send(result);
            });
            Execution { failure, deliver }
        })
    }

    fn refuse(self: Box<Self>, CommitFailure { reason, outage }: CommitFailure) {
        let _ = self.answer.send(Err(StoreError::Commit { doing: self.doing, reason, outage }));
    }
}

impl SqliteWriter {
    /// Opens the connection, migrates, and starts the thread.
    pub(super) async fn start(path: &Path, settings: &Settings, health: Health) -> Result<Self, StoreError> {
        let (operations, queue) = mpsc::channel(1024);
        let (ready, opened) = oneshot::channel();
        let path = path.to_owned();
        let settings = settings.clone();
        let directory = path.clone();
        std::thread::Builder::new()
            .name("store-writer".into())
            .spawn(move || {
                let runtime = match tokio::runtime::Builder::new_current_thread().enable_all().build() {
                    Ok(runtime) => runtime,
                    Err(source) => {
                        let _ = ready.send(Err(StoreError::DataDir { path, source }));
                        return;
                    }
                };
                runtime.block_on(async move {
                    match database::sqlite_writer(&path, &settings).await {
                        Ok(connection) => {
                            let _ = ready.send(Ok(()));
                            work(connection, queue, health).await;
                        }
                        Err(error) => {
                            let _ = ready.send(Err(error));
                        }
                    }
                });
            })
            .map_err(|source| StoreError::DataDir { path: directory, source })?;
        opened.await.map_err(|_| StoreError::WriterStopped)??;
        Ok(Self { operations })
    }

    /// Runs `body` in a transaction of the group; the result comes after the commit.
    pub(super) async fn write<T, F>(&self, doing: &'static str, body: F) -> Result<T, StoreError>
    where
        F: for<'c> FnOnce(&'c mut AnyConnection) -> BoxFuture<'c, Result<T, StoreError>> + Send + 'static,
        T: Send + 'static,
    {
        let (answer, result) = oneshot::channel();
        self.operations
            .send(Box::new(TypedOperation { doing, body, answer }))
            .await
            .map_err(|_| StoreError::WriterStopped)?;
        result.await.unwrap_or(Err(StoreError::WriterStopped))
    }
}

async fn work(mut connection: AnyConnection, mut queue: mpsc::Receiver<Box<dyn Operation>>, health: Health) {
    while let Some(first) = queue.recv().await {
        let mut deliveries = Vec::new();
        let probe = health.is_failing(Part::Database);
        let commit_failure = match group(&mut connection, first, &mut queue, &mut deliveries, probe).await {
            Ok(()) => {
                if probe {
                    health.succeeded(Part::Database);
                }
                None
            }
            Err(failure) => {
                // All waiting callers receive the error; an outage is logged once.
                if failure.outage.is_none() {
                    tracing::error!(reason = failure.reason, "a write transaction failed");
                }
                // Closes the transaction before the next group; without one this fails harmlessly.
                let _ = sqlx::query("ROLLBACK").execute(&mut connection).await;
                Some(failure)
            }
        };
        for deliver in deliveries {
            deliver(commit_failure.clone());
        }
    }
    let _ = sqlx::Connection::close(connection).await;
}

/// Runs one transaction: the first operation and the operations waiting behind it. With `probe` the transaction always
/// writes, because operations without changes would succeed on a full disk.
async fn group(
    connection: &mut AnyConnection,
    first: Box<dyn Operation>,
    queue: &mut mpsc::Receiver<Box<dyn Operation>>,
    deliveries: &mut Vec<Deliver>,
    probe: bool,
) -> Result<(), CommitFailure> {
    let began = Instant::now();
    let mut next = Some(first);
    let mut before = "BEGIN IMMEDIATE; SAVEPOINT operation";
    while let Some(operation) = next {
        if let Err(error) = sqlx::raw_sql(before).execute(&mut *connection).await {
            let failure = CommitFailure::from(error);
            operation.refuse(failure.clone());
            return Err(failure);
        }
        before = "SAVEPOINT operation";
        let done = operation.run(connection).await;
        deliveries.push(done.deliver);
        if let Some(failure) = done.failure {
            // On a full disk SQLite has already rolled back everything, including the savepoint.
            if sqlx::query("ROLLBACK TO operation").execute(&mut *connection).await.is_err() {
                return Err(failure);
            }
        }
        sqlx::query("RELEASE operation").execute(&mut *connection).await?;
        let is_open = deliveries.len() < MAX_GROUP && began.elapsed() < MAX_GROUP_TIME;
        next = if is_open { queue.try_recv().ok() } else { None };
    }
    if probe {
        sqlx::raw_sql("CREATE TABLE write_probe (x); DROP TABLE write_probe")
            .execute(&mut *connection)
            .await?;
    }
    sqlx::query("COMMIT").execute(&mut *connection).await?;
    Ok(())
}
