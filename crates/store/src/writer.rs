//! The one writer: an actor on its own thread that owns the only connection that writes.
//!
//! A caller hands over an operation and waits for its answer; if the caller goes away the operation
//! still runs to its end, so no transaction is ever abandoned half way. Operations that wait together
//! are committed together (one `BEGIN IMMEDIATE`, a savepoint each), and answers go out only after the
//! commit. Its own thread keeps it alive while the rest of the program computes.

use std::path::Path;

use futures::future::BoxFuture;
use sqlx::SqliteConnection;
use tokio::sync::{mpsc, oneshot};

use super::outage::{Health, Part};
use super::{Outage, Settings, StoreError, database};

/// Most operations in one transaction.
const GROUP: usize = 64;

/// Handle on the writer; cloning shares it.
#[derive(Clone)]
pub(super) struct Writer {
    operations: mpsc::Sender<Box<dyn Operation>>,
    health: Health,
}

/// Called after the commit, with why it failed if it did.
type Deliver = Box<dyn FnOnce(Option<CommitFailure>) + Send>;

/// Why a transaction came to nothing.
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

/// Something to do inside a transaction.
trait Operation: Send {
    fn run<'c>(self: Box<Self>, connection: &'c mut SqliteConnection) -> BoxFuture<'c, Done>;

    /// Answers without running.
    fn refuse(self: Box<Self>, failure: CommitFailure);
}

struct Done {
    /// Why nothing of it is kept.
    failure: Option<CommitFailure>,
    deliver: Deliver,
}

struct Typed<F, T> {
    doing: &'static str,
    body: F,
    answer: oneshot::Sender<Result<T, StoreError>>,
}

impl<F, T> Operation for Typed<F, T>
where
    F: for<'c> FnOnce(&'c mut SqliteConnection) -> BoxFuture<'c, Result<T, StoreError>> + Send + 'static,
    T: Send + 'static,
{
    fn run<'c>(self: Box<Self>, connection: &'c mut SqliteConnection) -> BoxFuture<'c, Done> {
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
                // The caller may have gone; the work is done all the same.
                let _ = answer.send(result);
            });
            Done { failure, deliver }
        })
    }

    fn refuse(self: Box<Self>, CommitFailure { reason, outage }: CommitFailure) {
        let _ = self.answer.send(Err(StoreError::Commit { doing: self.doing, reason, outage }));
    }
}

impl Writer {
    /// Opens the connection, migrates, and starts the thread.
    pub(super) async fn start(path: &Path, settings: &Settings, health: Health) -> Result<Self, StoreError> {
        let (operations, queue) = mpsc::channel(1024);
        let (ready, opened) = oneshot::channel();
        let path = path.to_owned();
        let settings = settings.clone();
        let directory = path.clone();
        let thread_health = health.clone();
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
                    match database::writer(&path, &settings).await {
                        Ok(connection) => {
                            let _ = ready.send(Ok(()));
                            work(connection, queue, thread_health).await;
                        }
                        Err(error) => {
                            let _ = ready.send(Err(error));
                        }
                    }
                });
            })
            .map_err(|source| StoreError::DataDir { path: directory, source })?;
        opened.await.map_err(|_| StoreError::WriterStopped)??;
        Ok(Self { operations, health })
    }

    /// Runs `body` in a transaction; `Ok` means it is committed, `Err` that it changed nothing.
    pub(super) async fn write<T, F>(&self, doing: &'static str, body: F) -> Result<T, StoreError>
    where
        F: for<'c> FnOnce(&'c mut SqliteConnection) -> BoxFuture<'c, Result<T, StoreError>> + Send + 'static,
        T: Send + 'static,
    {
        let (answer, result) = oneshot::channel();
        self.operations
            .send(Box::new(Typed { doing, body, answer }))
            .await
            .map_err(|_| StoreError::WriterStopped)?;
        let result = result.await.unwrap_or(Err(StoreError::WriterStopped));
        if let Err(error) = &result {
            self.health.failed(Part::Database, error);
        }
        result
    }
}

async fn work(
    mut connection: SqliteConnection,
    mut queue: mpsc::Receiver<Box<dyn Operation>>,
    health: Health,
) {
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
                // Everybody who waits is told; an outage is reported once.
                if failure.outage.is_none() {
                    tracing::error!(reason = failure.reason, "a write transaction failed");
                }
                // Leaves no transaction open for the next group; fails harmlessly if there is none.
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

/// One transaction: the first operation and whatever waits behind it. With `probe` it surely writes:
/// looking at an empty queue changes nothing, and would prove nothing about a full disk.
async fn group(
    connection: &mut SqliteConnection,
    first: Box<dyn Operation>,
    queue: &mut mpsc::Receiver<Box<dyn Operation>>,
    deliveries: &mut Vec<Deliver>,
    probe: bool,
) -> Result<(), CommitFailure> {
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
            // On a full disk SQLite has rolled everything back already, and there is no savepoint any more.
            if sqlx::query("ROLLBACK TO operation").execute(&mut *connection).await.is_err() {
                return Err(failure);
            }
        }
        sqlx::query("RELEASE operation").execute(&mut *connection).await?;
        next = if deliveries.len() < GROUP { queue.try_recv().ok() } else { None };
    }
    if probe {
        sqlx::raw_sql("CREATE TABLE write_probe (x); DROP TABLE write_probe")
            .execute(&mut *connection)
            .await?;
    }
    sqlx::query("COMMIT").execute(&mut *connection).await?;
    Ok(())
}
