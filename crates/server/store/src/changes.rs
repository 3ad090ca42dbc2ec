//! Wake-ups: who waits for a change of a job need not poll.
//!
//! Inside a process a change ticks at once. With PostgreSQL, processes tell each other by `NOTIFY`, after the commit
//! and at most every few milliseconds, so that no commit waits for another one's notification. A notification can get
//! lost with a connection; a waiting task also polls, only slower.

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::{Notify, watch};
use tokio::task::JoinHandle;
use uuid::Uuid;

use super::postgres::Listener;
use super::readers::Readers;
use super::{Settings, StoreError};

/// The channel of notifications.
const CHANNEL: &str = "tabletopgen_changes";
/// Notifications of one process are at least this far apart.
const INTERVAL: Duration = Duration::from_millis(10);
/// Pause after the listening connection broke.
const RECONNECT: Duration = Duration::from_secs(1);

/// A kind of change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// Any change to a job.
    Job,
    /// A request to cancel; also a change to a job.
    Cancellation,
}

/// Ticks of this process; cloning shares them.
#[derive(Clone)]
pub(super) struct Changes {
    ticks: Arc<Ticks>,
    /// Notifies other processes until the last handle is dropped.
    _link: Option<Arc<Link>>,
}

struct Ticks {
    job: watch::Sender<u64>,
    cancellation: watch::Sender<u64>,
    /// Changes that other processes have not heard of yet.
    untold: [Notify; 2],
}

struct Link(Vec<JoinHandle<()>>);

impl Drop for Link {
    fn drop(&mut self) {
        self.0.iter().for_each(JoinHandle::abort);
    }
}

impl Changes {
    /// Changes of a database that only this process uses.
    pub(super) fn local() -> Self {
        Self { ticks: Arc::new(Ticks::new()), _link: None }
    }

    /// Changes of a PostgreSQL database that other processes use too.
    pub(super) async fn shared(url: &str, readers: Readers, settings: &Settings) -> Result<Self, StoreError> {
        let ticks = Arc::new(Ticks::new());
        let process = Uuid::new_v4().to_string();
        let listener = Listener::connect(url, settings.postgres.acquire_timeout()).await?;
        let tell =
            |change: Change| tokio::spawn(tell(readers.clone(), ticks.clone(), process.clone(), change));
        let tasks = vec![
            tell(Change::Job),
            tell(Change::Cancellation),
            tokio::spawn(listen(listener, ticks.clone(), process.clone())),
        ];
        Ok(Self { ticks, _link: Some(Arc::new(Link(tasks))) })
    }

    /// A change was committed.
    pub(super) fn announce(&self, change: Change) {
        self.ticks.tick(change);
        self.ticks.untold[change as usize].notify_one();
    }

    /// Ticks after every change to a job.
    pub(super) fn jobs(&self) -> watch::Receiver<u64> {
        self.ticks.job.subscribe()
    }

    /// Ticks after every request to cancel.
    pub(super) fn cancellations(&self) -> watch::Receiver<u64> {
        self.ticks.cancellation.subscribe()
    }
}

impl Ticks {
    fn new() -> Self {
        Self {
            job: watch::Sender::new(0),
            cancellation: watch::Sender::new(0),
            untold: [Notify::new(), Notify::new()],
        }
    }

    fn tick(&self, change: Change) {
        self.job.send_modify(|tick| *tick += 1);
        if change == Change::Cancellation {
            self.cancellation.send_modify(|tick| *tick += 1);
        }
    }
}

/// Tells other processes about changes of one kind.
async fn tell(readers: Readers, ticks: Arc<Ticks>, process: String, change: Change) {
    let payload = format!("{process} {change:?}");
    loop {
        ticks.untold[change as usize].notified().await;
        let notified =
            sqlx::query("SELECT pg_notify($1, $2)").bind(CHANNEL).bind(&payload).execute(&readers).await;
        if let Err(error) = notified {
            tracing::debug!(%error, "other processes got no notice of a change; they poll");
        }
        tokio::time::sleep(INTERVAL).await;
    }
}

/// Hears of changes of other processes.
async fn listen(mut listener: Listener, ticks: Arc<Ticks>, process: String) {
    while let Err(error) = listener.listen(CHANNEL).await {
        tracing::debug!(%error, "cannot listen for changes of other processes; polling");
        tokio::time::sleep(RECONNECT).await;
    }
    loop {
        match listener.heard().await {
            Ok(Some(payload)) => match payload.split_once(' ') {
                Some((teller, _)) if teller == process => {}
                Some((_, "Cancellation")) => ticks.tick(Change::Cancellation),
                _ => ticks.tick(Change::Job),
            },
            // The connection broke, and anything may have happened meanwhile.
            Ok(None) => ticks.tick(Change::Cancellation),
            Err(error) => {
                tracing::debug!(%error, "cannot listen for changes of other processes; polling");
                tokio::time::sleep(RECONNECT).await;
            }
        }
    }
}
