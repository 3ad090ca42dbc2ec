//! Persistent state: scenes, jobs, events, checkpoints, blobs and the ledger of remote calls.
//!
//! By default one data directory holds `tabletopgen.sqlite` and `blobs/` (immutable bytes named by their digest). The
//! settings may name a PostgreSQL database instead of the file, and other places for blobs. Blobs are written and
//! synced before the row that refers to them; the row is the commit point. No other user of the machine may read them
//! ([`private_files`]). One process at a time uses a data
//! directory: it holds an exclusive lock on the file `lock` while it runs. Therefore every lease found in a SQLite
//! file at start belongs to a dead process; in a shared database a lease ends by its time. The store does not
//! interpret blobs or requests.
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

pub mod lifecycle;
pub mod settings;
pub mod error;
pub mod digest;
pub mod outage;
mod private_files;
pub mod blobs;
mod readers;
mod list_query;
mod writer;
mod migrations;
mod database;
#[cfg(feature = "postgres")]
mod postgres;
#[cfg(not(feature = "postgres"))]
mod no_postgres;
mod changes;
mod readiness;
pub mod scenes;
pub mod lineage;
pub mod batches;
pub mod datasets;
pub mod recordings;
pub mod executions;
pub mod secret;
pub mod scopes;
pub mod keys;
pub mod sessions;
pub mod audit;
pub mod webhooks;
pub mod queue;
mod deaths;
pub mod stage_claims;
pub mod jobs;
pub mod outlook;
pub mod limits;
pub mod queue_depth;
pub mod events;
pub mod tenant_events;
pub mod checkpoints;
pub mod artifacts;
pub mod calls;
pub mod tasks;
pub mod answers;
pub mod rebuild;
pub mod deletion;
pub mod retention;
pub mod backup;
mod operator;
#[cfg(all(test, feature = "postgres"))]
mod tests;

use std::fs::{File, TryLockError};
use std::path::Path;
use std::sync::{Arc, LazyLock};

// The body of an `async fn` is compiled in every crate that awaits it, which for those with SQL takes minutes; that
// of a boxed future is compiled here, once.
use async_recursion::async_recursion as boxed;
use tokio::sync::watch;

pub use blobs::Blobs;
pub use digest::{Digest, DigestBuilder};
pub use error::StoreError;
pub use operator::Operator;
pub use outage::Outage;
pub use queue::Lease;
use scene::TenantId;
pub use settings::{BlobPlace, DatabaseAddress, DatabaseAddressError, PostgresSettings, Settings};

use changes::{Change, Changes};
#[cfg(not(feature = "postgres"))]
use no_postgres as postgres;
use outage::Health;
use readers::Readers;
use retention::Quota;
use writer::Writer;

/// Tenant of the operator: of the command line, of clients that are not authenticated, and of its own keys.
pub static DEFAULT_TENANT: LazyLock<TenantId> = LazyLock::new(|| "default".parse().expect("a valid id"));

/// Handle on the store; cloning shares it.
#[derive(Clone)]
pub struct Store {
    readers: Readers,
    writer: Writer,
    blobs: Blobs,
    changes: Changes,
    health: Health,
    /// Whether other processes use the same database.
    is_shared: bool,
    quota: Arc<Quota>,
    admission: Arc<limits::Admission>,
    paces: Arc<outlook::Paces>,
    readiness: Arc<readiness::Readiness>,
    /// Released with the last handle.
    _lock: Option<Arc<File>>,
}

/// Whether a database may be made where there is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Intent {
    /// For programs that make data: a missing database is created.
    Create,
    /// For commands on existing data: a missing database is an error, and nothing is created.
    Existing,
}

impl Store {
    /// Opens the store, and migrates its database if necessary; with [`Intent::Create`] it creates it. A data directory
    /// that holds the database or the blobs is locked by this process; it is not touched if neither is in it.
    ///
    /// # Errors
    ///
    /// [`StoreError::NoDatabase`] without a database to open, [`StoreError::Locked`] if another process uses the
    /// directory, [`StoreError::DataDir`] if it is not writable, [`StoreError::Migrate`] if the database belongs to a
    /// newer version, [`StoreError::Sql`] if it cannot be reached.
    pub async fn open(data_dir: &Path, settings: &Settings, intent: Intent) -> Result<Self, StoreError> {
        let health = Health::new();
        if intent == Intent::Existing && settings.database == DatabaseAddress::Sqlite {
            database::sqlite_exists(&data_dir.join(backup::DATABASE_FILE))?;
        }
        let uses_directory =
            settings.database == DatabaseAddress::Sqlite || settings.blobs == BlobPlace::Files;
        let lock = uses_directory.then(|| directory(data_dir)).transpose()?;
        let (readers, writer, changes) = match &settings.database {
            DatabaseAddress::Sqlite => {
                let path = data_dir.join(backup::DATABASE_FILE);
                let writer = Writer::sqlite(&path, settings, health.clone()).await?;
                (database::sqlite_readers(&path, settings).await?, writer, Changes::local())
            }
            DatabaseAddress::Postgres(url) => {
                let pool = postgres::pool(url, settings, intent).await?;
                let (prompt, unhurried) = (settings.postgres.prompt(), settings.postgres.unhurried());
                let readers = Readers::limited(pool.clone(), prompt, unhurried);
                let changes = Changes::shared(url, readers.clone(), settings).await?;
                (readers, Writer::postgres(pool, prompt, unhurried, health.clone()), changes)
            }
        };
        let blobs = Blobs::open(data_dir, settings, health.clone())?;
        let quota = Arc::new(Quota::default());
        let is_shared = settings.database != DatabaseAddress::Sqlite;
        Ok(Self {
            readers,
            writer,
            blobs,
            changes,
            health,
            is_shared,
            quota,
            admission: Arc::new(limits::Admission::new(settings.limits)),
            paces: Arc::default(),
            readiness: Arc::default(),
            _lock: lock.map(Arc::new),
        })
    }

    /// Whether other processes may use the same database, so that a lease of another owner may be alive.
    pub fn is_shared(&self) -> bool {
        self.is_shared
    }

    /// The blobs.
    pub fn blobs(&self) -> &Blobs {
        &self.blobs
    }

    /// Ticks after every change to a job, so that waiting tasks need not poll.
    pub fn changes(&self) -> watch::Receiver<u64> {
        self.changes.jobs()
    }

    /// Ticks after every cancellation request.
    pub fn cancellations(&self) -> watch::Receiver<u64> {
        self.changes.cancellations()
    }

    /// The present outage of storage; `None` while writes succeed.
    pub fn outage(&self) -> watch::Receiver<Option<Outage>> {
        self.health.outage()
    }

    fn announce(&self) {
        self.changes.announce(Change::Job);
    }

    fn announce_cancellation(&self) {
        self.admission.made_room();
        self.changes.announce(Change::Cancellation);
    }
}

/// Creates a data directory if it is missing, and takes its exclusive lock.
fn directory(data_dir: &Path) -> Result<File, StoreError> {
    private_files::whole_directory(data_dir)
        .map_err(|source| StoreError::DataDir { path: data_dir.to_owned(), source })?;
    let path = data_dir.join("lock");
    let failed = |source| StoreError::DataDir { path: path.clone(), source };
    let file = private_files::file(&path).map_err(failed)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(StoreError::Locked { path: data_dir.to_owned() }),
        Err(TryLockError::Error(source)) => Err(failed(source)),
    }
}
