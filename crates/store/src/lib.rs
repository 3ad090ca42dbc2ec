//! Persistent state: scenes, jobs, events, checkpoints, blobs and the ledger of remote calls.
//!
//! One data directory holds `tabletopgen.sqlite` and `blobs/` (immutable bytes named by their digest), unless the
//! settings keep blobs in memory. Blobs are written and synced before the row that refers to them; the row is the
//! commit point. One process at a time uses a data directory: it holds an exclusive lock on the file `lock` while it
//! runs. Therefore every lease found at start belongs to a dead process. The store does not interpret blobs or
//! requests.
//!
//! The crate must not depend on the pipeline, providers or the API. Every query of a client's data takes the tenant.
//!
//! ```
//! use store::Digest;
//!
//! let digest = Digest::of(b"");
//! assert_eq!(Digest::parse(digest.as_str())?, digest);
//! # Ok::<(), store::StoreError>(())
//! ```

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
#[cfg(test)]
mod tests;

use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use serde::{Deserialize, Serialize};
use sqlx::SqlitePool;
use tokio::sync::watch;

pub use blobs::Blobs;
pub use digest::Digest;
pub use error::StoreError;
pub use outage::Outage;
pub use queue::Lease;
use scene::TenantId;

use outage::{Health, Part};
use writer::Writer;

/// Section `[store]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Sync to disk at every commit and blob. `false` is faster and may lose the latest work if the machine (not only
    /// the process) stops; intended for temporary data directories.
    pub fsync: bool,
    /// Where blobs are kept.
    pub blobs: BlobPlace,
    /// Number of read connections (1..=64). More connections serve more API requests concurrently.
    pub readers: u32,
    /// Time that a statement waits for a locked database before it fails, milliseconds.
    pub busy_timeout_ms: u64,
}

/// Where blobs are kept.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum BlobPlace {
    /// Files in the data directory.
    Files,
    /// Memory of the process: their content is computed again after a restart.
    Memory,
}

/// Tenant of every row until API keys exist.
pub static DEFAULT_TENANT: LazyLock<TenantId> = LazyLock::new(|| "default".parse().expect("a valid id"));

/// Handle on the data directory; cloning shares it.
#[derive(Clone)]
pub struct Store {
    readers: SqlitePool,
    writer: Writer,
    blobs: Blobs,
    changed: Arc<watch::Sender<u64>>,
    cancelled: Arc<watch::Sender<u64>>,
    health: Health,
    /// Released with the last handle.
    _lock: Arc<File>,
}

impl Store {
    /// Opens and locks the data directory; creates and migrates it if necessary.
    ///
    /// # Errors
    ///
    /// [`StoreError::Locked`] if another process uses the directory, [`StoreError::DataDir`] if it is not writable,
    /// [`StoreError::Migrate`] if the database belongs to a newer version.
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

    /// The blobs.
    pub fn blobs(&self) -> &Blobs {
        &self.blobs
    }

    /// Ticks after every change to a job, so that waiting tasks need not poll.
    pub fn changes(&self) -> watch::Receiver<u64> {
        self.changed.subscribe()
    }

    /// Ticks after every cancellation request.
    pub fn cancellations(&self) -> watch::Receiver<u64> {
        self.cancelled.subscribe()
    }

    /// The present outage of storage; `None` while writes succeed.
    pub fn outage(&self) -> watch::Receiver<Option<Outage>> {
        self.health.outage()
    }

    /// Checks a read and a write of the database. During an outage of the blobs, a probe blob is written.
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

/// Takes the exclusive lock of a data directory.
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
