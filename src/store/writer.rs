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

use super::{Settings, StoreError, database};

/// Most operations in one transaction.
const GROUP: usize = 64;

/// Handle on the writer; cloning shares it.
#[derive(Clone)]
pub(super) struct Writer {
    operations: mpsc::Sender<Box<dyn Operation>>,
}

/// Called after the commit, with why it failed if it did.
type Deliver = Box<dyn FnOnce(Option<String>) + Send>;

/// Something to do inside a transaction.
trait Operation: Send {
    fn run<'c>(self: Box<Self>, connection: &'c mut SqliteConnection) -> BoxFuture<'c, Done>;
}

struct Done {
    keep: bool,
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
            let keep = result.is_ok();
            let deliver: Deliver = Box::new(move |commit_failure| {
                let result = match (result, commit_failure) {
                    (Ok(_), Some(reason)) => Err(StoreError::Commit { doing, reason }),
                    (result, _) => result,
                };
                // The caller may have gone; the work is done all the same.
                let _ = answer.send(result);
            });
            Done { keep, deliver }
        })
    }
}

impl Writer {
    /// Opens the connection, migrates, and starts the thread.
    pub(super) async fn start(path: &Path, settings: &Settings) -> Result<Self, StoreError> {
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
                    match database::writer(&path, &settings).await {
                        Ok(connection) => {
                            let _ = ready.send(Ok(()));
                            work(connection, queue).await;
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
        result.await.map_err(|_| StoreError::WriterStopped)?
    }
}

async fn work(mut connection: SqliteConnection, mut queue: mpsc::Receiver<Box<dyn Operation>>) {
    while let Some(first) = queue.recv().await {
        let mut deliveries = Vec::new();
        let commit_failure = match group(&mut connection, first, &mut queue, &mut deliveries).await {
            Ok(()) => None,
            Err(error) => {
                tracing::error!(%error, "a write transaction failed");
                // Leaves no transaction open for the next group; fails harmlessly if there is none.
                let _ = sqlx::query("ROLLBACK").execute(&mut connection).await;
                Some(error.to_string())
            }
        };
        for deliver in deliveries {
            deliver(commit_failure.clone());
        }
    }
    let _ = sqlx::Connection::close(connection).await;
}

/// One transaction: the first operation and whatever waits behind it.
async fn group(
    connection: &mut SqliteConnection,
    first: Box<dyn Operation>,
    queue: &mut mpsc::Receiver<Box<dyn Operation>>,
    deliveries: &mut Vec<Deliver>,
) -> Result<(), sqlx::Error> {
    sqlx::query("BEGIN IMMEDIATE").execute(&mut *connection).await?;
    let mut next = Some(first);
    while let Some(operation) = next {
        sqlx::query("SAVEPOINT operation").execute(&mut *connection).await?;
        let done = operation.run(connection).await;
        deliveries.push(done.deliver);
        if !done.keep {
            sqlx::query("ROLLBACK TO operation").execute(&mut *connection).await?;
        }
        sqlx::query("RELEASE operation").execute(&mut *connection).await?;
        next = if deliveries.len() < GROUP { queue.try_recv().ok() } else { None };
    }
    sqlx::query("COMMIT").execute(&mut *connection).await?;
    Ok(())
}
