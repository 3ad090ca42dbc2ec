//! What survives a restart: jobs, checkpoints, blobs, the ledger of remote calls.
//!
//! One data directory holds `tabletopgen.sqlite` (scenes, jobs, events, checkpoints, calls) and `blobs/`
//! (immutable bytes named by their digest), unless the settings keep those in memory. Blobs are written
//! and synced before the row that refers to them; the row is the commit point. One process at a time may
//! use a data directory: it holds an exclusive lock on `lock` for as long as it lives, so every lease
//! found at start belongs to the dead. The store never looks inside blobs or requests.

pub mod error;
pub mod digest;
pub mod outage;
pub mod blobs;
mod writer;
mod database;
pub mod scenes;
pub mod queue;
pub mod jobs;
pub mod events;
pub mod checkpoints;
pub mod artifacts;
pub mod calls;
pub mod tasks;
pub mod answers;

use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sqlx::SqlitePool;
use tokio::sync::watch;

pub use blobs::Blobs;
pub use digest::Digest;
pub use error::StoreError;
pub use outage::Outage;
pub use queue::Lease;

use outage::{Health, Part};
use writer::Writer;

/// Section `[store]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Wait for the disk at every commit and blob. `false` is faster and loses the newest work when the
    /// machine (not just the process) stops; meant for temporary data directories.
    pub fsync: bool,
    /// Where blobs are kept.
    pub blobs: BlobPlace,
    /// Connections that read at the same time (1..=64). More lets more API requests read at once.
    pub readers: u32,
    /// How long a statement waits for a locked database before it fails, milliseconds.
    pub busy_timeout_ms: u64,
}

/// Where blobs are kept.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum BlobPlace {
    /// Files in the data directory.
    Files,
    /// The process's memory: what they held is computed again after a restart.
    Memory,
}

/// Tenant of every row until there are keys that say otherwise.
pub const DEFAULT_TENANT: &str = "default";

/// Handle on the data directory; cloning shares it.
#[derive(Clone)]
pub struct Store {
    readers: SqlitePool,
    writer: Writer,
    blobs: Blobs,
    changed: Arc<watch::Sender<u64>>,
    cancelled: Arc<watch::Sender<u64>>,
    health: Health,
    /// Released when the last handle goes.
    _lock: Arc<File>,
}

impl Store {
    /// Opens (and where needed creates and migrates) the data directory, and locks it.
    pub async fn open(data_dir: &Path, settings: &Settings) -> Result<Self, StoreError> {
        std::fs::create_dir_all(data_dir)
            .map_err(|source| StoreError::DataDir { path: data_dir.to_owned(), source })?;
        let lock = lock(data_dir)?;
        let path: PathBuf = data_dir.join("tabletopgen.sqlite");
        let health = Health::new();
        let writer = Writer::start(&path, settings, health.clone()).await?;
        let readers = database::readers(&path, settings).await?;
        let blobs = match settings.blobs {
            BlobPlace::Files => Blobs::local(&data_dir.join("blobs"), settings.fsync, health.clone())?,
            BlobPlace::Memory => Blobs::in_memory(health.clone()),
        };
        Ok(Self {
            readers,
            writer,
            blobs,
            changed: Arc::new(watch::Sender::new(0)),
            cancelled: Arc::new(watch::Sender::new(0)),
            health,
            _lock: Arc::new(lock),
        })
    }

    /// The bytes.
    pub fn blobs(&self) -> &Blobs {
        &self.blobs
    }

    /// Ticks after every change to a job; for whoever waits on rows instead of polling them.
    pub fn changes(&self) -> watch::Receiver<u64> {
        self.changed.subscribe()
    }

    /// Ticks after every cancellation request.
    pub fn cancellations(&self) -> watch::Receiver<u64> {
        self.cancelled.subscribe()
    }

    /// Why storage takes no writes at present, and when that changes; `None` while it does.
    pub fn outage(&self) -> watch::Receiver<Option<Outage>> {
        self.health.outage()
    }

    /// The database answers a read and a write; while there is an outage, something is really written.
    pub async fn is_healthy(&self) -> Result<(), StoreError> {
        sqlx::query("SELECT 1 FROM jobs LIMIT 1").fetch_optional(&self.readers).await?;
        if self.health.is_failing(Part::Blobs) {
            self.blobs.put(vec![0; 64 << 10]).await?;
        }
        self.writer.write("check the writer", |_| Box::pin(async { Ok(()) })).await
    }

    fn announce(&self) {
        self.changed.send_modify(|tick| *tick += 1);
    }
}

/// Takes the exclusive lock of a data directory, or says who is in the way.
fn lock(data_dir: &Path) -> Result<File, StoreError> {
    let path = data_dir.join("lock");
    let failed = |source| StoreError::DataDir { path: path.clone(), source };
    let file = OpenOptions::new().create(true).truncate(false).write(true).open(&path).map_err(failed)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(StoreError::Locked { path: data_dir.to_owned() }),
        Err(TryLockError::Error(source)) => Err(failed(source)),
    }
}
